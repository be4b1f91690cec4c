//! The table of the options of a picture: who takes an option, and its keyword in Python. clap defines their values and
//! their help; every other list of options is a column of this table.

#[cfg(all(test, feature = "view"))]
#[path = "option_table/python.rs"]
mod python;

use clap::Command;

/// An option of a picture.
pub(super) struct OptionRow {
    /// The identifier in clap's definition.
    pub(super) id: &'static str,
    pub(super) python: Python,
    /// A sum of [`CONFIG`], [`PAGE`], [`NO_VIEW`] and [`NO_PART`].
    uses: u8,
}

/// The environment and the configuration file may set it: a preference of a user or a machine, not a property of one picture.
pub(super) const CONFIG: u8 = 1;
/// The page of `halfline view` sets it by itself: the camera and the size.
pub(super) const PAGE: u8 = 2;
/// `halfline view` refuses it: it makes several pictures, a part of one, or files.
pub(super) const NO_VIEW: u8 = 4;
/// `halfline sift` refuses it: a part of a scene does not depend on it.
pub(super) const NO_PART: u8 = 8;

/// An option in the lines of Python that render a picture of the page.
#[derive(Clone, Copy)]
pub(super) enum Python {
    /// A keyword of a call, with the form of its value and its type.
    Keyword(Call, &'static str, Form, &'static str),
    /// Another object or call does the same.
    Elsewhere(&'static str),
    /// An option that does not change a picture, and is left out.
    Outside,
    /// An option without a keyword, which a comment names.
    Missing,
}

/// The Python call that takes an option as a keyword: reading, rendering, renderer, camera or saving.
#[derive(Clone, Copy, PartialEq)]
pub enum Call {
    /// `read`.
    Read,
    /// `Renderer.render`.
    Render,
    /// `Sieve`, which takes the options of a rendering on which a part depends.
    Sieve,
    /// `Renderer`.
    Renderer,
    /// `Camera`.
    Camera,
    /// `Frame.save`.
    Save,
    /// `Scene.vector`, which takes the options of a rendering too.
    Vector,
}

/// The form of an option's value in Python.
#[derive(Clone, Copy, PartialEq)]
pub enum Form {
    /// Whether it is so.
    Flag,
    /// A number.
    Number,
    /// A text, or the name of a file.
    Text,
    /// A text, or a whole number that is a name.
    Name,
    /// A text, or names for meanings.
    Columns,
    /// A text, or several with commas between them.
    Names,
    /// Columns and rows.
    Size,
    /// Numbers or percentages with commas between them.
    Tuple,
    /// A tuple each time that the option is given.
    Tuples,
    /// A text each time that the option is given.
    Texts,
    /// The name of a file each time that the option is given.
    Files,
    /// A number or a text, or one for each selection.
    Rules,
    /// A text for each selection.
    Marks,
    /// A number, or `True` without one.
    NumberOrFlag,
    /// A text, or `True` without one.
    TextOrFlag,
    /// A corner or `True`; or a file, which another option names.
    Legend,
    /// A name, or linear numbers.
    Color,
}

use Call::{Camera, Read, Render, Renderer, Save, Vector};
use Form::{
    Color, Columns, Files, Flag, Legend, Marks, Name, Names, Number, NumberOrFlag, Rules, Size, Text, TextOrFlag,
    Texts, Tuple, Tuples,
};
use Python::{Elsewhere, Keyword, Missing, Outside};

/// All options of a picture. Python's keywords have this order.
#[rustfmt::skip]
const OPTIONS: &[OptionRow] = &[
    row("visible", Elsewhere("render of a Part"), NO_VIEW | NO_PART),
    row("format", Keyword(Read, "format", Text, "str | None"), 0),
    row("columns", Keyword(Read, "columns", Columns, "str | Mapping[str, str | int] | None"), 0),
    row("atom_style", Keyword(Read, "atom_style", Text, "str | None"), 0),
    row("hold", Keyword(Read, "hold", Text, "Literal[\"first\", \"none\"]"), 0),
    row("topology", Keyword(Read, "topology", Text, "Path | None"), NO_PART),
    row("add", Keyword(Read, "add", Files, "Path | Iterable[Path]"), NO_PART),
    row("identity", Keyword(Read, "identity", Text, "str | None"), NO_PART),
    row("model", Keyword(Read, "model", Number, "int | None"), 0),
    row("altloc", Keyword(Read, "altloc", Text, "str"), 0),
    row("assembly", Keyword(Read, "assembly", Name, "str | int | None"), NO_PART),
    row("as_listed", Keyword(Read, "as_listed", Flag, "bool"), 0),
    row("strict", Keyword(Read, "strict", Flag, "bool"), 0),
    row("skip_invalid", Keyword(Read, "skip_invalid", Flag, "bool"), 0),
    row("select", Keyword(Read, "select", Texts, "str | Iterable[str]"), 0),
    row("hide", Keyword(Read, "hide", Texts, "str | Iterable[str]"), 0),
    row("radii", Keyword(Read, "radii", Text, "Literal[\"vdw\", \"covalent\"]"), CONFIG),
    row("radius", Keyword(Read, "radius", Rules, "float | Mapping[str, float] | None"), 0),
    row("radius_scale", Keyword(Read, "radius_scale", Number, "float"), CONFIG),
    row("move", Keyword(Read, "move", Rules, "Mapping[str, ArrayLike]"), 0),
    row("wrap", Keyword(Read, "wrap", Flag, "bool"), NO_PART),
    row("unwrap", Keyword(Read, "unwrap", Flag, "bool"), NO_PART),
    row("copies", Keyword(Read, "copies", Tuple, "tuple[int, int, int] | None"), NO_PART),
    row("clip", Keyword(Read, "clip", Tuples, "ArrayLike"), 0),
    row("cell", Keyword(Read, "cell", NumberOrFlag, "bool | float"), NO_PART),
    row("color", Keyword(Read, "color", Rules, "Color | Mapping[str, Color] | None"), 0),
    row("opacity", Keyword(Read, "opacity", Rules, "float | Mapping[str, float] | None"), 0),
    row("material", Keyword(Read, "material", Rules, "str | Mapping[str, str] | None"), NO_PART),
    row("shine", Keyword(Read, "shine", Number, "float | None"), NO_PART),
    row("color_by", Keyword(Read, "color_by", Names, "str | Iterable[str] | None"), 0),
    row("map", Keyword(Read, "map", Text, "Path | ArrayLike | Callable[[NDArray[np.float64]], ArrayLike] | None"), CONFIG),
    row("range", Keyword(Read, "range", Tuple, "tuple[float | str, float | str] | None"), 0),
    row("log", Keyword(Read, "log", Flag, "bool"), 0),
    row("nan_color", Keyword(Read, "nan_color", Color, "Color | None"), CONFIG),
    row("legend_title", Keyword(Read, "legend_title", Text, "str | None"), NO_PART),
    row("frames", Keyword(Read, "frame", Number, "int"), 0),
    row("outline", Keyword(Render, "cell", NumberOrFlag, "bool | float"), NO_PART),
    row("cut", Keyword(Render, "cut", Tuples, "ArrayLike"), 0),
    row("cut_slab", Keyword(Render, "cut_slab", Tuples, "ArrayLike"), 0),
    row("cut_at", Keyword(Render, "cut_at", Texts, "str | Iterable[str]"), NO_PART),
    row("cut_only", Keyword(Render, "cut_only", Text, "str | None"), NO_PART),
    row("cut_color", Keyword(Render, "cut_color", Rules, "Color | Mapping[str, Color] | None"), NO_PART),
    row("eye", Elsewhere("Camera(eye)"), PAGE),
    row("at", Elsewhere("Camera(at)"), PAGE),
    row("up", Elsewhere("Camera(up)"), PAGE),
    row("lens", Elsewhere("Camera(lens=)"), PAGE),
    row("vfov", Elsewhere("Camera(vfov=)"), PAGE),
    row("intrinsics", Elsewhere("Camera(intrinsics=)"), PAGE),
    row("lens_coefficients", Elsewhere("Camera(lens_coefficients=)"), PAGE),
    row("ortho", Elsewhere("Camera(height=)"), PAGE),
    row("size", Keyword(Render, "size", Size, "tuple[int, int | None] | None"), PAGE | CONFIG),
    row("view", Elsewhere("Camera(view)"), PAGE),
    row("focus", Elsewhere("Camera.fit(focus)"), PAGE),
    row("frame_share", Elsewhere("Camera.fit(share)"), PAGE),
    row("fit", Elsewhere("Camera.fit"), PAGE),
    row("from", Missing, PAGE),
    row("zoom", Missing, PAGE),
    row("aperture", Keyword(Camera, "aperture", Number, "float | None"), NO_PART),
    row("focus_distance", Keyword(Camera, "focus", Number, "float | None"), NO_PART),
    row("backend", Keyword(Renderer, "backend", Text, "Literal[\"auto\", \"gpu\", \"cpu\"]"), CONFIG | NO_PART),
    row("adapter", Keyword(Renderer, "adapter", Name, "str | int | None"), CONFIG | NO_PART),
    row("samples", Keyword(Render, "samples", Number, "int | None"), CONFIG),
    row("least_size", Keyword(Render, "least_size", Number, "float | None"), NO_PART),
    row("seed", Keyword(Render, "seed", Number, "int"), CONFIG),
    row("exposure", Keyword(Render, "exposure", Number, "float"), CONFIG | NO_PART),
    row("tone", Keyword(Render, "tone", Text, "Literal[\"linear\", \"soft\"] | None"), CONFIG | NO_PART),
    row("shade", Keyword(Render, "shade", Text, "Literal[\"headlight\", \"flat\", \"normal\"] | None"), CONFIG | NO_PART),
    row("look", Keyword(Render, "look", Text, "Literal[\"plain\", \"soft\", \"figure\"] | None"), CONFIG | NO_PART),
    row("occlusion", Keyword(Render, "occlusion", NumberOrFlag, "bool | int"), CONFIG | NO_PART),
    row("reach", Keyword(Render, "reach", Number, "float | None"), NO_PART),
    row("sun", Keyword(Render, "sun", Tuples, "ArrayLike"), NO_PART),
    row("shadows", Keyword(Render, "shadows", Flag, "bool"), CONFIG | NO_PART),
    row("bounces", Keyword(Render, "bounces", Number, "int | None"), CONFIG | NO_PART),
    row("silhouette", Keyword(Render, "silhouette", Flag, "bool"), CONFIG | NO_PART),
    row("outline_width", Keyword(Render, "outline_width", Number, "float | None"), CONFIG),
    row("outline_color", Keyword(Render, "outline_color", Color, "Color | None"), CONFIG | NO_PART),
    row("depth_cue", Keyword(Render, "depth_cue", Flag, "bool"), CONFIG | NO_PART),
    row("depth_cue_strength", Keyword(Render, "depth_cue_strength", Number, "float | None"), CONFIG | NO_PART),
    row("layers", Keyword(Render, "layers", Number, "int | None"), NO_PART),
    row("ghost_rim", Keyword(Render, "ghost_rim", Flag, "bool"), NO_PART),
    row("opacity_shadows", Keyword(Render, "opacity_shadows", Flag, "bool"), NO_PART),
    row("background", Keyword(Render, "background", Color, "Color | None"), CONFIG | NO_PART),
    row("legend_in", Keyword(Render, "legend", Legend, "bool | Path"), NO_PART),
    row("label", Keyword(Render, "label", Text, "str | None"), NO_PART),
    row("scale_bar", Keyword(Render, "scale_bar", TextOrFlag, "bool | str"), NO_PART),
    row("mark", Keyword(Render, "mark", Marks, "Mapping[str, str]"), NO_PART),
    row("mark_one", Keyword(Render, "mark_one", Marks, "Mapping[str, str]"), NO_PART),
    row("mark_all", Keyword(Render, "mark_all", Flag, "bool"), NO_PART),
    row("accuracy", Keyword(Render, "accuracy", Text, "Literal[\"auto\", \"fast\", \"certified\", \"exact\"]"), CONFIG | NO_PART),
    row("method", Keyword(Render, "method", Text, "str | None"), CONFIG | NO_PART),
    row("tolerance", Keyword(Render, "tolerance", Number, "float | None"), CONFIG),
    row("transparent", Keyword(Render, "transparent", Flag, "bool"), CONFIG | NO_PART),
    row("output", Elsewhere("Frame.save"), NO_VIEW),
    row("aov", Elsewhere("aovs"), NO_VIEW | NO_PART),
    row("cryptomatte", Keyword(Render, "cryptomatte", Texts, "str | Iterable[str]"), NO_VIEW | NO_PART),
    row("group", Keyword(Vector, "group", Texts, "str | Iterable[str]"), NO_VIEW | NO_PART),
    row("detail", Keyword(Vector, "detail", Number, "float"), NO_VIEW | NO_PART),
    row("fps", Missing, NO_VIEW | NO_PART),
    row("bits", Keyword(Save, "bits", Number, "Literal[8, 16]"), CONFIG | NO_PART),
    row("dpi", Keyword(Save, "dpi", Number, "float | None"), CONFIG | NO_PART),
    row("trim", Keyword(Save, "trim", Flag, "bool"), NO_VIEW | NO_PART),
    row("unit", Keyword(Save, "unit", Number, "float"), CONFIG | NO_VIEW | NO_PART),
    row("no_return", Keyword(Save, "no_return", Text, "Literal[\"inf\", \"nan\", \"zero\"]"), CONFIG | NO_VIEW | NO_PART),
    row("raw", Elsewhere("Frame arrays"), NO_VIEW | NO_PART),
    row("legend", Elsewhere("legend"), NO_VIEW | NO_PART),
    row("crop", Keyword(Render, "crop", Tuple, "tuple[int, int, int, int] | None"), NO_VIEW),
    row("tile", Elsewhere("crop"), NO_VIEW),
    row("spin", Missing, NO_VIEW | NO_PART),
    row("file", Elsewhere("read_cameras"), NO_VIEW | NO_PART),
    row("preview", Outside, CONFIG),
    row("progress", Outside, CONFIG),
    row("quiet", Outside, CONFIG),
];

impl OptionRow {
    /// Whether lines of Python that render a picture of the page have it: the page does not set it by itself, and it names no file.
    pub(super) fn is_copied(&self) -> bool {
        self.uses & (PAGE | NO_VIEW) == 0
    }
}

const fn row(id: &'static str, python: Python, uses: u8) -> OptionRow {
    OptionRow { id, python, uses }
}

/// All options, in the order of the table.
pub(super) fn options() -> impl Iterator<Item = &'static OptionRow> {
    OPTIONS.iter()
}

