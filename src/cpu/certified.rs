//! The certified frame on the CPU path. The pixels of one row of a tile, or of two, are computed together, in loops that the compiler can
//! vectorize for the widest vectors of the processor. Vector and scalar operations round alike, so the bits equal the
//! device's.

mod cut;
mod pixels;
mod strip;
pub(super) mod triples;

use crate::answers::raw::Raw;
use crate::certify::Certify;
use crate::certify::binned::BinnedScene;
use crate::kernel::Kernel;
use crate::number::vector::LANES;
#[cfg(target_arch = "x86_64")]
use crate::number::vector::WIDE;
use crate::tile::TILE;
use crate::view::View;
use crate::view::ray::NONE;
use cut::CutStrip;
use halfline_ground::parallel;
use pixels::{Band, Pixels, StripFrame};
use pulp::NullaryFnOnce;
use strip::{NearestTwos, NonePassed, Solids, Strip, Whole};
use triples::{Portable, Triples};

/// Fills `raw` with certified answers; a pixel without a proof gets [`UNSURE`](crate::view::ray::UNSURE) as id, or its nearest candidate, as
/// the kernel says. The colours belong to spheres, and to faces on planes where these are others. `passed` has the hits before, if any: layers of
/// one sphere a pixel, which its ray passes through; a pixel whose last is [`NONE`] may be left out, as a miss. `go_on` is called before every row.
pub(crate) fn certified(
    kernel: &Kernel,
    view: &View,
    binned: &BinnedScene,
    [colors, faces]: [Option<&[[f32; 3]]>; 2],
    passed: &[&[u32]],
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    let frame = StripFrame { certify: Certify::new(&view.record, binned), kernel, colors, faces, passed };
    // Strips are as wide as the processor's vectors.
    match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(lanes) => each_strip::<WIDE>(&frame, lanes, raw, go_on),
        _ => each_strip::<LANES>(&frame, Portable, raw, go_on),
    }
}

/// Fills `raw` in strips of `N` lanes, which are whole rows of tiles of the full frame, whichever part of it the window shows.
/// Pixels beyond the window are computed but not written.
fn each_strip<const N: usize>(
    frame: &StripFrame<'_>,
    triples: impl Triples,
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    let record = frame.certify.view;
    let (tall, width) = (N as u32 / TILE, record.columns as usize);
    let columns = record.first_column..record.first_column + record.columns;
    let end = record.first_row + record.rows;
    let first = record.first_row / tall;
    let foremost = (first + 1) * tall - record.first_row;
    let mut pieces: Vec<_> = raw.cut(foremost as usize * width, tall as usize * width).map(Some).collect();
    let arch = pulp::Arch::new();
    parallel::fill(&mut pieces[..], 1, &|numbers, pieces| {
        let (n, piece) = (first + numbers.start as u32, pieces[0].take());
        let rows = record.first_row.max(n * tall)..end.min((n + 1) * tall);
        if let Some(piece) = piece.filter(|_| rows.clone().all(|_| go_on())) {
            let band = Band { columns: columns.clone(), rows, piece };
            arch.dispatch(Strips::<N, _> { frame, triples, i: n * tall, band });
        }
    });
}

/// The strips whose first row is `i`, and where their answers go.
struct Strips<'a, 'b, const N: usize, T> {
    frame: &'a StripFrame<'a>,
    triples: T,
    i: u32,
    band: Band<'b>,
}

impl<const N: usize, T: Triples> NullaryFnOnce for Strips<'_, '_, N, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { frame, triples, i, mut band } = self;
        let [[left, right], _] = frame.certify.view.tiles();
        for tile in left..=right {
            let place = [i, tile * TILE];
            let strip = Strip::<N>::new(&frame.certify, place);
            let pixels = match frame.certify.planes {
                None => pixels(frame, &strip, place, &mut Whole),
                Some(planes) => pixels(frame, &strip, place, &mut CutStrip::new(planes)),
            };
            pixels.write(&mut band, place, &triples);
        }
    }
}

/// The pixels of a strip among these solids.
#[inline(always)]
fn pixels<const N: usize>(
    frame: &StripFrame<'_>,
    strip: &Strip<N>,
    place: [u32; 2],
    solids: &mut impl Solids<N>,
) -> Pixels<N> {
    let two = match frame.passed {
        [] => strip.nearest_two(&frame.certify, place, &NonePassed, solids),
        layers => nearest_behind(frame, strip, place, (layers, solids)),
    };
    Pixels::new(frame, strip, &two, solids)
}

