//! Options for reading a scene, and for the radii and the colours of its particles.

use super::messages::note;
use super::signals::watch;
use super::typed::Typed;
use super::values::{color, numbers, positive, wholes};
use clap::Args;
use halfline::error::{Error, Result};
use halfline::scene::arrange::{Arrangement, Bead};
use halfline::scene::{MaterialName, is_opacity};
use halfline_files::read::style::{Coloring, Paint, Radii, RangeEnd, Scale, color_map};
use halfline_files::read::{
    Altloc, AtomStyle, ColumnNames, Format, FrameRange, Hold, Identity, ParticleOptions, Periodic, ReadOptions,
    Selection, Style,
};
use std::ffi::OsString;
use std::path::PathBuf;

/// The heading of the options that change how the spheres look.
pub(super) const LOOK: &str = "Spheres and colours";

/// The heading of the options that select particles.
const SELECTION: &str = "Selection";

/// The help of `--format`, with all names.
fn formats() -> String {
    let names: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
    format!("File format, if neither content nor name show it: {}", names.join(", "))
}

/// The options for reading a file that determine its spheres.
#[derive(Debug, Args)]
#[command(next_help_heading = "Input")]
pub(super) struct ReadArgs {
    #[arg(long, value_name = "F", help = formats())]
    format: Option<Format>,
    /// Columns of a table by meaning, with names or numbers from 1, such as x=pos_x,y=pos_y,z=pos_z or x=1,y=2,z=3,radius=4;
    /// meanings are x, y, z, radius, diameter, r, g, b, element. With numbers only the table needs no header.
    #[arg(long, value_name = "M=C,...")]
    columns: Option<ColumnNames>,
    /// Atom style of a LAMMPS data file, in place of that behind `Atoms #`: full, sphere, ..., "hybrid charge sphere", or the columns
    /// such as "id type q x y z".
    #[arg(long, value_name = "STYLE")]
    atom_style: Option<AtomStyle>,
    /// Frames of a sequence, counted from 1: 2, 1-10, 1-3,5,7-20:2, or 5- (to the last).
    #[arg(long, value_name = "A-B")]
    pub(super) frames: Option<FrameRange>,
    /// Frames that give a sequence its camera, default radii and range of colours: first (frame of the file), all
    /// (frames of the file, which is read twice), none (each frame by itself).
    #[arg(long, value_name = "H", default_value = "first", hide_default_value = true)]
    pub(super) hold: Hold,
    /// File with the atoms of a trajectory, such as PDB, GRO or LAMMPS data: the elements, radii, colours and columns that its
    /// frames (xtc, trr, dcd, dump, xyz, ...) lack, by their ids where both have them.
    #[arg(long, value_name = "FILE")]
    pub(super) topology: Option<PathBuf>,
    /// Another file of particles, in the same picture; may be repeated. The column file has the name of each particle's file without
    /// its extension. A file with one frame is in every frame of the others.
    #[arg(long, value_name = "FILE")]
    pub(super) add: Vec<PathBuf>,
    /// Column that identifies particles: all frames of a film have the order of the first, whatever the order of their rows; row
    /// leaves them as they are [default: id, in dumps and extended XYZ that have it].
    #[arg(long, value_name = "COLUMN")]
    identity: Option<Identity>,
    /// Model number in a PDB or mmCIF file.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    model: Option<i64>,
    /// Alternate locations of atoms: all, highest (occupancy), or an identifier.
    #[arg(long, value_name = "A", default_value = "all")]
    altloc: Altloc,
    /// Biological assembly to build, by its identifier, such as 1.
    #[arg(long, value_name = "ID")]
    assembly: Option<String>,
    /// Takes the atoms of a small-molecule CIF as listed; by default its symmetry fills the cell.
    #[arg(long)]
    as_listed: bool,
    /// Fails if the scene contains anything but spheres.
    #[arg(long)]
    strict: bool,
    /// Takes only the particles that an expression selects, such as "protein and not name H*", "chain A B", "resid
    /// 10:20", "element C N", "type 2", "bfactor < 30", "within 5 of (resname HEM)"; if repeated, the particles
    /// that any selects.
    #[arg(long, help_heading = SELECTION, value_name = "EXPR")]
    select: Vec<Selection>,
    /// Leaves out the particles that an expression selects; may be repeated.
    #[arg(long, help_heading = SELECTION, value_name = "EXPR")]
    hide: Vec<Selection>,
    /// Radii of elements: vdw (van der Waals), covalent.
    #[arg(long, help_heading = LOOK, value_name = "R", default_value = "vdw")]
    radii: Radii,
    /// Radius of all spheres, or with EXPR=X of selected ones; overrides the file. Repeated, later ones win.
    #[arg(long, help_heading = LOOK, value_name = "[EXPR=]X", value_parser = radius_rule, allow_negative_numbers = true)]
    radius: Vec<Rule<f64>>,
    /// Multiplies every radius.
    #[arg(long, help_heading = LOOK, value_name = "X", default_value = "1", value_parser = positive("number"),
        allow_negative_numbers = true)]
    radius_scale: f64,
    /// Moves the particles that EXPR selects by X,Y,Z, such as 'file model=0,0,30'; selections and colours see where the file has them.
    /// Repeated, later ones win.
    #[arg(id = "move", long = "move", help_heading = LOOK, value_name = "EXPR=X,Y,Z", value_parser = move_rule)]
    moves: Vec<Rule<[f64; 3]>>,
    /// Moves every particle into the periodic cell of the file, before --copies.
    #[arg(long, help_heading = LOOK, conflicts_with = "unwrap")]
    wrap: bool,
    /// Makes molecules whole that the cell cuts: by the image flags ix, iy, iz, else along bonds (by distance, where elements
    /// are known) and by the numbers mol of molecules or by residues. A warning says what stays cut.
    #[arg(long, help_heading = LOOK)]
    unwrap: bool,
    /// Periodic copies along the three edges of the file's cell, original included.
    #[arg(long, help_heading = LOOK, value_name = "A,B,C", value_parser = copies)]
    copies: Option<[u32; 3]>,
    /// Removes spheres whose centre c has X,Y,Z . c > D; may be repeated.
    #[arg(long, help_heading = LOOK, value_name = "X,Y,Z,D", value_parser = plane, allow_hyphen_values = true)]
    clip: Vec<[f64; 4]>,
    /// Draws the edges of the file's periodic cell with beads, of this radius if given.
    #[arg(long, help_heading = LOOK, value_name = "RADIUS", value_parser = positive("number"), num_args = 0..=1,
        require_equals = true)]
    cell: Option<Option<f64>>,
    /// The earlier name of --cell.
    #[arg(long, hide = true, value_name = "RADIUS", value_parser = positive("number"), num_args = 0..=1, require_equals = true,
        conflicts_with = "cell")]
    outline: Option<Option<f64>>,
}

