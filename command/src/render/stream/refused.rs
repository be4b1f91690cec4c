//! Options and scenes that a stream refuses: they need spheres that it has forgotten.

use crate::scene_args::SceneArgs;
use halfline::camera::CameraRecord;
use halfline::error::{Error, Result};
use halfline::scene::LightSource;
use halfline_files::read::SceneFrame;

/// A problem that a stream may have, and its mend.
type Refusal = (bool, &'static str, &'static str);

/// A lens with a size.
const LENS: &str = "a lens with a size sees spheres that a stream has forgotten";

/// Refuses options that need all spheres in memory; `number` is the frame number, and `taken` the camera of `--camera-from`.
///
/// # Errors
/// [`Error::Settings`] that names the option.
pub(super) fn check(args: &SceneArgs, number: u64, taken: Option<&CameraRecord>) -> Result<()> {
    let SceneArgs { camera, files, insets, image, .. } = args;
    let has_size = camera.lens.has_size() || taken.is_some_and(|record| record.lens_size().is_some());
    let refusals: [Refusal; 13] = [
        (
            args.is_many(),
            "a stream is one picture",
            "render the frames, turns or cameras one by one, or without --stream",
        ),
        (
            camera.spin.is_some() && number > 1,
            "a turn of --spin is about the middle of all spheres in memory",
            "remove --spin, or --stream",
        ),
        (
            camera.focus.is_some(),
            "what --focus shows is chosen among all spheres in memory",
            "use --at, or remove --focus",
        ),
        (
            camera.frame_share.is_some(),
            "the spheres that --frame-share leaves out are known with all in memory",
            "use --eye and --at, or remove --frame-share",
        ),
        (
            insets.has_marks(),
            "marks need the columns of all spheres in memory",
            "remove --mark and --mark-one, or --stream",
        ),
        (
            image.least_size.is_some(),
            "spheres are enlarged for a picture with all in memory",
            "remove --least-size, or --stream",
        ),
        (
            args.cut.need_all(),
            "what --cut-at, --cut-only and --cut-color choose is chosen among all spheres in memory",
            "use --cut or --cut-slab, or remove --stream",
        ),
        (
            args.open_width().is_some(),
            "an open height needs all spheres in memory",
            "give a height with --size, or remove --stream",
        ),
        (
            files.figure().is_some(),
            "a figure without pixels needs all spheres in memory",
            "use a picture, or remove --stream",
        ),
        (files.model().is_some(), "a model has all spheres", "use a picture, or remove --stream"),
        (
            !files.cryptomatte.is_empty(),
            "names of Cryptomatte need all spheres in memory",
            "remove --cryptomatte, or --stream",
        ),
        (
            args.read.arrangement().outline.is_some(),
            "the edges of a cell are drawn with the scene in memory",
            "remove --cell",
        ),
        (has_size, LENS, "remove --aperture"),
    ];
    first(&refusals)
}

/// Refuses a frame, still without spheres, whose light or lens needs all of them in memory; `is_named` says whether an option gives the lens.
///
/// # Errors
/// [`Error::Settings`].
pub(super) fn check_frame(frame: &SceneFrame, is_named: bool) -> Result<()> {
    let shines = frame.scene.lighting.lights.iter().any(|light| matches!(light.source, LightSource::Sphere(_)));
    first(&[
        (frame.aperture.is_some(), LENS, "remove the scene's aperture"),
        (
            frame.scene.camera.lens.is_curved(),
            "the rays of a curved lens need all spheres in memory",
            if is_named { "remove --lens, or --stream" } else { "use another camera, or remove --stream" },
        ),
        (shines, "lights that are spheres need all spheres in memory", "remove them, or --stream"),
    ])
}

/// Returns the first of the problems that are there as an error.
fn first(refusals: &[Refusal]) -> Result<()> {
    match refusals.iter().find(|(is_there, ..)| *is_there) {
        Some((_, problem, mend)) => Err(Error::settings(format!("--stream: {problem}"), *mend)),
        None => Ok(()),
    }
}
