//! The outputs of a strip's pixels, from the certified answers to the buffers: the twin of main/certified.wgsl and of
//! shade/, in loops over lanes.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::strip::{NearestTwos, Solids, Strip, StripAnswers};
use super::triples::Triples;
use crate::answers::raw::Piece;
use crate::certify::{Certify, GENERAL};
use crate::kernel::{Kernel, Unproved};
use crate::number::vector::{Bits, pick};
use crate::scene::DEFAULT_COLOR;
use crate::shade::{Shade, color_of, to_world};
use crate::tile::TILE;
use crate::view::ViewRecord;
use crate::view::ray::{NONE, UNSURE};
use std::ops::Range;

/// The inputs of all strips of a frame: the rays and lists, the requested outputs, the spheres' colours, and the hits before.
pub(super) struct StripFrame<'a> {
    pub(super) certify: Certify<'a, f32>,
    pub(super) kernel: &'a Kernel,
    pub(super) colors: Option<&'a [[f32; 3]]>,
    /// The colours of faces on planes.
    pub(super) faces: Option<&'a [[f32; 3]]>,
    pub(super) passed: &'a [&'a [u32]],
}

/// The values of a strip's pixels, one array per component. The values of a buffer that is not requested are unspecified.
pub(super) struct Pixels<const N: usize> {
    id: [u32; N],
    t: [f32; N],
    depth_interval: [f32; N],
    depth: [f64; N],
    normal: [[f32; N]; 3],
    color: [[f32; N]; 3],
}

impl<const N: usize> Pixels<N> {
    const NONE: Self = Self {
        id: [NONE; N],
        t: [f32::MAX; N],
        depth_interval: [0.0; N],
        depth: [0.0; N],
        normal: [[0.0; N]; 3],
        color: [[0.0; N]; 3],
    };

    /// The pixels of a strip for which the search has ended with `two`, among `solids`.
    #[inline(always)]
    pub(super) fn new(frame: &StripFrame<'_>, strip: &Strip<N>, two: &NearestTwos<N>, solids: &impl Solids<N>) -> Self {
        let [red, green, blue, _] = frame.certify.view.background;
        let mut pixels = Self { color: [[red; N], [green; N], [blue; N]], ..Self::NONE };
        if two.slot == NearestTwos::<N>::NONE.slot {
            return pixels;
        }
        let mut answers = strip.certify_winners(&frame.certify, two);
        solids.certify(strip, &frame.certify, two, &mut answers);
        pixels.answer(frame, &answers, two);
        if frame.kernel.has_depths() {
            for l in 0..N {
                let is_face = solids.on_face(l) != 0;
                pixels.depth[l] =
                    if is_face { frame.certify.reference() } else { frame.certify.center_depth(two.slot[l]) };
            }
        }
        if frame.kernel.normal {
            pixels.turn(frame.certify.view, &answers, two);
        }
        if let Some(shade) = frame.kernel.shade {
            pixels.shade(frame, shade, strip, &answers, (two, solids));
        }
        pixels
    }

    // The loops below read copies and select by masks: so compilers make one vector of the lanes.

    #[inline(always)]
    fn answer(&mut self, frame: &StripFrame<'_>, answers: &StripAnswers<N>, two: &NearestTwos<N>) {
        let (slot, id, certain, [offset, interval, ..]) = (two.slot, answers.id, answers.certain, answers.numbers);
        // certify/take_nearest.wgsl.
        let nearest = frame.kernel.certificate().is_some_and(|of| of.unproved == Unproved::Nearest);
        for l in 0..N {
            let in_front = (slot[l] & GENERAL == 0) | (offset[l] > 0.0);
            let taken = u32::all_if((slot[l] == NONE) | (nearest & in_front)) | certain[l];
            self.id[l] = (id[l] & taken) | (UNSURE & !taken);
        }
        for l in 0..N {
            let hit = u32::all_if(slot[l] != NONE);
            self.t[l] = pick(hit, offset[l], f32::MAX);
            self.depth_interval[l] = pick(hit, interval[l], 0.0);
        }
    }

    /// Sets the normals, in world space; 0 on a miss.
    #[inline(always)]
    fn turn(&mut self, view: &ViewRecord, answers: &StripAnswers<N>, two: &NearestTwos<N>) {
        let (view, slot, [_, _, x, y, z]) = (*view, two.slot, answers.numbers);
        let mut normal = [[0.0; N]; 3];
        for l in 0..N {
            let [a, b, c] = to_world(&view, [x[l], y[l], z[l]]);
            let hit = u32::all_if(slot[l] != NONE);
            (normal[0][l], normal[1][l], normal[2][l]) = (pick(hit, a, 0.0), pick(hit, b, 0.0), pick(hit, c, 0.0));
        }
        self.normal = normal;
    }