/// The options for the colours of the spheres.
#[derive(Debug, Args)]
#[command(next_help_heading = LOOK)]
pub(super) struct ColorArgs {
    #[command(flatten)]
    typed: Typed,
    /// Colour of all spheres, or with EXPR=C of selected ones: a CSS name such as red, #rgb or #rrggbb in sRGB, r,g,b in
    /// linear RGB, or element for the colours of the elements; a caption is the name of EXPR in the legend. Repeated, later
    /// ones win.
    #[arg(long, value_name = "[EXPR=]C[:CAPTION]", value_parser = color_rule)]
    color: Vec<Rule<Paint>>,
    /// Material in pictures of all spheres, or with EXPR=M of selected ones: matte, plastic (with highlights of lights), metal (a
    /// mirror of its colour), glass. Repeated, later ones win.
    #[arg(long, value_name = "[EXPR=]M", value_parser = material_rule)]
    material: Vec<Rule<MaterialName>>,
    /// Exponent of the highlights of plastic; the greater, the smaller they are [default: 40].
    #[arg(long, value_name = "N", value_parser = positive("number"), allow_negative_numbers = true)]
    shine: Option<f64>,
    /// Opacity in pictures of all spheres, or with EXPR=A of selected ones: above 0, and at most 1; a caption is the name of EXPR in
    /// the legend. Repeated, later ones win.
    #[arg(long, value_name = "[EXPR=]A[:CAPTION]", value_parser = opacity_rule, allow_negative_numbers = true)]
    opacity: Vec<Rule<f32>>,
    /// Colours by element, chain, x, y, z, distance (from the middle), or any column of the file; several columns (vx,vy,vz) by their length.
    #[arg(long, value_name = "COLUMN,...")]
    pub(super) color_by: Option<String>,
    /// Colour map: viridis, inferno, magma, plasma, cividis, cubehelix, turbo, rdylbu, bwr, coolwarm, batlow, roma, vik,
    /// plddt, grays, category [default: category for names, else viridis]. NAME_r reverses it; plddt has four classes from 0 to
    /// 100; a name with a dot is a file of colours (CSV, JSON).
    #[arg(long, value_name = "M")]
    map: Option<String>,
    /// Values at the ends of the colour map, or their percentiles, such as 1%,99% [default: minimum and maximum].
    #[arg(long, value_name = "A,B", value_parser = range, requires = "color_by",
        allow_hyphen_values = true)]
    pub(super) range: Option<[RangeEnd; 2]>,
    /// Uses a logarithmic colour scale.
    #[arg(long, requires = "color_by")]
    log: bool,
    /// Colour of particles that --color-by has no number for, as of --background [default: grey].
    #[arg(long, value_name = "COLOR", value_parser = color)]
    nan_color: Option<[f32; 3]>,
    /// Writes the legend of the colours, of --color-by or else of the elements: .svg or .png; with %d for several frames
    /// without --range.
    #[arg(long, value_name = "FILE")]
    pub(super) legend: Option<PathBuf>,
    /// Title of the legend, where one is drawn, such as 'speed / km/s', in place of the name of what is coloured.
    #[arg(long, value_name = "TEXT", value_parser = caption)]
    legend_title: Option<String>,
}

