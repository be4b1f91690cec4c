//! The spheres of a file in blocks, for files larger than memory: while a block is used, the next one is read.

mod start;

use super::native;
use super::options::ReadOptions;
use super::sequence::SceneFrame;
use super::style::{Coloring, joined_categories};
use halfline::error::{Error, Place, Result};
use halfline::frame::legend::Legend;
use halfline::quote::count;
use halfline::quote::setting::{
    ADD, COLOR, COLOR_BY, FRAMES, MAP, MATERIAL, RADIUS, RANGE, STREAM, TOPOLOGY, UNWRAP, WRAP,
};
use halfline::scene::{DEFAULT_COLOR, Scene, Spheres};
use halfline_particles::derived;
use halfline_particles::input::read_once;
use halfline_particles::opened::SceneSource;
use halfline_particles::particles::colors::ColorSurvey;
use halfline_particles::particles::frame::{Particles, RuleTarget};
use halfline_particles::particles::survey::Part;
use halfline_particles::select::{self, Note, Notes};
use halfline_particles::{Format, FrameTime, Periodic, Skipped};
use start::{colors_of, start, texts_of};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::thread::JoinHandle;

/// The spheres of one frame of a file, block by block, in the order of the file. They are those that
/// [`Sequence`](super::Sequence) gives in memory.
pub struct SphereBlocks {
    /// The first part, where it was looked at.
    first: Option<Part>,
    parts: Receiver<Part>,
    /// The thread that reads; it returns what remains after the last whole part.
    reader: Option<JoinHandle<Result<Option<Particles>>>>,
    options: ReadOptions,
    /// The columns that colours and selections read.
    columns: Vec<String>,
    file: Place,
    /// The survey of the file's colours; where it can be read once only, of the colours so far.
    colors: Option<ColorSurvey>,
    /// Particles so far, and those that are selected.
    count: u64,
    left: u64,
    skipped: Skipped,
    /// The warnings about parts without their digits, so that each is reported once.
    reported: BTreeSet<String>,
    /// The messages about selections, joined block by block.
    notes: Notes,
    /// For each of [`ReadOptions::marks`], the spheres of the last block that it selects, and the messages about it.
    marked: Vec<Spheres>,
    mark_notes: Vec<Notes>,
    /// The legend without rules of the style, and the number of particles that each rule colours.
    legend: Option<Legend>,
    painted: Vec<u64>,
    /// Whether the spheres have the colours of the file, if it has some.
    is_colored: bool,
    /// Whether the blocks are read for the range of their colours, and the range so far.
    surveys: bool,
    range: Option<[f64; 2]>,
    format: Format,
    /// Of a scene file, whether its spheres have colours; `None` for particles.
    scene: Option<bool>,
    /// Whether some particle has an element, and whether the frame has a cell.
    has_elements: bool,
    has_cell: bool,
    when: FrameTime,
}

