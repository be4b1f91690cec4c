//! `--visible`: the picture of parts that `halfline sift` made.

use super::camera_args::CameraArgs;
use super::clash::check_inputs;
use super::cut_args::CutArgs;
use super::lens_args::PictureLens;
use super::messages::note;
use super::option_table::{NO_PART, has};
use super::picture_scene::PictureScene;
use super::read_args::{ColorArgs, ReadArgs};
use super::scene_args::SceneArgs;
use super::signals::watch;
use clap::{Args, Command};
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::quote::count;
use halfline::render::stream::{Part, Visible};
use halfline::settings::{FileLook, Settings};
use halfline_files::parts;
use halfline_files::read::SceneFrame;
use halfline_files::write::file::Target;

/// The picture of all spheres of the parts.
///
/// # Errors
/// [`Error::Settings`] for options that the parts fix, and parts that are not of one frame; errors of reading.
pub(super) fn picture(args: &SceneArgs, settings: &Settings, targets: &[Target]) -> Result<PictureScene> {
    check_inputs(targets.iter().map(Target::path), &args.visible)?;
    targets.iter().try_for_each(Target::check)?;
    let part = combined(args)?;
    let view = part.view().clone();
    let mut frame = SceneFrame::new(1, view.scene());
    args.check_size(&view)?;
    args.files.apply(&mut frame.scene);
    let file = FileLook { samples: Some(view.samples), ..FileLook::default() };
    let request = args.look_request(file, settings.aovs.contains(&Aov::Color));
    let look = args.light.apply(&mut frame, &args.files.buffers(), request, PictureLens::default())?;
    let mut picture =
        PictureScene { part_view: Some(view), skipped: frame.skipped, ..PictureScene::bare(frame.scene, look) };
    picture.skipped.assumed.extend(part.gaps());
    note(format_args!("{}: {part}", count(args.visible.len() as u64, "part")));
    let settings = args.settings_for(&picture, settings, targets)?;
    let Visible { scene, ids } = part.visible(&picture.scene, &settings)?;
    targets.iter().try_for_each(|target| target.check_ids(ids.count))?;
    if ids.are_wide() && targets.iter().any(|target| target.aovs().contains(&Aov::Id)) {
        note(format_args!("ids are int64: they exceed what 32 bits can number"));
    }
    (picture.scene, picture.ids) = (scene, Some(ids));
    Ok(picture)
}

/// The part of all spheres of the files.
fn combined(args: &SceneArgs) -> Result<Part> {
    let watch = watch();
    let mut parts = args.visible.iter().map(|path| watch.check().and_then(|()| parts::read(path)));
    let none = || Error::settings("--visible has no part", "name at least one file of halfline sift");
    let first = parts.next().ok_or_else(none)??;
    first.combine_all(parts)
}

/// Refuses options that read a scene or give its camera.
///
/// # Errors
/// [`Error::Settings`] that names the option.
pub(super) fn check(args: &SceneArgs) -> Result<()> {
    args.check_picture_size()?;
    if args.insets.has_marks() {
        return Err(Error::settings("--mark and --mark-one: parts have no columns", "remove them"));
    }
    if args.is_figure() {
        return Err(Error::settings("parts have pixels, and a figure has none", "use a picture"));
    }
    if args.files.model().is_some() {
        return Err(Error::settings("parts have no spheres that are hidden, which a model has", "use a picture"));
    }
    if !args.files.cryptomatte.is_empty() {
        return Err(Error::settings("--cryptomatte: parts have no columns", "remove it"));
    }
    if args.insets.legend_in.is_some() {
        return Err(Error::settings("--legend-in: parts have no legend", "remove it"));
    }
    // Options that were applied when the parts were made.
    let groups = CutArgs::augment_args(Command::new("parts"));
    let groups = CameraArgs::augment_args(ColorArgs::augment_args(ReadArgs::augment_args(groups)));
    let all = SceneArgs::augment_args(Command::new("render"));
    let others = all.get_arguments().filter(|arg| ["crop", "tile", "skip_invalid"].contains(&arg.get_id().as_str()));
    let applied = groups.get_arguments().chain(others);
    let mut applied = applied.filter_map(|arg| Some((arg.get_id().as_str(), arg.get_long()?)));
    match applied.find(|(id, _)| args.typed.has(id)) {
        Some((id, long)) => {
            let problem = format!("--{long} belongs to the parts of --visible, which were made with their own options");
            let is_taken = !has(id, NO_PART);
            Err(Error::settings(problem, if is_taken { "give it to halfline sift" } else { "remove it" }))
        }
        None => Ok(()),
    }
}