impl ReadArgs {
    /// The options for reading, with the colours of the file. Says that an option has another name now.
    pub(super) fn options(&self) -> ReadOptions {
        if self.outline.is_some() {
            note(format_args!("--outline is now called --cell; the outlines of spheres are drawn by --silhouette"));
        }
        self.quiet_options()
    }

    /// The same without a word about names.
    pub(super) fn quiet_options(&self) -> ReadOptions {
        let particles = ParticleOptions {
            strict: self.strict,
            format: self.format,
            columns_named: self.columns.clone().unwrap_or_default(),
            atom_style: self.atom_style.clone(),
            frames: self.frames.clone().unwrap_or_default(),
            topology: self.topology.clone(),
            added: self.add.clone(),
            identity: self.identity.clone().unwrap_or_default(),
            model: self.model,
            altloc: self.altloc.clone(),
            assembly: self.assembly.clone(),
            as_listed: self.as_listed,
            periodic: match (self.wrap, self.unwrap) {
                (true, _) => Periodic::Wrap,
                (_, true) => Periodic::Unwrap,
                _ => Periodic::AsListed,
            },
            select: self.select.clone(),
            hide: self.hide.clone(),
            watch: watch(),
            ..ParticleOptions::default()
        };
        let style = Style {
            radii: self.radii,
            radius: Rule::for_all(&self.radius),
            radius_scale: self.radius_scale,
            sizes: Rule::selected(&self.radius),
            moves: Rule::selected(&self.moves),
            ..Style::default()
        };
        ReadOptions { particles, hold: self.hold, style, ..ReadOptions::default() }
    }

    /// The choice of `--hold` by name, for reports; `None` without `--frames`.
    pub(super) fn hold(&self) -> Option<&'static str> {
        self.frames.as_ref().map(|_| self.hold.name())
    }

    /// A sentence that names the frames that `--hold` chooses; `None` without `--frames`, and for `--hold none`.
    pub(super) fn hold_words(&self) -> Option<String> {
        let from = match (self.hold()?, self.hold) {
            (_, Hold::First) => "the first frame",
            (_, Hold::All) => "all frames",
            (_, Hold::None) => return None,
        };
        Some(format!("camera, default radii and the range of colours come from {from} of the file (see --hold)"))
    }

    /// The arrangement of the spheres.
    pub(super) fn arrangement(&self) -> Arrangement {
        let bead = |radius: Option<f64>| radius.map_or(Bead::Thin, Bead::Radius);
        let outline = self.cell.or(self.outline).map(bead);
        Arrangement { copies: self.copies.unwrap_or([1; 3]), clip: self.clip.clone(), outline }
    }
}