/// The options of a call that are its keywords. The number of a frame is an argument of its own.
fn of_call(call: Call) -> impl Iterator<Item = &'static OptionRow> {
    options().filter(move |row| match row.python {
        Keyword(Render, ..) if call == Call::Sieve => row.uses & NO_PART == 0,
        Keyword(Render, ..) if call == Call::Vector => true,
        // Of the size on paper.
        Keyword(Save, ..) if call == Call::Vector => row.id == "dpi",
        Keyword(of, ..) => of == call && row.id != "frames",
        _ => false,
    })
}

/// The option with this keyword of a call: its identifier and the form of its value.
pub fn of_keyword(call: Call, keyword: &str) -> Option<(&'static str, Form)> {
    of_call(call).find_map(|row| match row.python {
        Keyword(_, name, form, _) if name == keyword => Some((row.id, form)),
        _ => None,
    })
}

/// The keywords of a call, with the types of their values.
pub fn keywords(call: Call) -> impl Iterator<Item = (&'static str, &'static str)> {
    of_call(call).filter_map(|row| match row.python {
        Keyword(_, name, _, kind) => Some((name, kind)),
        _ => None,
    })
}

/// The word of Python for the option with this identifier: its keyword, or what does the same.
pub(super) fn word_of(id: &str) -> Option<&'static str> {
    match options().find(|row| row.id == id)?.python {
        Keyword(_, word, ..) | Elsewhere(word) => Some(word),
        Outside | Missing => None,
    }
}

