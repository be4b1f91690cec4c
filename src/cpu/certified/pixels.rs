//! What is written of a strip: the twin of main/certified.wgsl and of shade/, in loops over lanes.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::strip::{NearestTwos, Strip, StripAnswers};
use crate::answers::raw::{Piece, Raw};
use crate::certify::Certify;
use crate::certify::binned::BinnedScene;
use crate::kernel::Kernel;
use crate::number::vector::{Bits, LANES, pick};
use crate::shade::{Shade, color_of, to_world};
use crate::tile::TILE;
use crate::view::ray::{NONE, UNSURE};
use crate::view::{View, ViewRecord};
use std::ops::Range;

/// What the strips of a frame share.
pub(super) struct StripFrame<'a> {
    pub(super) certify: Certify<'a, f32>,
    shade: Option<Shade>,
    normal: bool,
    colors: Option<&'a [[f32; 3]]>,
    /// What a device has found; `None` where the search is to be done.
    pub(super) found: Option<&'a Raw>,
}

impl<'a> StripFrame<'a> {
    pub(super) fn new(
        kernel: &Kernel,
        view: &'a View,
        binned: &'a BinnedScene,
        colors: Option<&'a [[f32; 3]]>,
        found: Option<&'a Raw>,
    ) -> Self {
        let certify = Certify::new(&view.record, binned);
        Self { certify, shade: kernel.shade, normal: kernel.normal, colors, found }
    }
}

/// What is written of a strip, one array per component; anything where a buffer is not requested.
pub(super) struct Pixels {
    id: [u32; LANES],
    t: [f32; LANES],
    depth_interval: [f32; LANES],
    normal: [[f32; LANES]; 3],
    color: [[f32; LANES]; 3],
}

impl Pixels {
    const NONE: Self = Self {
        id: [NONE; LANES],
        t: [f32::MAX; LANES],
        depth_interval: [0.0; LANES],
        normal: [[0.0; LANES]; 3],
        color: [[0.0; LANES]; 3],
    };

    /// Of a strip whose rays end in `two`.
    #[inline(always)]
    pub(super) fn new<const SAMPLED: bool>(frame: &StripFrame<'_>, strip: &Strip<SAMPLED>, two: &NearestTwos) -> Self {
        let [red, green, blue, _] = frame.certify.view.background;
        let mut pixels = Self { color: [[red; LANES], [green; LANES], [blue; LANES]], ..Self::NONE };
        if two.slot == NearestTwos::NONE.slot {
            return pixels;
        }
        let answers = strip.certify_winners(&frame.certify, two);
        pixels.answer(&frame.certify, &answers, two);
        if frame.normal {
            pixels.turn(frame.certify.view, &answers, two);
        }
        if let Some(shade) = frame.shade {
            pixels.shade(frame, shade, strip, &answers, two);
        }
        pixels
    }

    // The loops below read copies and select by masks: so compilers make one vector of the lanes.

    #[inline(always)]
    fn answer(&mut self, certify: &Certify<'_, f32>, answers: &StripAnswers, two: &NearestTwos) {
        let (two, id, numbers) = (*two, answers.id, answers.numbers);
        for l in 0..LANES {
            let proved = (two.slot[l] == NONE) | certify.certain(&answers.get(l), [two.low[l], two.second[l]]);
            let proved = u32::all_if(proved);
            self.id[l] = (id[l] & proved) | (UNSURE & !proved);
        }
        for l in 0..LANES {
            let hit = u32::all_if(two.slot[l] != NONE);
            self.t[l] = pick(hit, numbers[0][l], f32::MAX);
            self.depth_interval[l] = pick(hit, numbers[3][l], 0.0);
        }
    }

    /// World normals.
    #[inline(always)]
    fn turn(&mut self, view: &ViewRecord, answers: &StripAnswers, two: &NearestTwos) {
        let (view, slot, [_, _, _, _, x, y, z]) = (*view, two.slot, answers.numbers);
        let mut normal = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let [a, b, c] = to_world(&view, [x[l], y[l], z[l]]);
            let hit = u32::all_if(slot[l] != NONE);
            (normal[0][l], normal[1][l], normal[2][l]) = (pick(hit, a, 0.0), pick(hit, b, 0.0), pick(hit, c, 0.0));
        }
        self.normal = normal;
    }

    /// Colours of the hits; the others keep the background.
    #[inline(always)]
    fn shade<const SAMPLED: bool>(
        &mut self,
        frame: &StripFrame<'_>,
        shade: Shade,
        strip: &Strip<SAMPLED>,
        answers: &StripAnswers,
        two: &NearestTwos,
    ) {
        let mut own = [[0.0; LANES]; 3];
        for l in 0..LANES {
            if answers.id[l] != NONE {
                [own[0][l], own[1][l], own[2][l]] = color_of(frame.colors, answers.id[l]);
            }
        }
        let (view, slot, [_, _, _, _, x, y, z]) = (*frame.certify.view, two.slot, answers.numbers);
        let behind = self.color;
        let mut color = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let s = strip.slopes(0, l);
            let rgb = shade.of(&view, [s.x, s.y, -1.0], [x[l], y[l], z[l]], [own[0][l], own[1][l], own[2][l]]);
            (color[0][l], color[1][l], color[2][l]) = (rgb[0], rgb[1], rgb[2]);
        }
        for l in 0..LANES {
            let hit = u32::all_if(slot[l] != NONE);
            for k in 0..3 {
                color[k][l] = pick(hit, color[k][l], behind[k][l]);
            }
        }
        self.color = color;
    }

    /// Writes the pixels from column `first` of the full frame on to `row`, which contains these `columns`.
    #[inline(always)]
    pub(super) fn write(&self, row: &mut Piece<'_>, columns: &Range<u32>, first: u32) {
        let lanes = columns.start.saturating_sub(first) as usize..(columns.end - first).min(TILE) as usize;
        let place = first as usize + lanes.start - columns.start as usize;
        put(row.id, place, &lanes, self.id);
        put(row.t, place, &lanes, self.t);
        put(row.depth_interval, place, &lanes, self.depth_interval);
        if !row.normal.is_empty() {
            put(row.normal, place, &lanes, interleaved(&self.normal));
        }
        if !row.color.is_empty() {
            put(row.color, place, &lanes, interleaved(&self.color));
        }
    }
}

/// Three components per lane, lane after lane.
#[inline(always)]
fn interleaved(components: &[[f32; LANES]; 3]) -> [f32; 3 * LANES] {
    let mut all = [0.0; 3 * LANES];
    for l in 0..LANES {
        for k in 0..3 {
            all[3 * l + k] = components[k][l];
        }
    }
    all
}

/// Writes the values of these lanes, some for each, from the pixel `place` of a row on; nothing if the buffer is not
/// requested.
#[inline(always)]
fn put<T: Copy, const N: usize>(row: &mut [T], place: usize, lanes: &Range<usize>, values: [T; N]) {
    let channels = N / LANES;
    let Some(out) = row.get_mut(channels * place..).filter(|out| !out.is_empty()) else { return };
    match out.first_chunk_mut::<N>() {
        // Of constant size, so without a call.
        Some(out) if lanes.len() == LANES => *out = values,
        _ => {
            let values = &values[channels * lanes.start..channels * lanes.end];
            out[..values.len()].copy_from_slice(values);
        }
    }
}
