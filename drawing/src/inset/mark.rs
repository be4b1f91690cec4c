//! Marks of a picture: texts beside the things that they name, dark with a light halo, none over another.

use super::page::Page;
use super::{Panel, Panels};
use crate::canvas::plain;
use crate::raster::missing;
use glam::DVec2;
use halfline::camera::Projector;
use halfline::error::Result;
use halfline::frame::Frame;
use halfline::quote::setting::{MARK, SIZE};
use halfline::quote::{count, list};
use halfline::scene::Scene;

/// Spheres of a scene, with the text that names them.
pub type Thing = (String, Vec<u32>);

/// A text at a thing in the picture.
#[derive(Debug, Clone, PartialEq)]
struct Mark {
    text: String,
    /// The middle of the thing, columns and rows of the picture.
    at: [f64; 2],
    /// Half of its width, pixels.
    reach: f64,
}

/// Whether dark letters are hard to read on a colour in linear light: of less luminance than a middle grey.
fn is_dark([red, green, blue]: [f32; 3]) -> bool {
    0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.18
}

/// A thing that is so many times as wide as its text has the text on it, else beside it.
const ROOMY: f32 = 1.15;

impl Panels {
    /// Adds marks of things in a whole frame of a scene, in their order: of those among the `ids` of its pixels, and of those that are
    /// seen through translucent spheres, of which `render` renders a frame without them; without ids of all in front of the camera.
    /// Returns a warning about those that find no place.
    ///
    /// # Errors
    /// Errors of [`Camera::projector`](halfline::Camera::projector) and of `render`.
    pub fn add_marks(
        &mut self,
        scene: &Scene,
        things: &[Thing],
        ids: Option<&[i32]>,
        render: impl FnOnce(&Scene) -> Result<Frame>,
    ) -> Result<Option<String>> {
        let all = ids.is_none();
        let shown = match ids.filter(|_| !things.is_empty()) {
            Some(ids) => visible_ids(scene, ids, render)?,
            None => Vec::new(),
        };
        let mut is_shown = vec![false; scene.spheres.len()];
        for id in shown.iter().filter_map(|id| usize::try_from(*id).ok()) {
            is_shown[id] = true;
        }
        let mut marks = Vec::new();
        let size = [scene.image.width, scene.image.height];
        let projector = scene.camera.projector(size)?;
        for (text, ids) in things.iter().filter(|(_, ids)| all || ids.iter().any(|id| is_shown[*id as usize])) {
            if let Some((at, reach)) = extent(scene, &projector, ids) {
                marks.push(Mark { text: text.clone(), at, reach });
            }
        }
        let left_out = self.mark(size, is_dark(scene.image.background), &marks);
        let warning = || {
            let (some, all) = (left_out.len(), count(marks.len() as u64, "mark"));
            let problem =
                format!("{some} of {all} have no place in the picture beside the others ({})", list(&left_out));
            format!("{problem}: a larger {SIZE}, or fewer by {MARK}, leave more room")
        };
        Ok((!left_out.is_empty()).then(warning))
    }

    /// Adds marks to a picture of this size, light ones with a dark halo or dark ones with a light halo, in their order: on their things
    /// where these are wide, else beside them. Returns the texts of those that have no place in the picture beside the others.
    fn mark<'a>(&mut self, [width, height]: [u32; 2], are_light: bool, marks: &'a [Mark]) -> Vec<&'a str> {
        let page = Page::new(width, height);
        let mut left_out = Vec::new();
        for mark in marks {
            let text = plain(&mark.text);
            let placed = page.haloed(&text, are_light).and_then(|pixels| {
                let size = [pixels.width() as f32, pixels.height() as f32];
                let at = places(mark, size).into_iter().find(|at| self.is_free(&page, *at, size))?;
                Some(Panel { at: at.map(|x| x as usize), pixels })
            });
            match placed {
                Some(panel) => {
                    self.unknown.extend(missing(&text, false));
                    self.panels.push(panel);
                }
                None => left_out.push(mark.text.as_str()),
            }
        }
        left_out
    }

    /// Whether a rectangle lies in the picture, beside all panels.
    fn is_free(&self, page: &Page, [left, top]: [f32; 2], [wide, high]: [f32; 2]) -> bool {
        let inside = left >= 0.0 && top >= 0.0 && left + wide <= page.width && top + high <= page.height;
        let is_apart = |panel: &Panel| {
            let [x, y] = panel.at.map(|x| x as f32);
            let [w, h] = [panel.pixels.width() as f32, panel.pixels.height() as f32];
            left >= x + w || x >= left + wide || top >= y + h || y >= top + high
        };
        inside && self.panels.iter().all(is_apart)
    }
}