/// The nearest hits behind the hits of some layers, at least one; of a strip without any in the last, misses.
#[inline(always)]
fn nearest_behind<const N: usize>(
    frame: &StripFrame<'_>,
    strip: &Strip<N>,
    place: [u32; 2],
    (layers, solids): (&[&[u32]], &mut impl Solids<N>),
) -> NearestTwos<N> {
    let record = frame.certify.view;
    let [rows, columns] = [(record.first_row, record.rows), (record.first_column, record.columns)];
    let at = |l: u32| {
        // Pixels beyond the window wrap around, to more than it has.
        let [row, column] = [(place[0] + l / TILE).wrapping_sub(rows.0), (place[1] + l % TILE).wrapping_sub(columns.0)];
        (row < rows.1 && column < columns.1).then(|| row as usize * columns.1 as usize + column as usize)
    };
    let of = |layer: &&[u32]| {
        let mut ids = [NONE; N];
        for (l, id) in ids.iter_mut().enumerate() {
            *id = at(l as u32).map_or(NONE, |at| layer[at]);
        }
        ids
    };
    if layers.last().is_none_or(|last| of(last) == [NONE; N]) {
        return NearestTwos::NONE;
    }
    let passed: Vec<[u32; N]> = layers.iter().map(of).collect();
    strip.nearest_two(&frame.certify, place, &&passed[..], solids)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::Answer;
    use crate::certify::binned::Binning;
    use crate::kernel::Certificate;
    use crate::scene::{CutPlane, Scene};
    use crate::settings::Settings;
    use crate::view::raster::Raster;
    use crate::window::Window;
    use halfline_ground::memory::Pool;

    /// The adversary checks single rays. This test extends its results to strips of every width: all give the same bits.
    #[test]
    fn a_strip_answers_as_single_rays() {
        let scene = crate::testing::weekend([136, 77]);
        let window = Window::full(136, 77);
        let settings = Settings { samples: 9, seed: 3, ..Settings::default() };
        let samples =
            Raster::samples(window, settings.samples, settings.seed, &scene.image).expect("room").expect("samples");
        for raster in [Raster::centres(window), samples] {
            same_as_single::<LANES>(&scene, raster);
            same_as_single::<WIDE>(&scene, raster);
        }
    }

    fn same_as_single<const N: usize>(scene: &Scene, raster: Raster) {
        let kernel = Kernel::certified();
        let mut view = View::for_rays(scene, raster, kernel.records()).expect("a view");
        view.record.sample = raster.count() / 2;
        for level in [0, crate::tile::WHOLE] {
            let binned = BinnedScene::new(&Binning { level, ..Binning::of(scene, &view, 1e-5, &Pool::default()) })
                .expect("a stage")
                .expect("a projection");
            let certify = Certify::<f32>::new(&view.record, &binned);
            let mut hits = 0;
            let rows = (0..77).step_by(N / TILE as usize);
            for (i, first) in rows.flat_map(|i| (0..136).step_by(TILE as usize).map(move |first| (i, first))) {
                let strip = Strip::<N>::new(&certify, [i, first]);
                let two = strip.nearest_two(&certify, [i, first], &NonePassed, &mut Whole);
                let answers = strip.certify_winners(&certify, &two);
                for l in 0..N {
                    let [row, column] = view.record.sample_position(i + l as u32 / TILE, first + l as u32 % TILE);
                    let s = certify.slopes(row, column);
                    let k = certify.nearest_two(&s);
                    assert_eq!((k.low, k.second, k.slot), (two.low[l], two.second[l], two.slot[l]));
                    if k.slot != NONE {
                        let single = certify.certify_winner(&s, &k);
                        let certain = certify.certain(&single, [k.low, k.second]);
                        let Answer { id, offset, depth_interval, normal: [x, y, z], .. } = single;
                        let numbers = [offset, depth_interval, x, y, z].map(f32::to_bits);
                        let own = (answers.id[l], answers.certain[l] != 0, answers.numbers.map(|n| n[l].to_bits()));
                        assert_eq!(own, (id, certain, numbers), "row {i}, column {first} + {l}");
                        hits += 1;
                    }
                }
            }
            assert!(hits > 1000, "the scene shows something");
        }
    }

    /// Windows with edges anywhere in strips get the same bits from strips of either width, and with the processor's
    /// vectors.
    #[test]
    fn strips_of_every_width_write_the_same_bits() {
        let whole = crate::testing::weekend([136, 77]);
        let plane = CutPlane { normal: [0.01, 1.0, 0.0], distance: 0.25 };
        let mut cut = whole.clone();
        cut.spheres.cut(&[plane], None).expect("a plane");
        assert!(cut.spheres.cuts.is_some(), "the plane cuts some");
        [whole, cut].iter().for_each(same_by_every_width);
    }

    fn same_by_every_width(scene: &Scene) {
        let kernel = Kernel {
            t: true,
            normal: true,
            shade: Some(crate::Shade::Headlight),
            ..Kernel::certified().certified_by(|of| Certificate { depth_interval: true, ..of })
        };
        let windows = [
            Window::full(136, 77),
            Window { x0: 13, y0: 33, x1: 121, y1: 62 },
            Window { x0: 70, y0: 40, x1: 75, y1: 41 },
        ];
        for window in windows {
            let view = View::for_rays(scene, Raster::centres(window), kernel.records()).expect("a view");
            let pool = Pool::default();
            let binned =
                BinnedScene::new(&Binning::of(scene, &view, 1e-5, &pool)).expect("a stage").expect("a projection");
            let frame = StripFrame {
                certify: Certify::new(&view.record, &binned),
                kernel: &kernel,
                colors: None,
                faces: None,
                passed: &[],
            };
            let raw = |render: &dyn Fn(&mut Raw)| {
                let mut raw = Raw::new(&kernel, view.record.pixels(), &pool).expect("room");
                render(&mut raw);
                raw
            };
            let narrow = raw(&|raw| each_strip::<LANES>(&frame, Portable, raw, &|| true));
            assert!(narrow.id.iter().any(|id| *id < 500), "the window shows something");
            assert!(narrow == raw(&|raw| each_strip::<WIDE>(&frame, Portable, raw, &|| true)));
            assert!(
                narrow == raw(&|raw| certified(&kernel, &view, &binned, [None; 2], &[], raw, &|| true)),
                "with the processor's vectors"
            );
        }
    }
}
