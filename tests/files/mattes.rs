//! The promise of Cryptomatte layers in a file: they are read back as written, and a damaged file is
//! refused.

use crate::damage::damage;
use crate::formats::written;
use crate::random_frames::frame;
use crate::rng::Rng;
use halfline::frame::coverage::{Cover, Coverage};
use halfline::frame::{Aov, Frame};
use halfline::scene::{ImagePlane, Scene, Spheres};
use halfline::{Camera, Lighting};
use halfline_files::read::SceneFrame;
use halfline_files::write::buffers::FrameFile;
use halfline_files::write::file::Target;
use halfline_files::write::format::FormatOptions;
use halfline_files::write::image_file::ImageFile;
use std::path::Path;

const FULL: [u32; 2] = [20, 12];

/// A frame with the coverage of 9 samples: up to four spheres in a pixel.
fn covered() -> Frame {
    let mut rng = Rng::new(6);
    let mut row = |_| {
        let covers =
            (0..FULL[0]).flat_map(|column| (0..rng.below(5) as u32).map(move |id| (column, id)).collect::<Vec<_>>());
        let covers: Vec<_> = covers.collect();
        covers.into_iter().map(|(column, id)| Cover { column, id: 7 * id, samples: 1 + rng.below(2) as u32 }).collect()
    };
    let rows = (0..FULL[1]).map(&mut row).collect();
    Frame { coverage: Some(Coverage { samples: 9, rows }), ..frame(8, FULL) }
}

/// An .exr of colour with a layer of ids.
fn target(path: &Path) -> Target {
    let image = ImagePlane { width: FULL[0], height: FULL[1], background: [0.0; 3] };
    let (spheres, lighting) = (Spheres::default(), Lighting::default());
    let scene = SceneFrame::new(1, Scene { camera: Camera::CANONICAL, image, spheres, lighting });
    let mut target = Target::new(&[Aov::Color], path, FormatOptions::default()).expect("a target");
    target.set_mattes(&scene.matte_names(&["id".to_owned()]).expect("names"));
    target
}

#[test]
fn layers_are_read_back_and_have_every_sample() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, file) = written(&covered(), &target(&folder.path().join("a.exr")));
    let [layer] = &file.head.mattes[..] else { panic!("one layer") };
    assert_eq!(layer.layer, "CryptoId");
    assert_eq!(layer.manifest.keys().collect::<Vec<_>>(), ["0", "14", "21", "7"]);
    let numbers = file.samples[1].as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let numbers: Vec<f32> = numbers.collect();
    let coverage = covered().coverage.expect("made above");
    for (pixel, ranks) in numbers.chunks_exact(12).enumerate() {
        let (y, x) = (pixel / FULL[0] as usize, (pixel % FULL[0] as usize) as u32);
        let covers = coverage.rows[y].iter().filter(|cover| cover.column == x);
        let mut expected: Vec<(u32, u32)> = covers
            .map(|cover| {
                let id = &layer.manifest[&cover.id.to_string()];
                ((cover.samples as f32 / 9.0).to_bits(), u32::from_str_radix(id, 16).expect("hexadecimal"))
            })
            .collect();
        expected.resize(6, (0, 0));
        let mut found: Vec<_> = ranks.chunks_exact(2).map(|rank| (rank[1].to_bits(), rank[0].to_bits())).collect();
        assert!(found.is_sorted_by(|a, b| a.0 >= b.0), "{found:?}");
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected, "pixel {pixel}");
    }
}

/// Also where the file claims other layers or manifests.
#[test]
fn a_damaged_file_with_layers_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let (bytes, whole) = written(&covered(), &target(&folder.path().join("a.exr")));
    let (mut rng, mut read) = (Rng::new(9), 0);
    for n in 0..2000 {
        let mut damaged = bytes.clone();
        // The header, in every second one.
        let end = if n % 2 == 0 { 2000.min(bytes.len()) } else { bytes.len() };
        let rest = damaged.split_off(end);
        damage(&mut damaged, &bytes, &mut rng);
        damaged.extend(rest);
        read += usize::from(FrameFile::from_bytes(&damaged, "a.exr").is_ok());
        // Words of the provenance have no hash; provenance without the hash of the pixels is from an earlier version.
        let found = ImageFile::from_bytes(&damaged, "a.exr").ok();
        if let Some(file) = found.filter(|file| file.head.provenance.pixels().is_some()) {
            assert!(file.head.mattes == whole.head.mattes && file.samples == whole.samples, "{n}");
        }
    }
    assert!(read < 1500, "{read} of 2000 damaged files were read");
}