/// The ids that the pixels of a frame show, with those of the opaque spheres that they show through translucent ones, of which
/// `render` renders a frame.
///
/// # Errors
/// Those of `render`.
fn visible_ids(scene: &Scene, ids: &[i32], render: impl FnOnce(&Scene) -> Result<Frame>) -> Result<Vec<i32>> {
    let mut all = ids.to_vec();
    if scene.spheres.is_translucent() {
        let is_opaque: Vec<bool> = (0..scene.spheres.len() as u32).map(|id| scene.spheres.opacity(id) == 1.0).collect();
        let opaque: Vec<i32> = (0..).zip(&is_opaque).filter(|(_, flag)| **flag).map(|(id, _)| id).collect();
        let (spheres, lighting) = (scene.spheres.part(&is_opaque), Default::default());
        let frame = render(&Scene { camera: scene.camera, image: scene.image, spheres, lighting })?;
        all.extend(frame.ids().iter().filter_map(|id| opaque.get(usize::try_from(*id).ok()?)));
    }
    Ok(all)
}

/// The middle of some spheres in the picture, and half of the width of the disc around them; `None` where the lens sees none of their
/// centres.
fn extent(scene: &Scene, projector: &Projector, ids: &[u32]) -> Option<([f64; 2], f64)> {
    let spheres = &scene.spheres;
    let disc = |id: &u32| {
        let n = *id as usize;
        let disc = projector.place(spheres.centers[n].into())?;
        Some((DVec2::from(disc.at), spheres.radii[n] * disc.scale))
    };
    let mut discs: Vec<(DVec2, f64)> = ids.iter().filter_map(disc).collect();
    let (first, _) = *discs.first()?;
    // The edges of a panorama are one line: what is beyond it belongs beside the first.
    let width = f64::from(scene.image.width);
    let turn = if scene.camera.lens.is_panorama() { width } else { 0.0 };
    if turn > 0.0 {
        discs.iter_mut().for_each(|(at, _)| at.x -= turn * ((at.x - first.x) / turn).round());
    }
    let mut middle = discs.iter().map(|(at, _)| *at).sum::<DVec2>() / discs.len() as f64;
    let reach = discs.iter().map(|(at, radius)| at.distance(middle) + radius).fold(0.0, f64::max);
    if turn > 0.0 {
        middle.x = middle.x.rem_euclid(turn);
    }
    Some((middle.to_array(), reach))
}

/// The places of a text of this size, in the order in which they are tried: whole columns and rows of its top left corner.
fn places(mark: &Mark, [wide, high]: [f32; 2]) -> Vec<[f32; 2]> {
    let ([x, y], reach) = (mark.at.map(|x| x as f32), mark.reach as f32);
    let middle = [x - wide / 2.0, y - high / 2.0];
    // Diagonals begin at the edge of a disc.
    let near = 0.71 * reach;
    let around = [
        [x + reach, middle[1]],
        [x + near, y - near - high],
        [x + near, y + near],
        [x - reach - wide, middle[1]],
        [middle[0], y - reach - high],
        [middle[0], y + reach],
    ];
    let on_it = Some(middle).filter(|_| 2.0 * reach >= ROOMY * wide.max(high));
    on_it.into_iter().chain(around).map(|at| at.map(f32::round)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(at: [f64; 2], reach: f64) -> Mark {
        Mark { text: "Io".into(), at, reach }
    }

    #[test]
    fn a_text_is_on_a_wide_thing_and_next_to_a_small_one() {
        let mut panels = Panels::default();
        let two = [mark([200.0, 150.0], 60.0), mark([320.0, 50.0], 3.0)];
        assert_eq!(panels.mark([400, 300], false, &two), [""; 0]);
        let [on, other] = &panels.panels[..] else { panic!("two marks") };
        let middle = |panel: &Panel| {
            [panel.at[0] + panel.pixels.width() as usize / 2, panel.at[1] + panel.pixels.height() as usize / 2]
        };
        assert_eq!(middle(on), [200, 150]);
        assert_eq!(other.at[0], 323);
        assert!(middle(other)[1].abs_diff(50) <= 1);
    }

    #[test]
    fn no_text_covers_another_or_leaves_the_picture() {
        let mut panels = Panels::default();
        let crowd: Vec<Mark> = (0..40).map(|n| mark([50.0 + f64::from(n % 7), 30.0 + f64::from(n / 7)], 2.0)).collect();
        let left_out = panels.mark([100, 60], true, &crowd).len();
        assert_eq!(left_out + panels.panels.len(), 40);
        assert!(panels.panels.len() >= 3, "{}", panels.panels.len());
        for (n, a) in panels.panels.iter().enumerate() {
            let end = |panel: &Panel| {
                [panel.at[0] + panel.pixels.width() as usize, panel.at[1] + panel.pixels.height() as usize]
            };
            assert!(end(a)[0] <= 100 && end(a)[1] <= 60);
            for b in &panels.panels[n + 1..] {
                let apart = (0..2).any(|k| a.at[k] >= end(b)[k] || b.at[k] >= end(a)[k]);
                assert!(apart, "{:?} {:?}", a.at, b.at);
            }
        }
    }
}
