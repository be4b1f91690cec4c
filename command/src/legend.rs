//! `--legend`: checks the legend's file name and its content.

use super::clash::{place, written_twice};
use super::names::{check_pattern, numbered};
use super::picture_scene::PictureScene;
use super::scene_args::SceneArgs;
use halfline::error::Result;
use halfline::frame::legend::{Category, Legend};
use halfline::frame::srgb;
use halfline::quote::setting::{HIDE, LEGEND, LEGEND_IN, OPACITY, VIEW};
use halfline::quote::{count, list};
use halfline_files::read::Hold;
use halfline_files::write::figure;
use halfline_files::write::file::check_writable;
use std::collections::HashMap;
use std::path::PathBuf;

/// Checks the name of the legend's file before any work.
pub(super) fn check(args: &SceneArgs) -> Result<()> {
    let Some(path) = &args.color.legend else { return Ok(()) };
    figure::check(path)?;
    if args.files.names()?.iter().any(|other| place(other) == place(path)) {
        return written_twice(path, "use another file for the legend");
    }
    // Without a common range each frame has a legend of its own.
    let is_common = args.color.has_fixed_range() || args.read.hold != Hold::None;
    if !is_common && args.read.frames.as_ref().is_some_and(|frames| frames.count() > 1) {
        check_pattern(path)?;
    }
    Ok(())
}

/// Whether an option asks for a legend, in the picture or in a file.
fn is_drawn(args: &SceneArgs) -> bool {
    args.insets.legend_in.is_some() || args.color.legend.is_some()
}

/// The note about a title without a legend, in a command whose pictures have one only where an option asks for it.
pub(super) fn unused_title(args: &SceneArgs) -> Option<String> {
    (args.color.has_title() && !is_drawn(args)).then(|| {
        format!("--legend-title is the title of a legend, and none is drawn: add {LEGEND_IN}, or {LEGEND} FILE")
    })
}

/// Warns where a legend is requested and the colours, of this column, have no values to show.
///
/// # Errors
/// [`Error::Settings`] for spheres without elements, a column and colours of selections.
pub(super) fn check_content(args: &SceneArgs, column: Option<&str>, picture: &mut PictureScene) -> Result<()> {
    let requests = [(LEGEND_IN, args.insets.legend_in.is_some()), (LEGEND, args.color.legend.is_some())];
    let Some((option, _)) = requests.into_iter().find(|(_, is_requested)| *is_requested) else { return Ok(()) };
    if picture.legend.is_some() {
        return Ok(());
    }
    picture.skipped.assumed.push(Legend::lacking(option, column, picture.scene.spheres.is_empty())?);
    Ok(())
}

/// The share of the pixels of spheres, one in so many, below which a category is hardly seen.
const FEW: u64 = 1000;

/// A warning about what the legend names and hardly any pixel of a whole picture shows, by the ids of its pixels. Categories that share
/// a colour are not told apart.
pub(super) fn hidden(args: &SceneArgs, picture: &PictureScene, ids: &[i32]) -> Option<String> {
    // What lies behind translucent spheres is seen through them, and has no id.
    let is_drawn = is_drawn(args) && !picture.scene.spheres.is_translucent();
    let legend = picture.legend.as_ref().filter(|_| is_drawn && picture.ids.is_none() && !args.image.is_part())?;
    let colors = picture.scene.spheres.colors.as_ref().filter(|_| !legend.is_scale())?;
    let mut pixels = vec![0_u64; colors.len()];
    ids.iter().filter_map(|id| usize::try_from(*id).ok()).for_each(|id| pixels[id] += 1);
    let all: u64 = pixels.iter().sum();
    let mut of_colors: HashMap<[u32; 3], u64> = HashMap::new();
    let bits = colors.iter().map(|color| color.map(f32::to_bits));
    bits.zip(&pixels).for_each(|(color, pixels)| *of_colors.entry(color).or_default() += pixels);
    let mut shown: HashMap<[u8; 3], u64> = HashMap::new();
    let levels = of_colors.into_iter().map(|(color, pixels)| (color.map(f32::from_bits).map(srgb::level), pixels));
    levels.for_each(|(color, pixels)| *shown.entry(color).or_default() += pixels);
    let is_alone = |row: &&Category| legend.swatches().filter(|other| other.color == row.color).count() == 1;
    // Rows of opacities have no colour of a sphere.
    let pixels_of = |row: &Category| shown.get(&row.color).filter(|pixels| **pixels * FEW < all);
    let few = |row: &Category| Some(format!("{}: {}", row.label, count(*pixels_of(row)?, "pixel")));
    let hidden: Vec<String> = legend.swatches().filter(is_alone).filter_map(few).collect();
    (!hidden.is_empty()).then(|| {
        format!(
            "the legend names what hardly any of the {all} pixels of spheres show ({}); another {VIEW} or {HIDE} for what is in \
             front shows more, in pixels also {OPACITY}",
            list(hidden)
        )
    })
}

/// The legend's file for picture `number`, if one is requested and can be written.
pub(super) fn file(args: &SceneArgs, number: u64) -> Result<Option<PathBuf>> {
    let path = args.color.legend.as_deref().map(|path| numbered(path, number));
    path.as_deref().map_or(Ok(()), check_writable)?;
    Ok(path)
}

/// A warning about letters of the legend's PNG file that the font lacks. `None` for an SVG, whose letters come from the
/// fonts of the machine that shows it.
pub(super) fn warning(args: &SceneArgs, legend: Option<&Legend>) -> Option<String> {
    args.color
        .legend
        .as_deref()
        .filter(|path| figure::is_png(path))
        .and(legend)
        .and_then(halfline_drawing::legend::warning)
}
