//! The certified frame on the CPU path. Eight pixels of a row are computed together, in loops that the compiler can
//! vectorize for the widest vectors of the processor. Vector and scalar operations round alike, so the bits equal the
//! device's.

mod pixels;
mod strip;

use crate::answers::raw::{Piece, Raw};
use crate::certify::binned::BinnedScene;
use crate::kernel::Kernel;
use crate::tile::TILE;
use crate::view::View;
use pixels::{Pixels, StripFrame};
use pulp::NullaryFnOnce;
use rayon::prelude::*;
use strip::{NearestTwos, Strip};

/// Fills `raw` with certified answers; pixels without a proof get [`UNSURE`] as id. `go_on` is called before every row.
pub(crate) fn certified(
    kernel: &Kernel,
    view: &View,
    binned: &BinnedScene,
    colors: Option<&[[f32; 3]]>,
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    each_row(&StripFrame::new(kernel, view, binned, colors, None), raw, go_on);
}

/// The same where a device has searched: `found` holds the winners and the two smallest bounds of depth.
pub(crate) fn finish(
    kernel: &Kernel,
    view: &View,
    binned: &BinnedScene,
    colors: Option<&[[f32; 3]]>,
    found: &Raw,
    raw: &mut Raw,
) {
    each_row(&StripFrame::new(kernel, view, binned, colors, Some(found)), raw, &|| true);
}

fn each_row(frame: &StripFrame<'_>, raw: &mut Raw, go_on: &(dyn Fn() -> bool + Sync)) {
    match frame.certify.view.is_plain() {
        true => each_row_by::<false>(frame, raw, go_on),
        false => each_row_by::<true>(frame, raw, go_on),
    }
}

/// The same for pixel centres or for samples. With samples, the rays of a strip lie in several rows and columns.
fn each_row_by<const SAMPLED: bool>(frame: &StripFrame<'_>, raw: &mut Raw, go_on: &(dyn Fn() -> bool + Sync)) {
    let record = frame.certify.view;
    let width = record.columns as usize;
    let rows: Vec<_> = raw.cut(width, width).collect();
    let arch = pulp::Arch::new();
    let rows = rows.into_par_iter().enumerate().filter(|_| go_on());
    let answer =
        |(i, row): (usize, Piece<'_>)| arch.dispatch(Row::<SAMPLED> { frame, i: record.first_row + i as u32, row });
    rows.for_each(answer);
}

/// A row of pixels: its number in the full frame, and where its answers go.
struct Row<'a, 'b, const SAMPLED: bool> {
    frame: &'a StripFrame<'a>,
    i: u32,
    row: Piece<'b>,
}

impl<const SAMPLED: bool> NullaryFnOnce for Row<'_, '_, SAMPLED> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { frame, i, mut row } = self;
        let record = frame.certify.view;
        let columns = record.first_column..record.first_column + record.columns;
        // A strip is a row of a tile of the full frame, whichever part of it the window shows. Pixels beyond the window are
        // computed but not written.
        let [[left, right], _] = record.tiles();
        for tile in left..=right {
            let place = [i, tile * TILE];
            let strip = Strip::<SAMPLED>::new(&frame.certify, place);
            let two = match frame.found {
                Some(found) => NearestTwos::found(found, &frame.certify, place),
                None => strip.nearest_two(&frame.certify, place),
            };
            Pixels::new(frame, &strip, &two).write(&mut row, &columns, place[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::{Answer, Certify, TERMS};
    use crate::number::vector::LANES;
    use crate::scene::Scene;
    use crate::settings::Settings;
    use crate::view::raster::Raster;
    use crate::view::ray::NONE;
    use crate::window::Window;

    /// The adversary checks single rays. This test extends its results to strips: both give the same bits.
    #[test]
    fn a_strip_answers_as_single_rays() {
        let scene = crate::testing::weekend([136, 77]);
        let window = Window::full(136, 77);
        same_as_single::<false>(&scene, Raster::centres(window));
        let settings = Settings { samples: 9, seed: 3, ..Settings::default() };
        let samples =
            Raster::samples(window, settings.samples, settings.seed, &scene.image).expect("room").expect("samples");
        same_as_single::<true>(&scene, samples);
    }

    fn same_as_single<const SAMPLED: bool>(scene: &Scene, raster: Raster) {
        let kernel = Kernel { certify: true, ..Kernel::bare(crate::Method::Stable) };
        let mut view = View::for_rays(scene, raster, kernel.records()).expect("a view");
        view.record.sample = raster.count() / 2;
        for level in [0, crate::tile::WHOLE] {
            let binned = BinnedScene::new(scene, &view, 1e-5, &TERMS, level, &crate::memory::Pool::default())
                .expect("a stage")
                .expect("a projection");
            let certify = Certify::<f32>::new(&view.record, &binned);
            let mut hits = 0;
            for (i, first) in (0..77).flat_map(|i| (0..136).step_by(LANES).map(move |first| (i, first))) {
                let strip = Strip::<SAMPLED>::new(&certify, [i, first]);
                let two = strip.nearest_two(&certify, [i, first]);
                let answers = strip.certify_winners(&certify, &two);
                for l in 0..LANES {
                    let [row, column] = view.record.sample_position(i, first + l as u32);
                    let s = certify.slopes(row, column);
                    let k = certify.nearest_two(&s);
                    assert_eq!((k.low, k.second, k.slot), (two.low[l], two.second[l], two.slot[l]));
                    if k.slot != NONE {
                        let (answer, single) = (answers.get(l), certify.certify_winner(&s, &k));
                        // A strip keeps no bound of normals.
                        let single = Answer { turn: 0.0, ..single };
                        assert_eq!(format!("{answer:?}"), format!("{single:?}"), "row {i}, column {first} + {l}");
                        hits += 1;
                    }
                }
            }
            assert!(hits > 1000, "the scene shows something");
        }
    }
}
