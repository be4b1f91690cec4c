//! Help on one screen, and the options that other programs have by other names.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};
use std::ffi::OsString;

/// The commands with more options than a screen shows.
const LONG: [&str; 5] = ["render", "plan", "view", "sift", "trace"];

/// The options that most people need, in a few words.
const COMMON: [(&str, &str); 28] = [
    ("scene", "Scene or particle file; - for standard input"),
    ("frames", "Frames of a sequence, such as 2, 1-10 or 5-"),
    ("select", "Takes only selected particles, such as \"chain A\""),
    ("hide", "Leaves out selected particles"),
    ("radius", "Radius of all, or of selected particles"),
    ("color", "Colour of all, or of selected particles"),
    ("color_by", "Colours by element, chain, or any column"),
    ("map", "Colour map, such as viridis"),
    ("range", "Values at the ends of the colour map"),
    ("cell", "Draws the edges of the periodic cell"),
    ("eye", "Position of the eye"),
    ("at", "Point or selection to look at"),
    ("view", "Direction to look in: X,Y,Z, front, top, iso, ..."),
    ("focus", "Frames what an expression selects"),
    ("vfov", "Vertical field of view"),
    ("ortho", "Orthographic camera"),
    ("spin", "Pictures of a full turn"),
    ("size", "Size in pixels"),
    ("samples", "Samples per pixel"),
    ("background", "Background colour"),
    ("transparent", "Makes the background transparent"),
    ("legend_in", "Draws the legend into the picture"),
    ("look", "Look: plain, soft, figure"),
    ("rays", "The rays: .npy, .npz or a table; - for standard input"),
    ("output", "File to write, by its extension"),
    ("aov", "Buffers: depth, normal, id, ... and their file"),
    ("backend", "Backend to compute on: auto, gpu, cpu"),
    ("json", "Prints a report as JSON"),
];

/// Words of other programs for options.
const FOREIGN: [(&str, &str); 12] = [
    ("palette", "--map"),
    ("cmap", "--map"),
    ("colormap", "--map"),
    ("color-map", "--map"),
    ("colour-map", "--map"),
    ("lut", "--map"),
    ("fov", "--vfov"),
    ("spp", "--samples"),
    ("width", "--size"),
    ("height", "--size"),
    ("resolution", "--size"),
    ("bg", "--background"),
];

/// The command line in which `-h` lists the options that most people need; `--help` lists all.
pub(super) fn on_one_screen(command: Command, words: &[OsString]) -> Command {
    if !words.iter().take_while(|word| *word != "--").any(|word| word == "-h") {
        return command;
    }
    let short = |arg: Arg| match COMMON.iter().find(|(id, _)| arg.get_id() == *id) {
        Some(_) if arg.is_hide_set() => arg,
        Some((_, help)) => {
            let heading = (!arg.is_positional()).then_some("Common options");
            let arg = arg.help(*help).help_heading(heading).hide_env(true);
            match arg.get_action().takes_values() {
                true => arg.hide_default_value(true).hide_possible_values(true),
                false => arg,
            }
        }
        None => arg.hide_short_help(true),
    };
    LONG.iter().fold(command, |command, name| {
        command.mut_subcommand(name, |part| {
            part.mut_args(short).next_line_help(false).after_help(format!("All options: halfline {name} --help"))
        })
    })
}

/// The error of an option that other programs have, with the name that it has here.
pub(super) fn translated(mut error: clap::Error) -> clap::Error {
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else { return error };
    let word = given.trim_start_matches('-');
    let known = FOREIGN.iter().find(|(foreign, _)| *foreign == word);
    if let Some((_, own)) = known.filter(|_| error.kind() == ErrorKind::UnknownArgument) {
        error.remove(ContextKind::Usage);
        error.insert(ContextKind::SuggestedArg, ContextValue::String((*own).to_owned()));
    }
    error
}