impl SphereBlocks {
    /// Opens `path`.
    ///
    /// # Errors
    /// As [`Sequence::open`](super::Sequence::open); [`Error::Settings`] for formats that are not lists of rows, and
    /// for options that need all particles at once: words of selections such as `within`, moves by a periodic cell, a
    /// range of colours that is not given (see [`Self::survey`]).
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        check(options)?;
        if needs_range(options) {
            let problem = format!("{STREAM}: the range of colours depends on all particles");
            return Err(Error::settings(problem, format!("add {RANGE} LOW,HIGH")));
        }
        Self::begin(path, options, false, options.style.coloring == Coloring::File)
    }

    /// As [`Self::open`], for what depends on all spheres: the range of colours need not be given, and [`Self::range`] has it
    /// after the last block. The blocks have no colours.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn survey(path: &Path, options: &ReadOptions) -> Result<Self> {
        check(options)?;
        Self::begin(path, options, needs_range(options), false)
    }

    fn begin(path: &Path, options: &ReadOptions, surveys: bool, is_colored: bool) -> Result<Self> {
        let source = SceneSource::open(path, options.particles.known_format(), &options.particles.watch)?;
        if !source.format.is_in_blocks() && source.format != Format::NATIVE {
            let problem = format!("{} files are not read as a stream", source.format.name());
            let mend = format!(
                "remove {STREAM}, or use an array (npy), a table (csv, pts, ptx), xyz, a LAMMPS dump, ply, las or a scene (toml)"
            );
            return Err(Error::settings(problem, mend));
        }
        let format = source.format;
        let reads_twice = is_colored && format != Format::NATIVE && read_once(path).is_none();
        let colors = if reads_twice { colors_of(path, options)? } else { None };
        let (mut first, mut started) = (None, start(source, options, Vec::new())?);
        let worded = options.reading().worded_columns();
        if !worded.is_empty() && format != Format::NATIVE && read_once(path).is_none() {
            // Without a text in its first rows, a column has the type that all of them say.
            first = started.1.recv().ok();
            let is_named =
                |part: &Part| worded.iter().all(|name| part.labels.contains_key(name) || !part.has.contains(name));
            if !first.as_ref().is_some_and(is_named) {
                let texts = texts_of(path, options, &worded)?;
                if !texts.is_empty() {
                    let source = SceneSource::open(path, options.particles.known_format(), &options.particles.watch)?;
                    (first, started) = (None, start(source, options, texts)?);
                }
            }
        }
        let (scene, parts, reader) = started;
        let file = Place::file(path.display().to_string());
        Ok(Self {
            first,
            parts,
            reader: Some(reader),
            options: options.clone(),
            columns: options.reading().named_columns(),
            file,
            colors,
            count: 0,
            left: 0,
            skipped: Skipped::default(),
            reported: BTreeSet::new(),
            notes: Notes::default(),
            marked: Vec::new(),
            mark_notes: options.marks.iter().map(|_| Notes::default()).collect(),
            legend: None,
            painted: options.style.painted(&Particles::default()),
            is_colored,
            surveys,
            range: None,
            format,
            scene,
            has_elements: false,
            has_cell: false,
            when: FrameTime::default(),
        })
    }

    /// The scene of a scene file (TOML) without spheres, and the files that it refers to; `None` for files of particles, and for
    /// what can be read once.
    ///
    /// # Errors
    /// As [`Sequence::open`](super::Sequence::open).
    pub fn scene(path: &Path, options: &ReadOptions) -> Result<Option<(SceneFrame, Vec<PathBuf>)>> {
        if read_once(path).is_some() {
            return Ok(None);
        }
        let source = SceneSource::open(path, options.particles.known_format(), &options.particles.watch)?;
        if source.format != Format::NATIVE {
            return Ok(None);
        }
        let (read, _) = native::without_files(source.reader, path, &options.particles.watch)?;
        let native::Read { scene, skipped, look, aperture, cuts, files } = read;
        let scene = Scene { spheres: Spheres::default(), ..scene };
        let frame = SceneFrame { skipped, has_camera: true, look, aperture, cuts, ..SceneFrame::new(1, scene) };
        Ok(Some((frame, files)))
    }

    /// The next spheres; `None` after the last. Their numbers are checked here, where the row or the particle of the file is
    /// known, and nowhere else: [`Stream::add`](halfline::render::stream::Stream::add) relies on it as long as they are not
    /// changed.
    ///
    /// # Errors
    /// As [`scene`](super::scene); [`Error::Settings`] where radii or colours depend on all particles.
    pub fn next_block(&mut self) -> Result<Option<Spheres>> {
        self.options.particles.watch.check()?;
        if let Some(part) = self.first.take().or_else(|| self.parts.recv().ok()) {
            return self.styled_block(Particles::of_part(part)).map(Some);
        }
        let Some(reader) = self.reader.take() else { return Ok(None) };
        let rest = reader.join().unwrap_or(Err(Error::Interrupted))?;
        let Some(rest) = rest else {
            return Err(Error::scene(self.file.clone(), "the file has no such frame", format!("use another {FRAMES}")));
        };
        self.when = rest.when;
        let last = self.styled_block(rest)?;
        self.skipped.assumed.extend(self.notes.messages());
        Ok(Some(last))
    }

    /// Takes those spheres of the last block that each of [`ReadOptions::marks`] selects; nothing for a block without spheres.
    pub fn marked(&mut self) -> Vec<Spheres> {
        std::mem::take(&mut self.marked)
    }

    /// The messages about each of [`ReadOptions::marks`]; complete after the last block.
    #[must_use]
    pub fn mark_notes(&self) -> Vec<Vec<String>> {
        self.mark_notes.iter().map(|notes| notes.messages().collect()).collect()
    }

    /// The items left out and the assumptions so far; complete after the last block.
    #[must_use]
    pub fn skipped(&self) -> &Skipped {
        &self.skipped
    }

    /// The number of spheres so far, before clip planes.
    #[must_use]
    pub fn spheres(&self) -> u64 {
        self.left
    }

    /// The range of the numbers that give the colours, as in memory; complete after the last block of [`Self::survey`]. `None`
    /// where no number is finite, and for a range that is given.
    #[must_use]
    pub fn range(&self) -> Option<[f64; 2]> {
        self.range
    }

    /// The legend of the colours, once a block was read; with [`Self::range`], where that is known.
    #[must_use]
    pub fn legend(&self) -> Option<Legend> {
        let legend = self.options.style.with_overrides(self.legend.clone(), &self.painted)?;
        Some(Legend { range: self.range.unwrap_or(legend.range), ..legend })
    }

    /// The time and the step of the frame; known after the last block.
    #[must_use]
    pub fn when(&self) -> FrameTime {
        self.when
    }

    /// Whether the frame is of atoms without a box, as [`SceneFrame::is_molecule`](super::SceneFrame::is_molecule); known
    /// after the last block.
    #[must_use]
    pub fn is_molecule(&self) -> bool {
        self.format.is_molecule(self.has_elements, self.has_cell)
    }

    fn styled_block(&mut self, mut part: Particles) -> Result<Spheres> {
        if let Some(is_colored) = self.scene {
            return self.block_of_scene(part, is_colored);
        }
        self.has_elements |= part.elements.iter().any(|number| *number != 0);
        self.has_cell |= part.cell.is_some();
        if part.positions.is_empty() {
            self.skipped.append(part.skipped);
            return Ok(Spheres::default());
        }
        // The reader speaks of the whole file, the style of a part.
        self.skipped.append(std::mem::take(&mut part.skipped));
        part.add_lengths(&self.columns)?;
        derived::refuse(&part, &self.columns)?;
        self.lighten(&mut part)?;
        let size = part.positions.len();
        part.before = self.count;
        self.count += size as u64;
        let style = &self.options.style;
        // As in memory, where one atom with an element is enough for all to have the radius of theirs.
        let spaced = style.spaced(&part).filter(|_| !self.has_elements);
        self.notes.join(select::apply(&self.options.selections(), &mut part)?);
        let left = part.positions.len();
        self.left += left as u64;
        if left == 0 {
            return Ok(Spheres::default());
        }
        let lacks_radius = || (0..left).any(|n| part.rule(RuleTarget::Radius, n).is_none());
        if style.default_radius.is_none() && spaced.is_some() && lacks_radius() {
            let problem = "the file has no radii, and half the mean spacing needs all particles";
            return Err(Error::settings(problem, format!("add {RADIUS}, or remove {STREAM}")));
        }
        let masks = std::mem::take(&mut part.marks);
        let painted = self.options.style.painted(&part);
        self.painted.iter_mut().zip(painted).for_each(|(all, more)| *all += more);
        let (mut spheres, skipped, legend) = self.options.style.part_to_spheres(part, spaced, &self.file)?;
        if self.surveys {
            spheres.colors = None;
            self.see(legend.as_ref())?;
        }
        self.report(skipped.assumed, left as u64);
        self.legend = match (self.legend.take(), legend) {
            (Some(first), Some(second)) => Some(joined_categories(first, &second)),
            (first, second) => first.or(second),
        };
        self.mark(masks, &spheres);
        Ok(spheres.checked())
    }

    /// The spheres of a block of a scene file, whose spheres have colours or none.
    fn block_of_scene(&mut self, part: Particles, is_colored: bool) -> Result<Spheres> {
        self.skipped.append(part.skipped);
        let mut spheres = Spheres { centers: part.positions.into(), radii: part.radii.into(), ..Spheres::default() };
        // As in memory: spheres without a colour have the default one where others have some.
        let count = spheres.len();
        spheres.colors = is_colored.then(|| match &part.colors[..] {
            [] => vec![DEFAULT_COLOR; count].into(),
            _ => part.colors.into(),
        });
        self.options.style.restyle(&mut spheres)?;
        let masks = select::marks_of(&self.options.marks, self.count, &spheres.centers, &spheres.radii)?;
        self.count += count as u64;
        self.left += count as u64;
        self.mark(masks, &spheres);
        Ok(spheres)
    }

    /// Reports warnings about a part of so many particles, each once, whatever its numbers are.
    fn report(&mut self, warnings: Vec<String>, particles: u64) {
        for warning in warnings {
            let what: String = warning.chars().filter(|c| !c.is_ascii_digit()).collect();
            if self.reported.insert(what) {
                self.skipped.assumed.push(format!("in a part of {}: {warning}", count(particles, "particle")));
            }
        }
    }

    /// Makes the colours of a part linear light, like the colours of the file in memory.
    fn lighten(&mut self, part: &mut Particles) -> Result<()> {
        if !self.is_colored || part.colors.is_empty() {
            part.colors.clear();
            return Ok(());
        }
        let before = self.colors.map(|colors| colors.scale());
        let colors = self.colors.get_or_insert_default();
        colors.see(part.color_type, &part.colors);
        if before.is_some_and(|before| before != colors.scale()) {
            let problem =
                "the colours of one part are levels of 8 or of 16 bits or all 0, and the colours of another are not";
            return Err(Error::settings(problem, format!("add {COLOR}, or remove {STREAM}")));
        }
        part.lighten_part(colors);
        if let Some(warning) = colors.warning().filter(|warning| !self.skipped.assumed.contains(warning)) {
            self.skipped.assumed.push(warning);
        }
        Ok(())
    }

    /// Stores the marked spheres of a block, and joins the messages about the marks.
    fn mark(&mut self, masks: Vec<(Vec<bool>, Vec<Note>)>, spheres: &Spheres) {
        self.marked.clear();
        for ((mask, block), notes) in masks.into_iter().zip(&mut self.mark_notes) {
            self.marked.push(spheres.part(&mask));
            notes.join(block);
        }
    }

    /// Widens the range of colours by the range of a part.
    fn see(&mut self, legend: Option<&Legend>) -> Result<()> {
        let Some(Legend { name, range: [low, high], categories, names, .. }) = legend else { return Ok(()) };
        if !names.is_empty() {
            let problem = format!("{STREAM}: {COLOR_BY}: the colours of the names in {name} depend on all particles");
            return Err(Error::settings(problem, format!("use a column of numbers, or remove {STREAM}")));
        }
        if !categories.is_empty() {
            let problem =
                format!("{STREAM}: {COLOR_BY}: {name} has categories, whose colours need all particles in memory");
            return Err(Error::settings(
                problem,
                format!("add {RANGE} LOW,HIGH or {MAP} to colour by numbers, or remove {STREAM}"),
            ));
        }
        let [least, most] = self.range.unwrap_or([*low, *high]);
        self.range = Some([least.min(*low), most.max(*high)]);
        Ok(())
    }
}

