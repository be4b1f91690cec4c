//! The input of `compare`, `merge` and `--resume`: files that halfline wrote, possibly damaged.

use super::check::{Allowed, allowed, check_error, desk};
use halfline::render::origin;
use halfline::report::Report;
use halfline::settings::Backend;
use halfline::window::Window;
use halfline::{Aov, Camera, ImagePlane, Scene, Settings, Spheres};
use halfline_files::read::SceneFrame;
use halfline_files::write::buffers::FrameFile;
use halfline_files::write::file::Target;
use halfline_files::write::format::FormatOptions;
use halfline_files::write::image_file::ImageFile;
use halfline_files::write::merge::{Mosaic, Tile};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Bytes per byte: deflate expands up to 1032 times, and a few copies of rows are held.
const PER_BYTE: usize = 5000;

/// The formats by extension, and the buffers that a file of each holds here.
const FORMATS: [(&str, &[Aov]); 7] = [
    ("png", &[Aov::Color]),
    ("exr", &[Aov::Color, Aov::Id, Aov::Depth]),
    ("npy", &[Aov::Depth]),
    ("npz", &[Aov::Color, Aov::Id]),
    ("pfm", &[Aov::Normal]),
    ("npy", &[Aov::Id]),
    ("png", &[Aov::Mask]),
];

/// A frame of 6 x 4 pixels in two tiles: the files of both, by [`FORMATS`].
struct Desk {
    folder: PathBuf,
    scene: Scene,
    left: Vec<PathBuf>,
    right: Vec<PathBuf>,
    /// The reports of rendering the left tiles.
    reports: Vec<Report>,
}

const WINDOWS: [Window; 2] = [Window { x0: 0, y0: 0, x1: 4, y1: 4 }, Window { x0: 4, y0: 0, x1: 6, y1: 4 }];

fn settings(window: Window, aovs: &[Aov]) -> Settings {
    Settings { backend: Backend::Cpu, window: Some(window), aovs: aovs.to_vec(), coverage: true, ..Settings::default() }
}

/// The file of these buffers; of an EXR with a Cryptomatte layer.
fn target(scene: &Scene, aovs: &[Aov], path: &Path) -> Target {
    let mut target = Target::new(aovs, path, FormatOptions::default()).expect("a target");
    if target.check_mattes().is_ok() {
        let names = SceneFrame::new(1, scene.clone()).matte_names(&["id".to_owned()]);
        target.set_mattes(&names.expect("names"));
    }
    target
}

static DESK: LazyLock<Desk> = LazyLock::new(|| {
    let folder = desk();
    fs::create_dir_all(&folder).expect("a folder");
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -3.0], 1.0, Some([0.9, 0.4, 0.2]));
    let image = ImagePlane { width: 6, height: 4, background: [0.0; 3] };
    let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
    let tiles = |side: &str, window: Window| -> (Vec<PathBuf>, Vec<Report>) {
        let write = |(n, (ending, aovs)): (usize, &(&str, &[Aov]))| {
            let settings = settings(window, aovs);
            let frame = halfline::render(&scene, &settings).expect("a frame");
            let path = folder.join(format!("{side}-{n}.{ending}"));
            let target = target(&scene, aovs, &path);
            target.write(&frame, &origin(&scene, &settings, &frame.report, window)).expect("written");
            (path, frame.report)
        };
        FORMATS.iter().enumerate().map(write).unzip()
    };
    let ((left, reports), (right, _)) = (tiles("left", WINDOWS[0]), tiles("right", WINDOWS[1]));
    Desk { folder, scene, left, right, reports }
});

/// A picture or an array that `compare` reads.
pub(crate) fn compare(data: &[u8]) -> Allowed {
    if let Err(error) = FrameFile::from_bytes(data, "fuzzed") {
        check_error(&error);
    }
    allowed(data.len(), PER_BYTE)
}

/// The file of the left tile; the first byte selects the right tile.
pub(crate) fn merge(data: &[u8]) -> Allowed {
    let Some((choice, content)) = data.split_first() else { return allowed(0, 0) };
    let format = usize::from(*choice) % FORMATS.len();
    let desk = &*DESK;
    let [left, whole] = ["left", "whole"].map(|name| desk.folder.join(format!("{name}.{}", FORMATS[format].0)));
    fs::write(&left, content).expect("a file of our own");
    let _ = fs::remove_file(&whole);
    let write = || {
        let mosaic = Mosaic::new(vec![Tile::open(&left)?, Tile::open(&desk.right[format])?])?;
        mosaic.write(&whole, &|| true)?;
        Ok(mosaic.size())
    };
    match write() {
        // The merged file must be valid and contain the pixels of the tile.
        Ok([width, height]) => {
            let whole = ImageFile::read(&whole).expect("a whole file");
            let left = ImageFile::from_bytes(content, "fuzzed").expect("it was merged");
            assert_eq!((whole.head.window, whole.head.full), (Window::full(width, height), [width, height]));
            let window = left.head.window;
            for ((form, part), whole) in left.head.forms.iter().zip(&left.samples).zip(&whole.samples) {
                let pixel = form.pixel();
                let rows = part.chunks_exact(pixel * window.width() as usize);
                for (row, y) in rows.zip(window.y0..) {
                    let place = (y as usize * width as usize + window.x0 as usize) * pixel;
                    assert_eq!(&whole[place..place + row.len()], row, "row {y}");
                }
            }
        }
        Err(error) => {
            check_error(&error);
            assert_ne!(content, fs::read(&desk.left[format]).expect("there"), "a good tile is refused");
            assert!(!whole.exists(), "a refused merge leaves no file");
        }
    }
    allowed(content.len(), PER_BYTE)
}

/// The file that `--resume` finds; the first byte selects the file that it replaces.
pub(crate) fn resume(data: &[u8]) -> Allowed {
    let Some((choice, content)) = data.split_first() else { return allowed(0, 0) };
    let desk = &*DESK;
    let format = usize::from(*choice) % FORMATS.len();
    let (ending, aovs) = FORMATS[format];
    let found = desk.folder.join(format!("found.{ending}"));
    fs::write(&found, content).expect("a file of our own");
    let settings = settings(WINDOWS[0], aovs);
    let target = target(&desk.scene, aovs, &found);
    let taken = target.is_there(&origin(&desk.scene, &settings, &desk.reports[format], WINDOWS[0]), &|| true);
    let expected = fs::read(&desk.left[format]).expect("there");
    assert_eq!(taken, content == expected, "the wanted file and no other is taken");
    allowed(content.len(), PER_BYTE)
}