    /// Sets the colours of the hits. The other pixels keep the background.
    #[inline(always)]
    fn shade(
        &mut self,
        frame: &StripFrame<'_>,
        shade: Shade,
        strip: &Strip<N>,
        answers: &StripAnswers<N>,
        (two, solids): (&NearestTwos<N>, &impl Solids<N>),
    ) {
        let mut own = DEFAULT_COLOR.map(|x| [x; N]);
        if frame.colors.is_some() || frame.faces.is_some() {
            for l in 0..N {
                // The colour of a miss is not used.
                let id = if answers.id[l] == NONE { 0 } else { answers.id[l] };
                let colors = if solids.on_face(l) != 0 { frame.faces.or(frame.colors) } else { frame.colors };
                [own[0][l], own[1][l], own[2][l]] = color_of(colors, id);
            }
        }
        let (slot, behind) = (two.slot, self.color);
        // The shading is a constant of each loop.
        let mut color = match shade {
            Shade::Flat => own,
            Shade::Normal => shaded(Shade::Normal, frame.certify.view, strip, answers, &own),
            Shade::Headlight => shaded(Shade::Headlight, frame.certify.view, strip, answers, &own),
        };
        for l in 0..N {
            let hit = u32::all_if(slot[l] != NONE);
            for k in 0..3 {
                color[k][l] = pick(hit, color[k][l], behind[k][l]);
            }
        }
        self.color = color;
    }

    /// Writes the pixels that `band` contains. The strip begins at row `i` and column `first` of the image.
    #[inline(always)]
    pub(super) fn write(&self, band: &mut Band<'_>, [i, first]: [u32; 2], triples: &impl Triples) {
        let [columns, rows] = [&band.columns, &band.rows];
        let lanes = columns.start.saturating_sub(first) as usize..(columns.end - first).min(TILE) as usize;
        let width = (columns.end - columns.start) as usize;
        // The place of the first pixel that is written of a row of the strip, if any is.
        let place = |row: usize| {
            let at = i + row as u32;
            let place = |row: u32| row as usize * width + first as usize + lanes.start - columns.start as usize;
            rows.contains(&at).then(|| place(at - rows.start))
        };
        let piece = &mut band.piece;
        put(piece.id, place, &lanes, &self.id);
        put(piece.t, place, &lanes, &self.t);
        put(piece.depth_interval, place, &lanes, &self.depth_interval);
        put(piece.depth, place, &lanes, &self.depth);
        if !piece.normal.is_empty() {
            put(piece.normal.as_chunks_mut().0, place, &lanes, &triples.of(&self.normal));
        }
        if !piece.color.is_empty() {
            put(piece.color.as_chunks_mut().0, place, &lanes, &triples.of(&self.color));
        }
    }
}

/// The colours of all lanes, whose spheres have the colours `own`.
#[inline(always)]
fn shaded<const N: usize>(
    shade: Shade,
    view: &ViewRecord,
    strip: &Strip<N>,
    answers: &StripAnswers<N>,
    own: &[[f32; N]; 3],
) -> [[f32; N]; 3] {
    let (view, [_, _, x, y, z]) = (*view, answers.numbers);
    let mut color = [[0.0; N]; 3];
    for l in 0..N {
        let s = strip.slopes(l);
        let rgb = shade.of(&view, [s.x, s.y, -1.0], [x[l], y[l], z[l]], [own[0][l], own[1][l], own[2][l]]);
        (color[0][l], color[1][l], color[2][l]) = (rgb[0], rgb[1], rgb[2]);
    }
    color
}

/// Some rows of the window, and where their answers go.
pub(super) struct Band<'a> {
    pub(super) columns: Range<u32>,
    pub(super) rows: Range<u32>,
    pub(super) piece: Piece<'a>,
}

/// Pixels of a row of a tile.
const ROW: usize = TILE as usize;

/// Writes `lanes` of every row of a strip to `out`, from the place of the row on. Writes nothing if the buffer is not
/// requested.
#[inline(always)]
fn put<T: Copy, const N: usize>(
    out: &mut [T],
    place: impl Fn(usize) -> Option<usize>,
    lanes: &Range<usize>,
    values: &[T; N],
) {
    if out.is_empty() {
        return;
    }
    for row in 0..N / ROW {
        let values = &values[row * ROW..(row + 1) * ROW];
        let Some(out) = place(row).and_then(|place| out.get_mut(place..)) else { continue };
        match out.first_chunk_mut::<ROW>() {
            // Of constant size, so without a call.
            Some(out) if lanes.len() == ROW => out.copy_from_slice(values),
            _ => out[..lanes.len()].copy_from_slice(&values[lanes.clone()]),
        }
    }
}
