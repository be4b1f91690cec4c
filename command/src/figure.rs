//! Figures without pixels of pictures: what they are made of, and what is said of them.

use super::picture_scene::PictureScene;
use super::scene_args::SceneArgs;
use halfline::error::{Error, Result};
use halfline::frame::tone::Toning;
use halfline::quote::setting::{CROP, DEPTH_CUE_STRENGTH, DETAIL, SAMPLES, TILE};
use halfline::report::FigureCounts;
use halfline::settings::Settings;
use halfline_drawing::figure::{Figure, FigureNames, FigureStyle, refused};
use halfline_drawing::inset::Panels;
use halfline_files::write::format::Dpi;
use halfline_files::write::vector::VectorFormat;
use std::path::Path;

/// Checks the options of a figure against the other options.
///
/// # Errors
/// [`Error::Settings`] for options of figures without one, and for a figure of a part of a picture, or with samples.
pub(super) fn check(args: &SceneArgs) -> Result<()> {
    if args.is_figure() {
        let cases = [
            (args.image.is_part(), format!("{CROP} and {TILE} are parts of a picture")),
            (args.files.trim, "--trim cuts pixels off".to_owned()),
            (args.typed.has("samples"), format!("{SAMPLES} are of pixels")),
        ];
        return match cases.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, why)) => {
                Err(Error::settings(format!("a figure has no pixels: {why}"), "remove it, or write a PNG"))
            }
            None => Ok(()),
        };
    }
    args.figure.given().map_or(Ok(()), |option| {
        let problem = format!("{option} is of a figure without pixels, and none is written");
        Err(Error::settings(problem, "use -o with the file name extension .svg or .pdf, or remove it"))
    })
}

/// The figure of a picture.
///
/// # Errors
/// [`Error::Settings`] for a lens with a size and for a depth cue; errors of [`Figure::new`].
pub(super) fn of(args: &SceneArgs, picture: &PictureScene, settings: &Settings) -> Result<Figure> {
    let cases = [
        (settings.aperture.is_some(), "a lens with a size blurs", "remove the aperture".to_owned()),
        (settings.depth_cue, "a depth cue changes colours with depth", format!("remove it and {DEPTH_CUE_STRENGTH}")),
    ];
    if let Some((_, problem, mend)) = cases.into_iter().find(|(is_given, ..)| *is_given) {
        return Err(refused(problem, &mend));
    }
    let style = FigureStyle {
        shade: settings.shade,
        toning: Toning { tone: settings.tone.unwrap_or_default(), stops: settings.exposure },
        outline: settings.silhouette.then_some(settings.outline),
        transparent: args.files.transparent,
        detail: args.figure.detail(),
        dpi: args.dpi().map(Dpi::per_inch),
    };
    let names = &picture.path_names;
    let names = FigureNames {
        columns: names.iter().map(|(word, _)| word.clone()).collect(),
        groups: args.figure.groups().len(),
        value: &|column, id| names[column].1.name(id),
    };
    Figure::new(&picture.scene, style, Some(&names))
}

/// The bytes of the file of a figure, with panels over it.
pub(super) fn bytes(figure: &Figure, format: VectorFormat, panels: Option<&Panels>) -> Vec<u8> {
    match format {
        VectorFormat::Svg => figure.svg(panels).into_bytes(),
        VectorFormat::Pdf => figure.pdf(panels),
    }
}

/// A sentence on a figure that is written.
pub(super) fn words(path: &Path, counts: FigureCounts) -> String {
    let FigureCounts { paths, small, bytes, .. } = counts;
    let left_out = match small {
        0 => String::new(),
        1 => format!("; 1 part is smaller than {DETAIL} and is left out"),
        _ => format!("; {small} parts are smaller than {DETAIL} and are left out"),
    };
    let size = bytes as f64 / 1e3;
    format!("{} has {paths} paths, {size:.0} kB{left_out}", path.display())
}

/// A warning about lines that f64 did not close.
pub(super) fn warning(counts: FigureCounts) -> Option<String> {
    let joined = counts.joined;
    (joined > 0).then(|| {
        format!("{joined} lines of the figure are closed by straight ones: f64 does not tell where they go on")
    })
}
