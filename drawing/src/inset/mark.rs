//! Marks of a picture: texts at pixels of the things that they name, or with a line from there, none over another.

mod place;
mod visible;

use super::Panels;
use super::page::Page;
use super::page::Panel;
use crate::canvas::plain;
use crate::raster::missing;
use glam::DVec2;
use halfline::camera::Projector;
use halfline::error::Result;
use halfline::frame::Frame;
use halfline::quote::setting::{MARK, SIZE};
use halfline::quote::{count, list};
use halfline::scene::Scene;
use place::{Disc, Target};
pub use visible::Thing;
use visible::VisibleThings;

/// Whether dark letters are hard to read on a colour in linear light: of less luminance than a middle grey.
fn is_dark([red, green, blue]: [f32; 3]) -> bool {
    0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.18
}

impl Panels {
    /// Adds marks of things in a whole frame of a scene, in their order: of those among the `ids` of its pixels, and of those that are
    /// visible through translucent spheres, of which `render` renders a frame without them; with `all` also of those that are hidden, in
    /// front of the camera. Returns a warning about those that find no place.
    ///
    /// # Errors
    /// Errors of [`Camera::projector`](halfline::Camera::projector) and of `render`.
    pub fn add_marks(
        &mut self,
        scene: &Scene,
        things: &[Thing],
        ids: &[i32],
        all: bool,
        render: impl FnOnce(&Scene) -> Result<Frame>,
    ) -> Result<Option<String>> {
        if things.is_empty() {
            return Ok(None);
        }
        let size = [scene.image.width, scene.image.height];
        let projector = scene.camera.projector(size)?;
        let visible = VisibleThings::new(size.map(|side| side as usize), things, &images_of(scene, ids, render)?);
        let mut targets = Vec::new();
        for (number, (text, ids)) in things.iter().enumerate() {
            let target = match visible.thing(number) {
                Some(thing) => Some(Target::Visible(thing)),
                None if all => disc(scene, &projector, ids).map(Target::Hidden),
                None => None,
            };
            targets.extend(target.map(|target| (&text[..], target)));
        }
        let left_out = self.mark(size, is_dark(scene.image.background), &visible, &targets);
        let warning = || {
            let (some, all) = (left_out.len(), count(targets.len() as u64, "mark"));
            let problem =
                format!("{some} of {all} have no place in the picture beside the others ({})", list(&left_out));
            format!("{problem}: a larger {SIZE}, or fewer by {MARK}, leave more room")
        };
        Ok((!left_out.is_empty()).then(warning))
    }

    /// Adds marks to a picture of this size, light ones with a dark halo or dark ones with a light halo, in their order. Returns the
    /// texts of those that have no place in the picture beside the others.
    fn mark<'a>(
        &mut self,
        [width, height]: [u32; 2],
        are_light: bool,
        visible: &VisibleThings,
        targets: &[(&'a str, Target<'_>)],
    ) -> Vec<&'a str> {
        let page = Page::new(width, height);
        let mut left_out = Vec::new();
        for (text, target) in targets {
            let shown = plain(text);
            let placed = page.haloed(&shown, are_light).and_then(|pixels| {
                let size = [pixels.width(), pixels.height()].map(i64::from);
                let place = self.place(&page, visible, target, size)?;
                self.lines.extend(place.line.and_then(|line| page.line_to(line, are_light)));
                Some(Panel { at: place.at.map(|x| x as usize), pixels })
            });
            match placed {
                Some(panel) => {
                    self.unknown.extend(missing(&shown, false));
                    self.panels.push(panel);
                }
                None => left_out.push(*text),
            }
        }
        left_out
    }
}

/// The ids that the pixels of a frame show, and where spheres are translucent those of the opaque ones alone, of which `render`
/// renders a frame.
///
/// # Errors
/// Those of `render`.
fn images_of(scene: &Scene, ids: &[i32], render: impl FnOnce(&Scene) -> Result<Frame>) -> Result<Vec<Vec<i32>>> {
    let mut all = vec![ids.to_vec()];
    if scene.spheres.is_translucent() {
        let is_opaque: Vec<bool> = (0..scene.spheres.len() as u32).map(|id| scene.spheres.opacity(id) == 1.0).collect();
        let opaque: Vec<i32> = (0..).zip(&is_opaque).filter(|(_, flag)| **flag).map(|(id, _)| id).collect();
        let (spheres, lighting) = (scene.spheres.part(&is_opaque), Default::default());
        let frame = render(&Scene { camera: scene.camera, image: scene.image, spheres, lighting })?;
        let of_all = |id: &i32| usize::try_from(*id).ok().and_then(|id| opaque.get(id)).copied().unwrap_or(-1);
        all.push(frame.ids().iter().map(of_all).collect());
    }
    Ok(all)
}