impl ColorArgs {
    /// The same options with these colours.
    ///
    /// # Errors
    /// [`Error::Settings`] for one colour and a column.
    pub(super) fn of(&self, options: ReadOptions) -> Result<ReadOptions> {
        let is_plastic = |rule: &Rule<MaterialName>| rule.value == MaterialName::Plastic;
        if self.shine.is_some() && !self.material.iter().any(is_plastic) {
            let problem = "--shine belongs to plastic, and no sphere is made of it";
            return Err(Error::settings(problem, "add --material plastic, or remove --shine"));
        }
        let shine = self.shine.map(|shine| shine as f32);
        let material = |name: MaterialName| name.material(shine);
        let style = Style {
            coloring: self.coloring()?,
            paints: Rule::selected(&self.color),
            opacity: Rule::for_all(&self.opacity),
            fades: Rule::selected(&self.opacity),
            material: Rule::for_all(&self.material).map(material),
            matters: Rule::selected(&self.material).into_iter().map(|(of, name)| (of, material(name))).collect(),
            legend_title: self.legend_title.clone(),
            ..options.style
        };
        Ok(ReadOptions { style, ..options })
    }

    /// Whether the legend has a title of its own.
    pub(super) fn has_title(&self) -> bool {
        self.legend_title.is_some()
    }

    /// Whether the range is given by two numbers, so that all frames have one.
    pub(super) fn has_fixed_range(&self) -> bool {
        self.range.is_some_and(|ends| ends.iter().all(|end| matches!(end, RangeEnd::Value(_))))
    }

    /// The file of the colour map.
    pub(super) fn map_file(&self) -> Option<PathBuf> {
        self.map.as_ref().map(PathBuf::from).filter(|path| path.is_file())
    }

    fn coloring(&self) -> Result<Coloring> {
        let by = self.color_by.as_deref();
        // A preference from elsewhere may apply to no colours.
        let applies = |id| self.typed.has(id) || by.is_some_and(|by| by != "element");
        let map = self.map.as_deref().filter(|_| applies("map")).map(color_map).transpose()?;
        let nan_color = self.nan_color.filter(|_| applies("nan_color"));
        let scale = Scale { map, range: self.range, log: self.log, nan_color, ..Scale::of(Vec::new()) };
        Coloring::of(Rule::for_all(&self.color), by, scale)
    }
}

/// A value for all spheres, or for those that an expression selects.
#[derive(Debug, Clone)]
pub(super) struct Rule<T> {
    selection: Option<Selection>,
    value: T,
}

impl<T: Copy> Rule<T> {
    /// Parses `EXPR=VALUE` or `VALUE`; an expression may contain an equals sign, a value does not.
    pub(super) fn parse(text: &str, value: impl Fn(&str) -> Result<T, String>) -> Result<Self, String> {
        match text.rsplit_once('=') {
            None => Ok(Self { selection: None, value: value(text)? }),
            Some((expression, last)) => {
                let selection = expression.parse().map_err(|e: Error| e.to_string())?;
                Ok(Self { selection: Some(selection), value: value(last.trim())? })
            }
        }
    }

    /// Parses also `EXPR=VALUE:CAPTION`, whose caption is the name of the selection in a legend. A colon of an expression is in front of
    /// its value, so the first colon that ends a rule begins the caption.
    fn captioned(text: &str, value: impl Fn(&str) -> Result<T, String>) -> Result<Self, String> {
        let whole = Self::parse(text, &value);
        let rule = |(at, _): (usize, &str)| Some((Self::parse(&text[..at], &value).ok()?, &text[at + 1..]));
        let found = if whole.is_err() { text.match_indices(':').find_map(rule) } else { None };
        match found {
            None => whole,
            Some((Self { selection: None, .. }, _)) => {
                Err("a caption belongs to a selection: write EXPR=VALUE:CAPTION".into())
            }
            Some((Self { selection: Some(selection), value }, words)) => {
                Ok(Self { selection: Some(selection.captioned(&caption(words)?)), value })
            }
        }
    }

    /// The value for all spheres; the last one wins.
    pub(super) fn for_all(rules: &[Self]) -> Option<T> {
        rules.iter().rev().find(|rule| rule.selection.is_none()).map(|rule| rule.value)
    }

