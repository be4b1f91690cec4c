//! Cameras that show a scene.

use crate::camera::{Camera, LensArgument, lens_of};
use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::work::begin;
use halfline::camera::Look;
use halfline::scene::{Facing, Framing, NamedView, Spread, Surroundings};
use halfline::{Camera as CoreCamera, Error};
use halfline_command::choices::in_keywords;
use pyo3::prelude::*;

/// A camera that shows all spheres of a scene, or the spheres of `focus`, from a direction or one with a name, and a warning.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the arguments of `Camera.fit` in Python")]
pub(crate) fn fit_camera(
    scene: &Scene,
    view: Option<[f64; 3]>,
    named: Option<&str>,
    up: Option<[f64; 3]>,
    lens: LensArgument,
    size: (u32, u32),
    margin: f64,
    focus: Option<Vec<bool>>,
    share: f64,
) -> PyResult<(Camera, Option<String>)> {
    begin()?;
    if !(0.0..1.0).contains(&margin) {
        let problem = format!("margin is {margin}");
        return Err(Error::settings(problem, "give a share of the image from 0 to less than 1")).or_raise();
    }
    let framed = scene.sized(None, Some(size)).or_raise()?;
    let framing = Framing { margin, ..Framing::default() };
    let image = framed.image;
    let mut camera = CoreCamera { lens: lens_of(&lens, Some(size)).or_raise()?, ..framed.camera };
    let named = named.map(str::parse::<NamedView>).transpose().or_raise()?;
    let fixed = match (view, named) {
        (Some(view), _) => Some(Facing { view: view.into(), ..Facing::FRONT }),
        (None, named) => named.unwrap_or(NamedView::Front).facing(),
    };
    let with_up = |facing: Facing| Facing { up: up.map_or(facing.up, Into::into), ..facing };
    let Some(focus) = focus else {
        if !(share > 0.0 && share <= 1.0) {
            return Err(Error::settings(format!("share is {share}"), "give a number above 0 and at most 1")).or_raise();
        }
        let shown = if share < 1.0 { &framed.spheres.central(share) } else { &framed.spheres };
        let facing = match fixed {
            Some(facing) => facing,
            None => Spread::of(shown).or_raise()?.facing(size.1 > size.0),
        };
        with_up(facing).turn(&mut camera);
        camera.fit(image, shown, &framing).or_raise()?;
        return Ok((Camera::of(camera, None, size), None));
    };
    let part = framed.spheres.part(&focus);
    if part.is_empty() {
        return Err(Error::settings("focus selects no sphere", "give a mask with a sphere in it")).or_raise();
    }
    let around = Surroundings::new(image, &part, &framed.spheres, &framing);
    let facing = match fixed {
        Some(facing) => facing,
        None => {
            let found = around.least_hidden(&camera).or_raise()?.camera;
            let view = match found.look {
                Look::View(view) => view,
                Look::At(at) => at - found.eye,
            };
            Facing { view, up: found.up }
        }
    };
    let found = around.look(with_up(facing), &camera).or_raise()?;
    let warning = found.warning(fixed.is_none()).map(|warning| in_keywords(&warning));
    Ok((Camera::of(found.camera, None, size), warning))
}