/// Refuses what needs all particles at once.
fn check(options: &ReadOptions) -> Result<()> {
    let reading = options.reading();
    let word = reading.all_selections().find_map(|selection| Some((selection, selection.word_for_several()?)));
    let (problem, mend) = if let Some((selection, word)) = word {
        (
            format!("`{word}` in the selection `{}` needs all particles in memory", selection.brief()),
            format!("select by columns, elements or coordinates, or remove {STREAM}"),
        )
    } else if matches!(&options.style.coloring, Coloring::Column(scale) if scale.has_percentile()) {
        ("percentiles need all values in memory".to_owned(), format!("add {RANGE} LOW,HIGH as numbers"))
    } else if options.particles.periodic != Periodic::AsListed {
        (format!("{WRAP} and {UNWRAP} need all particles in memory"), "remove them".to_owned())
    } else if options.particles.topology.is_some() {
        (format!("{TOPOLOGY} needs all particles in memory"), format!("remove it, or {STREAM}"))
    } else if !options.particles.added.is_empty() {
        (format!("{ADD} needs all particles in memory"), format!("remove it, or {STREAM}"))
    } else if options.style.has_materials() {
        (
            "materials are seen under lights, which need all particles in memory".to_owned(),
            format!("remove {MATERIAL}, or {STREAM}"),
        )
    } else if options.particles.frames.count() > 1 {
        ("a stream is one frame".to_owned(), format!("select one with {FRAMES} N"))
    } else {
        return Ok(());
    };
    Err(Error::settings(format!("{STREAM}: {problem}"), mend))
}

/// Whether the range of the colours depends on all particles.
fn needs_range(options: &ReadOptions) -> bool {
    matches!(&options.style.coloring, Coloring::Column(scale) if scale.known_range().is_none())
}