/// The middle of some spheres in the picture, and half of the width of the disc around them; `None` where the lens sees none of their
/// centres.
fn disc(scene: &Scene, projector: &Projector, ids: &[u32]) -> Option<Disc> {
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
    Some(Disc { at: [middle.x, middle.y].map(|x| x.floor() as i64), reach: reach.round() as i64 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [400, 300];

    /// An image of ids with discs, of which later ones are before earlier ones.
    fn discs(size: [usize; 2], discs: &[([i64; 2], i64)]) -> Vec<i32> {
        let mut ids = vec![-1; size[0] * size[1]];
        for (id, ([x, y], radius)) in (0..).zip(discs) {
            let [columns, rows] = [(x, size[0]), (y, size[1])]
                .map(|(middle, side)| (middle - radius).max(0)..(middle + radius + 1).min(side as i64));
            for [column, row] in rows.flat_map(|row| columns.clone().map(move |column| [column, row])) {
                if (column - x).pow(2) + (row - y).pow(2) <= radius * radius {
                    ids[row as usize * size[0] + column as usize] = id;
                }
            }
        }
        ids
    }

    /// Things of one disc each.
    fn each(count: u32) -> Vec<Thing> {
        (0..count).map(|id| (format!("Io{id}"), vec![id])).collect()
    }

    fn targets<'a>(things: &'a [Thing], visible: &'a VisibleThings) -> Vec<(&'a str, Target<'a>)> {
        let of = |(n, (text, _)): (usize, &'a Thing)| Some((&text[..], Target::Visible(visible.thing(n)?)));
        things.iter().enumerate().filter_map(of).collect()
    }

    #[test]
    fn a_text_is_on_a_wide_thing_and_next_to_a_small_one() {
        let mut panels = Panels::default();
        let things = each(2);
        let visible = VisibleThings::new(SIZE, &things, &[discs(SIZE, &[([200, 150], 60), ([320, 50], 3)])]);
        assert_eq!(panels.mark([400, 300], false, &visible, &targets(&things, &visible)), [""; 0]);
        let [on, other] = &panels.panels[..] else { panic!("two marks") };
        let middle = |panel: &Panel| {
            [panel.at[0] + panel.pixels.width() as usize / 2, panel.at[1] + panel.pixels.height() as usize / 2]
        };
        assert!(middle(on)[0].abs_diff(200) <= 1 && middle(on)[1].abs_diff(150) <= 1, "{:?}", middle(on));
        assert_eq!(other.at[0], 324);
        assert!(middle(other)[1].abs_diff(50) <= 1 && panels.lines.is_empty());
    }

    /// Discs at random, many of them behind others: a text is on its thing or begins at a pixel of it, or at the end of a line from one;
    /// no text covers another, and one that can be elsewhere covers no other thing.
    #[test]
    fn texts_begin_at_pixels_of_what_they_name() {
        let mut bits = 0x2545_f491_4f6c_dd1d_u64;
        let mut next = |most: i64| {
            bits = bits.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (bits >> 33) as i64 % most
        };
        let (mut on, mut adjacent, mut lines, mut covering) = (0, 0, 0, 0);
        for _ in 0..4 {
            let all: Vec<([i64; 2], i64)> = (0..40).map(|_| ([next(400), next(300)], 2 + next(28))).collect();
            let (things, ids) = (each(40), discs(SIZE, &all));
            let visible = VisibleThings::new(SIZE, &things, std::slice::from_ref(&ids));
            let mut panels = Panels::default();
            for (text, target) in targets(&things, &visible) {
                let Target::Visible(thing) = &target else { panic!("{text} is visible") };
                let page = Page::new(400, 300);
                let size = page
                    .haloed(text, false)
                    .map(|pixels| [pixels.width(), pixels.height()].map(i64::from))
                    .expect(text);
                let before = panels.panels.len();
                let place = panels.place(&page, &visible, &target, size);
                let left_out = panels.mark([400, 300], false, &visible, &[(text, Target::Visible(thing))]);
                assert_eq!(place.is_none(), !left_out.is_empty(), "{text}");
                let Some(place) = place else { continue };
                assert_eq!(panels.panels[before].at.map(|x| x as i64), place.at, "{text}");
                let ([x, y], [wide, high]) = (place.at, size);
                let touched = (x - 1..=x + wide).flat_map(|x| (y - 1..=y + high).map(move |y| [x, y]));
                match place.line {
                    Some(line) => assert!(visible.shows(thing, line.from), "{text}: {line:?}"),
                    None => assert!(touched.into_iter().any(|at| visible.shows(thing, at)), "{text}: {place:?}"),
                }
                let inside = || (x..x + wide).flat_map(|x| (y..y + high).map(move |y| [x, y]));
                let share = |keep: &dyn Fn([i64; 2]) -> bool| {
                    inside().filter(|at| keep(*at)).count() as f32 / (wide * high) as f32
                };
                let is_on = share(&|at| visible.shows(thing, at)) > 0.9;
                covering += usize::from(share(&|at| visible.covers(Some(thing), at) > 0.0) > 0.2);
                *if place.line.is_some() {
                    &mut lines
                } else if is_on {
                    &mut on
                } else {
                    &mut adjacent
                } += 1;
            }
            let ends = |panel: &Panel| {
                [panel.at[0] + panel.pixels.width() as usize, panel.at[1] + panel.pixels.height() as usize]
            };
            for (n, a) in panels.panels.iter().enumerate() {
                assert!(ends(a)[0] <= 400 && ends(a)[1] <= 300);
                for b in &panels.panels[n + 1..] {
                    assert!((0..2).any(|k| a.at[k] >= ends(b)[k] || b.at[k] >= ends(a)[k]), "{:?} {:?}", a.at, b.at);
                }
            }
        }
        assert!(on > 20 && adjacent > 20 && lines > 0, "{on} on, {adjacent} adjacent, {lines} with a line");
        assert!(covering * 10 < on + adjacent + lines, "{covering} of {}", on + adjacent + lines);
    }

    #[test]
    fn no_text_covers_another_or_leaves_the_picture() {
        let size = [100, 60];
        let places: Vec<([i64; 2], i64)> = (0..40).map(|n| ([50 + n % 7, 30 + n / 7], 0)).collect();
        let things = each(40);
        let visible = VisibleThings::new(size, &things, &[discs(size, &places)]);
        let mut panels = Panels::default();
        let left_out = panels.mark([100, 60], true, &visible, &targets(&things, &visible)).len();
        assert_eq!(left_out + panels.panels.len(), 40);
        assert!(panels.panels.len() >= 3, "{}", panels.panels.len());
    }
}