    /// The rules for selected spheres.
    pub(super) fn selected(rules: &[Self]) -> Vec<(Selection, T)> {
        rules.iter().filter_map(|rule| Some((rule.selection.clone()?, rule.value))).collect()
    }
}

/// The most letters of a caption or a title.
const MOST_CAPTION: usize = 200;

/// The words of a legend.
fn caption(text: &str) -> Result<String, String> {
    match (text.trim(), text.chars().count()) {
        ("", _) => Err("the words for the legend are empty".into()),
        (_, letters) if letters > MOST_CAPTION => Err(format!("found {letters} letters, more than {MOST_CAPTION}")),
        (words, _) => Ok(words.to_owned()),
    }
}

fn radius_rule(text: &str) -> Result<Rule<f64>, String> {
    Rule::parse(text, positive("number"))
}

fn move_rule(text: &str) -> Result<Rule<[f64; 3]>, String> {
    let expected = "expected EXPR=X,Y,Z such as 'chain B=0,0,30'";
    let rule = Rule::parse(text, |text| numbers(text).ok_or_else(|| expected.to_owned()))?;
    rule.selection.is_some().then_some(rule).ok_or_else(|| expected.to_owned())
}

fn color_rule(text: &str) -> Result<Rule<Paint>, String> {
    let value = |text: &str| if text == "element" { Ok(Paint::Element) } else { color(text).map(Paint::One) };
    let rule = Rule::captioned(text, value)?;
    match rule.selection.as_ref().and_then(Selection::caption) {
        Some(_) if rule.value == Paint::Element => {
            Err("the colours of elements have a row for each element; remove the caption".into())
        }
        _ => Ok(rule),
    }
}

fn material_rule(text: &str) -> Result<Rule<MaterialName>, String> {
    Rule::parse(text, |name| name.parse().map_err(|error: Error| error.to_string()))
}

fn opacity_rule(text: &str) -> Result<Rule<f32>, String> {
    let expected =
        "expected a number above 0 and at most 1, or EXPR=A such as 'chain A=0.3'; --hide leaves spheres out";
    Rule::captioned(text, |text| {
        // By way of f64, as numbers of other programs are rounded.
        let opacity = text.parse().ok().map(|opacity: f64| opacity as f32);
        opacity.filter(|opacity| is_opacity(*opacity)).ok_or_else(|| expected.into())
    })
}

fn range(text: &str) -> Result<[RangeEnd; 2], String> {
    let expected = "expected two different finite numbers with a comma between them, such as --range 0,1.5, or percentiles \
                    such as --range 1%,99%";
    let ends = text.split_once(',').and_then(|(low, high)| Some([low.parse().ok()?, high.parse().ok()?]));
    ends.filter(|[low, high]| low != high).ok_or_else(|| expected.into())
}

/// Refuses a range of two words: clap would take the second word for a file.
///
/// # Errors
/// [`Error::Settings`] with the words as they are meant.
pub(super) fn check_range(words: &[OsString]) -> Result<()> {
    let words: Vec<&str> = words.iter().map(|word| word.to_str().unwrap_or("")).collect();
    let joined = words.windows(2).filter_map(|pair| Some([pair[0].strip_prefix("--range=")?, pair[1]]));
    let apart = words.windows(3).filter(|three| three[0] == "--range").map(|three| [three[1], three[2]]);
    match joined.chain(apart).find(|pair| pair.iter().all(|word| word.parse::<f64>().is_ok())) {
        Some([low, high]) => Err(Error::settings(
            format!("--range has two words, {low} and {high}"),
            format!("put a comma between its numbers: --range={low},{high}"),
        )),
        None => Ok(()),
    }
}

/// The half space of a clip plane.
pub(super) fn plane(text: &str) -> Result<[f64; 4], String> {
    numbers(text)
        .filter(|p| p[..3] != [0.0; 3])
        .ok_or_else(|| "expected a direction and a number, such as 0,0,1,2.5".into())
}

fn copies(text: &str) -> Result<[u32; 3], String> {
    let numbers = wholes(text).filter(|numbers| !numbers.contains(&0));
    numbers.ok_or_else(|| "expected three positive whole numbers, such as 2,2,1".into())
}
