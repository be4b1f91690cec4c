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
use halfline::quote::setting::{HIDE, MARK, MARK_ALL, OPACITY, SIZE, VIEW};
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
    /// Adds marks of things in a whole frame of a scene, in their order: of things among the `ids` of its pixels, and of things
    /// visible through translucent spheres. For these `render` renders a frame without translucent spheres. With `all`, adds also marks of
    /// hidden things in front of the camera. Returns a warning about things that find no place.
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
    ) -> Result<Vec<String>> {
        if things.is_empty() {
            return Ok(Vec::new());
        }
        let size = [scene.image.width, scene.image.height];
        let projector = scene.camera.projector(size)?;
        let visible = VisibleThings::new(size.map(|side| side as usize), things, &images_of(scene, ids, render)?);
        // Visible things have their places before hidden ones.
        let (mut targets, mut hidden) = (Vec::new(), Vec::new());
        for (number, (text, ids)) in things.iter().enumerate() {
            match visible.thing(number) {
                Some(thing) => targets.push((&text[..], Target::Visible(thing))),
                None => hidden.push((&text[..], ids)),
            }
        }
        let unseen = (!all).then(|| unseen(&hidden, things.len())).flatten();
        let behind = hidden.into_iter().filter(|_| all);
        targets.extend(behind.filter_map(|(text, ids)| Some((text, Target::Hidden(disc(scene, &projector, ids)?)))));
        let left_out = self.mark(size, is_dark(scene.image.background), &visible, &targets);
        let warning = || {
            let (some, all) = (left_out.len(), count(targets.len() as u64, "mark"));
            let problem =
                format!("{some} of {all} have no place in the picture beside the others ({})", list(&left_out));
            format!("{problem}: a larger {SIZE}, or fewer by {MARK}, leave more room")
        };
        Ok((!left_out.is_empty()).then(warning).into_iter().chain(unseen).collect())
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
            let placed = page.haloed(&shown, are_light).and_then(|sheet| {
                let size = [sheet.width(), sheet.height()].map(i64::from);
                let place = self.place(&page, visible, target, size)?;
                self.lines.extend(place.line.and_then(|line| page.line_to(line, are_light)));
                Some(Panel { at: place.at.map(|x| x as usize), sheet })
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

/// A warning about marks of hidden things, which are not drawn; `None` without any.
fn unseen(hidden: &[(&str, &Vec<u32>)], count_of_all: usize) -> Option<String> {
    let texts: Vec<&str> = hidden.iter().map(|(text, _)| *text).collect();
    let (some, all) = (texts.len(), count(count_of_all as u64, "mark"));
    (some > 0).then(|| {
        let name = if count_of_all == 1 { "names" } else { "name" };
        let problem = format!("{some} of {all} {name} what no pixel shows ({})", list(&texts));
        format!(
            "{problem}: {HIDE} of what is in front or another {VIEW} may show it, in pixels also {OPACITY} below 1 for all but what is \
             named; {MARK_ALL} writes them anyway"
        )
    })
}

/// The ids that the pixels of a frame show, and where spheres are translucent also the ids of a frame of the opaque ones alone,
/// which `render` renders.
///
/// # Errors
/// Errors of `render`.
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
    use halfline::camera::{Camera, Lens};
    use halfline::frame::Aov;
    use halfline::render::Renderer;
    use halfline::scene::{ImagePlane, Lighting, Spheres};
    use halfline::settings::{Backend, Settings};

    const SIZE: [usize; 2] = [400, 300];

    /// An image of ids with discs; later discs are before earlier ones.
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
            [panel.at[0] + panel.sheet.width() as usize / 2, panel.at[1] + panel.sheet.height() as usize / 2]
        };
        assert!(middle(on)[0].abs_diff(200) <= 1 && middle(on)[1].abs_diff(150) <= 1, "{:?}", middle(on));
        assert_eq!(other.at[0], 324);
        assert!(middle(other)[1].abs_diff(50) <= 1 && panels.lines.is_empty());
    }

    /// Readers take a text for the name of what it is nearest to.
    #[test]
    fn a_text_is_not_as_near_to_another_thing() {
        // To the right of the first thing there is room, but the other one is right below.
        let mut panels = Panels::default();
        let things = each(2);
        let visible = VisibleThings::new(SIZE, &things, &[discs(SIZE, &[([200, 150], 6), ([225, 166], 6)])]);
        assert_eq!(panels.mark([400, 300], false, &visible, &targets(&things, &visible)[..1]), [""; 0]);
        let Panel { at: [_, top], sheet } = &panels.panels[0];
        let bottom = top + sheet.height() as usize;
        assert!(
            panels.lines.is_empty() && bottom + 4 < 160,
            "the text ends at {bottom}, the other thing begins at 160"
        );
    }

    /// Spheres at random, many behind others, in things of up to five, in every third scene some without a thing.
    fn random_scene(next: &mut impl FnMut(u32) -> u32, scene: u32) -> (Scene, Vec<Thing>) {
        let mut at = |reach: u32| f64::from(next(2000)) * 1e-3 * f64::from(reach) - f64::from(reach);
        let mut spheres = Spheres::default();
        for _ in 0..30 {
            let radius = 0.15 + (at(1) + 1.0) * 0.5;
            spheres.push([at(5), at(4), at(4)], radius, None);
        }
        let lens = Lens::Vfov { degrees: 45.0, distance: 1.0 };
        let camera = Camera { eye: [0.0, 0.0, 14.0].into(), lens, ..Camera::CANONICAL };
        let image = ImagePlane { width: 320, height: 240, ..ImagePlane::default() };
        let (mut things, mut first) = (Vec::new(), 0);
        let named = if scene.is_multiple_of(3) { 18 } else { 30 };
        while first < named {
            let count = (1 + next(5)).min(named - first);
            things.push((format!("N{first}{}", "m".repeat(next(6) as usize)), (first..first + count).collect()));
            first += count;
        }
        (Scene { camera, image, spheres, lighting: Lighting::default() }, things)
    }

    /// Each name of 200 scenes is looked up in the frame's ids: it begins at a pixel of its thing, or a line from one leads to it; and no
    /// pixel of its rectangle shows another thing, nor is one of another name.
    #[test]
    fn names_are_on_what_they_name_by_the_ids_of_the_frame() {
        let settings = Settings { aovs: vec![Aov::Id], backend: Backend::Cpu, ..Settings::default() };
        let mut renderer = Renderer::new(&settings).expect("a renderer");
        let mut bits = 0x2545_f491_4f6c_dd1d_u64;
        let mut next = |most: u32| {
            bits = bits.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (bits >> 33) as u32 % most
        };
        let (mut on, mut adjacent, mut lines, mut left_out, mut hidden) = (0, 0, 0, 0, 0);
        for number in 0..200 {
            let (scene, things) = random_scene(&mut next, number);
            let ids = renderer.render(&scene, &settings).expect("a frame").ids().to_vec();
            let visible = VisibleThings::new([320, 240], &things, std::slice::from_ref(&ids));
            let mut panels = Panels::default();
            let mut rectangles: Vec<[usize; 4]> = Vec::new();
            let mut thing_of = [None; 30];
            (0..).zip(&things).for_each(|(n, (_, ids))| ids.iter().for_each(|id| thing_of[*id as usize] = Some(n)));
            let named = |[x, y]: [usize; 2]| usize::try_from(ids[y * 320 + x]).ok().and_then(|id| thing_of[id]);
            for (n, (text, _)) in things.iter().enumerate() {
                let Some(thing) = visible.thing(n) else {
                    hidden += 1;
                    continue;
                };
                let before = [panels.panels.len(), panels.lines.len()];
                if !panels.mark([320, 240], true, &visible, &[(text, Target::Visible(thing))]).is_empty() {
                    left_out += 1;
                    continue;
                }
                let Panel { at: [left, top], sheet } = &panels.panels[before[0]];
                let [right, bottom] = [left + sheet.width() as usize, top + sheet.height() as usize];
                assert!(right <= 320 && bottom <= 240, "{number} {text}");
                let is_own = |at: [usize; 2]| named(at) == Some(n);
                let inside = (*top..bottom).flat_map(|y| (*left..right).map(move |x| [x, y]));
                let mut share = 0.0;
                for at in inside {
                    assert!(named(at).is_none_or(|other| other == n), "{number} {text}: {at:?} is of another");
                    share += if is_own(at) { 1.0 } else { 0.0 };
                }
                share /= ((right - left) * (bottom - top)) as f64;
                match panels.lines.get(before[1]) {
                    Some((line, _)) => {
                        assert!(is_own(line.from.map(|x| x as usize)), "{number} {text}: {line:?}");
                        lines += 1;
                    }
                    None => {
                        let [columns, rows] = [(*left, right, 320), (*top, bottom, 240)]
                            .map(|(from, to, side)| from.saturating_sub(1)..=to.min(side - 1));
                        let mut touched = rows.flat_map(|y| columns.clone().map(move |x| [x, y]));
                        assert!(touched.any(is_own), "{number} {text} is at no pixel of its own");
                        *if share > 0.9 { &mut on } else { &mut adjacent } += 1;
                    }
                }
                let is_apart = |[a, b, c, d]: &[usize; 4]| right <= *a || *c <= *left || bottom <= *b || *d <= *top;
                assert!(rectangles.iter().all(is_apart), "{number} {text} is on another name");
                rectangles.push([*left, *top, right, bottom]);
            }
        }
        let counts = [on, adjacent, lines, left_out, hidden];
        assert!(
            counts.iter().filter(|count| **count > 20).count() >= 4,
            "on, adjacent, with a line, left out, hidden: {counts:?}"
        );
        println!("on, adjacent, with a line, left out, hidden: {counts:?}");
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
