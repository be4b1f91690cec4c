//! The lens in a native scene file: `lens` of `[camera]` with its numbers, and its size, `aperture` and `focus`.

use super::table::TomlTable;
use crate::read::cameras::{LensName, NamedLens};
use halfline::error::{Error, Result, relocate};
use halfline::scene::ImagePlane;
use halfline::scene::camera::{Aperture, Camera, Intrinsics, Lens};

/// The keys of focal lengths and of the principal point.
const PIXELS: [&str; 4] = ["fx", "fy", "cx", "cy"];

/// The lens that `lens` names, whose pixels are the image's; `None` without the key.
pub(super) fn named(table: &TomlTable<'_>, image: &ImagePlane) -> Result<Option<Lens>> {
    let Some(value) = table.get("lens") else {
        let idle = PIXELS.iter().chain(&["coefficients"]).find_map(|key| table.get(key));
        return match idle {
            Some(idle) => {
                let mend = "add lens = \"opencv\" or lens = \"fisheye\", or remove it";
                Err(Error::scene(idle.place(), "it belongs to a lens with a name", mend))
            }
            None => Ok(None),
        };
    };
    let name = value.string()?.parse::<LensName>().map_err(|error| match error {
        Error::Settings { problem, mend } => Error::scene(value.place(), problem, mend),
        other => other,
    })?;
    if let Some(other) = ["viewport", "height", "distance"].iter().find_map(|key| table.get(key)) {
        let problem = format!("the lens {} has none", name.name());
        return Err(Error::scene(other.place(), problem, "remove it, or remove lens"));
    }
    let vfov = table.get("vfov").map(|degrees| degrees.number()).transpose()?;
    let pixels = PIXELS.iter().any(|key| table.get(key).is_some());
    let pixels = pixels.then(|| {
        let of = |key| table.need(key)?.number();
        Ok(Intrinsics { fx: of("fx")?, fy: of("fy")?, cx: of("cx")?, cy: of("cy")? })
    });
    let coefficients = table.get("coefficients").map_or(Ok(Vec::new()), |list| list.list())?;
    let words = ["vfov", "fx, fy, cx, cy", "coefficients"];
    let lens = NamedLens { name, vfov, intrinsics: pixels.transpose()?, coefficients: &coefficients, words };
    lens.lens(image.width, image.height).map(Some).map_err(|(key, problem, mend)| {
        let key = ["vfov", "fx", "coefficients"][key];
        Error::scene(table.place_of(key, "lens").named(format!("camera.{key}")), problem, mend)
    })
}

/// The lens of a camera, which is a pinhole without `aperture`.
pub(super) fn read(table: &TomlTable<'_>, camera: &Camera) -> Result<Option<Aperture>> {
    let number = |key| table.get(key).map(|value| value.number()).transpose();
    let (diameter, focus) = (number("aperture")?, number("focus")?);
    let Some(diameter) = diameter else {
        return match table.get("focus") {
            Some(focus) => {
                let problem = "all is in focus without an aperture";
                Err(Error::scene(
                    focus.place(),
                    problem,
                    "add aperture = 0.1, the diameter of the lens, or remove focus",
                ))
            }
            None => Ok(None),
        };
    };
    let aperture = Aperture { diameter, focus };
    let locate = |field: &str| table.place_of(field.trim_start_matches("camera."), "aperture").named(field);
    aperture.distance(camera).map_err(|error| relocate(error, locate))?;
    Ok(Some(aperture))
}
