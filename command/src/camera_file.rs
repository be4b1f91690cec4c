//! `--camera-from`: the camera of a picture or buffer that halfline wrote, of a report, or of a scene file.

use halfline::camera::{Camera, CameraRecord, Lens};
use halfline::error::{Error, Place, Result};
use halfline_files::read::{ReadOptions, SphereBlocks};
use halfline_files::write::image_file::ImageFile;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The most bytes of a report.
const LONGEST: u64 = 1 << 24;

/// The camera in a file: of a picture or buffer with a provenance, of the first JSON object of `render --json` or
/// `plan --json`, or of a scene file (TOML).
///
/// # Errors
/// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] for one without a camera.
pub(super) fn read(path: &Path) -> Result<CameraRecord> {
    let place = Place::file(path.display().to_string());
    let mend = "use a picture or a buffer that halfline wrote, the output of render --json, or a scene (.toml)";
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return of_scene(path)?.ok_or_else(|| Error::scene(place.named("camera"), "the file has no camera", mend));
    }
    let record = match report(path)? {
        Some(report) => report.get("camera").cloned().and_then(|camera| serde_json::from_value(camera).ok()),
        None => ImageFile::read(path)?.head.provenance.camera(),
    };
    let record: CameraRecord =
        record.ok_or_else(|| Error::scene(place.clone().named("camera"), "the file has no camera", mend))?;
    let camera = record.camera();
    let [width, height] = record.size;
    camera.basis().and_then(|_| camera.check(width, height)).map(|()| record).map_err(|error| match error {
        Error::Scene { problem, .. } => Error::scene(place.named("camera"), problem, mend),
        other => other,
    })
}

/// The camera of a scene file, whose spheres are not read.
fn of_scene(path: &Path) -> Result<Option<CameraRecord>> {
    let Some((frame, _)) = SphereBlocks::scene(path, &ReadOptions::default())? else { return Ok(None) };
    let image = frame.scene.image;
    CameraRecord::new(&frame.scene.camera, [image.width, image.height], frame.aperture).map(Some)
}

/// The first JSON object of a file; `None` if the file does not begin with one.
fn report(path: &Path) -> Result<Option<serde_json::Value>> {
    let mut text = Vec::new();
    let opened = File::open(path).and_then(|file| file.take(LONGEST).read_to_end(&mut text));
    opened.map_err(|e| Error::read(path, e))?;
    if text.trim_ascii_start().first() != Some(&b'{') {
        return Ok(None);
    }
    Ok(serde_json::Deserializer::from_slice(&text).into_iter().next().and_then(Result::ok))
}

/// The camera for pictures of this size; pixels that were square stay square, with the height of the view.
pub(super) fn resized(record: &CameraRecord, size: Option<(u32, u32)>) -> Camera {
    let camera = record.camera();
    let [w, h] = record.size.map(f64::from);
    let Some((width, height)) = size.filter(|size| <[u32; 2]>::from(*size) != record.size) else { return camera };
    let lens = match camera.lens {
        Lens::Viewport { vw, vh, distance } => {
            let shape = vw * h / (vh * w);
            Lens::Viewport { vw: vh * shape * f64::from(width) / f64::from(height), vh, distance }
        }
        lens => lens.resized(record.size, [width, height]),
    };
    Camera { lens, ..camera }
}