/// The Python call that takes the option with this identifier.
pub(super) fn call(id: &str) -> Option<Call> {
    match options().find(|row| row.id == id)?.python {
        Keyword(call, ..) => Some(call),
        _ => None,
    }
}

/// The identifiers of the options with a use.
pub(super) fn ids_with(uses: u8) -> impl Iterator<Item = &'static str> {
    options().filter(move |row| row.uses & uses != 0).map(|row| row.id)
}

/// Whether the option with this identifier has a use.
pub(super) fn has(id: &str, uses: u8) -> bool {
    ids_with(uses).any(|known| known == id)
}

/// A command whose help leaves out the options with these identifiers.
pub(super) fn hidden(command: Command, is_hidden: impl Fn(&str) -> bool) -> Command {
    command.mut_args(|arg| if is_hidden(arg.get_id().as_str()) { arg.hide(true) } else { arg })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Arguments;
    use crate::scene_args::SceneArgs;
    use clap::{Args, CommandFactory};
    use std::collections::BTreeSet;

    #[test]
    fn every_option_of_a_picture_has_a_row_and_every_row_is_an_option() {
        let picture = SceneArgs::augment_args(Command::new("render"));
        let options_of = |command: &Command| -> BTreeSet<String> {
            let longs = command.get_arguments().filter(|arg| arg.get_long().is_some());
            longs.map(|arg| arg.get_id().to_string()).collect()
        };
        let rows: BTreeSet<String> = options().map(|row| row.id.to_owned()).collect();
        assert_eq!(rows.len(), OPTIONS.len(), "a row each");
        let lacking: Vec<_> = options_of(&picture).difference(&rows).cloned().collect();
        assert!(lacking.is_empty(), "options without a row: {lacking:?}");
        let all: BTreeSet<String> = Arguments::command().get_subcommands().flat_map(&options_of).collect();
        let stale: Vec<_> = rows.difference(&all).cloned().collect();
        assert!(stale.is_empty(), "rows without an option: {stale:?}");
        let missing = options().filter(|row| matches!(row.python, Missing)).map(|row| row.id);
        let why = "a film is several frames, a zoom a vfov, a camera of a file the camera of its scene";
        assert_eq!(missing.collect::<Vec<_>>(), ["from", "zoom", "fps", "spin"], "without a keyword, because {why}");
    }
}
