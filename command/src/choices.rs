//! The choices of a reading and of a picture, by options of the command, for scenes that another program has in memory: the keywords of the
//! Python package are these options, and nothing else understands them.

use super::figure;
use super::framing;
use super::legend;
use super::messages::flags;
use super::option_table::{options as all_options, word_of};
use super::picture_scene::PictureScene;
use super::render::picture::{complete, write_legend};
use super::scene_args::SceneArgs;
use super::scene_frames;
use super::together::{SpheresOf, together};
use super::view::{Given, Parser, WrittenOption};
use halfline::error::Result;
use halfline::explain::Explanation;
use halfline::frame::color_map::ColorMap;
use halfline::frame::{Aov, Frame};
use halfline::progress::{Cancel, Watch};
use halfline::render::Renderer;
use halfline::render::stream::{Part, PartView, Visible};
use halfline::scene::arrange::Arrangement;
use halfline::scene::{Cell, Cuts, Framing, Scene};
use halfline::settings::{Backend, Settings};
use halfline_drawing::figure::Figure;
use halfline_drawing::inset::Panels;
use halfline_files::read::cut::CutRules;
use halfline_files::read::matte::MatteNames;
use halfline_files::read::style::Coloring;
use halfline_files::read::{Keep, ReadOptions, SceneFrame};
use halfline_files::write::file::Target;
use halfline_files::write::format::FormatOptions;
use halfline_files::write::mattes;
use halfline_files::write::vector::VectorFormat;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The options of a reading or of a picture.
#[derive(Debug)]
pub struct Choices {
    args: SceneArgs,
}

/// A scene of another program, from which a picture is made.
pub struct ChosenScene<'a> {
    /// The spheres, with the size and the camera of the picture; without a camera of its own it shows all spheres.
    pub frame: SceneFrame,
    /// The cell whose edges the picture may draw; `None` without one.
    pub edges: Option<Cell>,
    /// Whether the edges of the cell are among the spheres.
    pub is_outlined: bool,
    /// The name of its file, which labels may show.
    pub file: Option<String>,
    /// The columns that give its colours.
    pub colored_by: Option<&'a str>,
    /// The frame that it is a part of.
    pub part: Option<&'a Part>,
}

/// A picture that is ready to render.
pub struct ChosenPicture<'a> {
    choices: &'a Choices,
    picture: PictureScene,
    settings: Settings,
    panels: Option<Panels>,
}

/// A rendered picture, and what is drawn into its files.
pub struct Rendered {
    /// The scene of the frame.
    pub scene: Scene,
    /// The settings of the frame.
    pub settings: Settings,
    /// The frame.
    pub frame: Frame,
    /// The insets; `None` without any.
    pub panels: Option<Panels>,
    /// The names of the spheres in Cryptomatte layers.
    pub mattes: Vec<MatteNames>,
    /// Whether files of its colour have an alpha.
    pub transparent: bool,
}

/// A figure without pixels, and what is drawn over it.
pub struct ChosenFigure {
    /// The figure.
    pub figure: Figure,
    /// The insets; `None` without any.
    pub panels: Option<Panels>,
    /// Warnings, in whole sentences.
    pub warnings: Vec<String>,
}

impl ChosenFigure {
    /// The bytes of its file in a format.
    #[must_use]
    pub fn bytes(&self, format: VectorFormat) -> Vec<u8> {
        figure::bytes(&self.figure, format, self.panels.as_ref())
    }
}

/// The parser, and the options that it has read.
#[derive(Default)]
struct Known {
    parser: Option<Parser>,
    choices: HashMap<Vec<WrittenOption>, Arc<Choices>>,
}

/// The most options that are kept: a film may have a label of its own for each frame.
const KEPT: usize = 256;

impl Choices {
    /// The choices of these options. Options of an earlier call are not parsed again.
    ///
    /// # Errors
    /// [`Error::Settings`](halfline::error::Error::Settings) that names the option, its value and what it takes.
    pub fn of(options: &[WrittenOption]) -> Result<Arc<Self>> {
        static KNOWN: Mutex<Option<Known>> = Mutex::new(None);
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let Known { parser, choices } = known.get_or_insert_default();
        if let Some(found) = choices.get(options) {
            return Ok(Arc::clone(found));
        }
        let given = Given::of_options("scene".into(), options);
        let args = parser.get_or_insert_with(Parser::without_preferences).args(&given.words(given.options()))?;
        if choices.len() >= KEPT {
            choices.clear();
        }
        let found = Arc::new(Self { args });
        choices.insert(options.to_vec(), Arc::clone(&found));
        Ok(found)
    }

    /// The options for reading with these columns; `map` replaces the colour map.
    ///
    /// # Errors
    /// [`Error::Settings`](halfline::error::Error::Settings) for options that exclude each other.
    pub fn reading(&self, keep: Keep, map: Option<ColorMap>, watch: Watch) -> Result<ReadOptions> {
        let mut options = scene_frames::options(&self.args, &Cancel::default())?;
        (options.particles.keep, options.particles.watch) = (keep, watch);
        if let (Some(map), Coloring::Column(scale)) = (map, &mut options.style.coloring) {
            scale.map = Some(map);
        }
        Ok(options)
    }

    /// The arrangement of the spheres that are read.
    #[must_use]
    pub fn arrangement(&self) -> Arrangement {
        self.args.read.arrangement()
    }

    /// The columns that give the colours.
    #[must_use]
    pub fn colored_by(&self) -> Option<&str> {
        self.args.color.color_by.as_deref()
    }

    /// Columns and rows, if both are given.
    #[must_use]
    pub fn size(&self) -> Option<(u32, u32)> {
        self.args.size()
    }

    /// The planes that cut spheres.
    #[must_use]
    pub fn cuts(&self) -> CutRules {
        self.args.cut.rules()
    }

    /// The settings for these buffers that do not depend on a scene.
    #[must_use]
    pub fn settings(&self, aovs: Vec<Aov>) -> Settings {
        self.args.settings_of(aovs)
    }

    /// The options of the formats of files, with an alpha where a picture is `transparent`.
    #[must_use]
    pub fn format_options(&self, transparent: bool) -> FormatOptions {
        FormatOptions { transparent, ..self.args.files.style() }
    }

    /// Whether the borders in which nothing is shown are cut off.
    #[must_use]
    pub fn trims(&self) -> bool {
        self.args.files.trim
    }

    /// Checks that a file holds what the options ask for.
    ///
    /// # Errors
    /// [`Error::Settings`](halfline::error::Error::Settings) for pixels per inch of a file that has none.
    pub fn check_file(&self, target: &Target) -> Result<()> {
        self.args.files.check_formats(std::slice::from_ref(target))
    }

    /// The planes that cut the spheres of a part, which are still to come.
    ///
    /// # Errors
    /// As [`halfline::scene::CutPlane::check`].
    pub fn planes_of_part(&self) -> Result<Option<Cuts>> {
        Cuts::later(self.args.cut.rules().planes)
    }

    /// The settings of a part of this scene.
    ///
    /// # Errors
    /// Errors of the window.
    pub fn settings_of_part(&self, scene: &Scene) -> Result<Settings> {
        let (settings, window) = (self.args.settings_of(Vec::new()), self.args.window(scene)?);
        Ok(Settings { window, samples: self.args.image.samples().unwrap_or(settings.samples), ..settings })
    }

    /// The figure without pixels of a scene; the options name its file.
    ///
    /// # Errors
    /// Errors of [`Self::picture`], and of what a figure cannot show.
    pub fn figure(&self, scene: ChosenScene<'_>) -> Result<ChosenFigure> {
        figure::check(&self.args)?;
        let picture = self.picture(scene, &[], Backend::Cpu)?;
        let drawn = figure::of(&self.args, &picture.picture, &picture.settings)?;
        // Marks are at pixels that show what they name.
        let Rendered { frame, panels, .. } = picture.render(&mut Renderer::new(&picture.settings)?)?;
        let mut warnings = frame.report.warnings;
        warnings.extend(figure::warning(drawn.counts()));
        Ok(ChosenFigure { figure: drawn, panels, warnings })
    }

    /// The picture of a scene with these buffers, on a renderer for this backend.
    ///
    /// # Errors
    /// Errors of the camera, of the lens, of the light and of what is drawn into the picture.
    pub fn picture<'a>(&'a self, scene: ChosenScene<'_>, aovs: &[Aov], backend: Backend) -> Result<ChosenPicture<'a>> {
        let ChosenScene { mut frame, edges, is_outlined, file, colored_by, part } = scene;
        let (args, has_picture) = (&self.args, aovs.contains(&Aov::Color) || self.args.is_figure());
        args.insets.check_place(
            args.image.is_part(),
            has_picture,
            "the picture, and the frame has none",
            "add 'color' to aovs",
        )?;
        legend::check(args)?;
        legend::file(args, frame.number)?;
        if let Some(bead) = args.read.arrangement().outline.filter(|_| !is_outlined) {
            frame.outline(edges.as_ref(), bead)?;
        }
        args.files.apply(&mut frame.scene);
        if let Some(width) = args.open_width() {
            let shares = |frame: &_| args.insets.legend_shares(frame);
            let height = framing::filled_height(&args.camera, &mut frame, width, &shares)?;
            frame.scene.resize([width, height]);
        }
        if !frame.has_camera {
            let legend_shares = args.insets.legend_shares(&frame)?;
            frame.scene.frame_by_default(frame.is_molecule, &Framing { legend_shares, ..Framing::default() })?;
        }
        let mut picture = scene_frames::with_light(args, frame, (has_picture, aovs), None, |_| ())?;
        legend::check_content(args, colored_by, &mut picture)?;
        let mut buffers = aovs.to_vec();
        if args.files.transparent && has_picture && !buffers.contains(&Aov::Alpha) {
            buffers.push(Aov::Alpha);
        }
        let settings = Settings { backend, ..args.settings_of(buffers) };
        if let Some(part) = part {
            args.check_size(part.view())?;
            picture.part_view = Some(PartView::clone(part.view()));
        }
        let settings = args.settings_for(&picture, &settings, &[])?;
        picture.scene.check()?;
        let panels = args.insets.panels(file, &picture)?;
        if let Some(part) = part {
            let Visible { scene, ids } = part.clone().visible(&picture.scene, &settings)?;
            picture.skipped.assumed.extend(part.gaps());
            (picture.scene, picture.ids) = (scene, Some(ids));
        }
        Ok(ChosenPicture { choices: self, picture, settings, panels })
    }
}

impl ChosenPicture<'_> {
    /// Renders the picture.
    ///
    /// # Errors
    /// Errors of the renderer.
    pub fn render(&self, renderer: &mut Renderer) -> Result<Rendered> {
        let Self { choices: Choices { args }, picture, settings, .. } = self;
        let (mut panels, settings) = (self.panels.clone(), settings.clone());
        let mut frame = renderer.render(&picture.scene, &settings)?;
        complete(args, picture, &mut frame, panels.as_mut(), (renderer, &settings))?;
        frame.report.warnings.extend(mattes::warnings(&picture.mattes, &frame));
        let (scene, mattes) = (picture.scene.clone(), picture.mattes.clone());
        Ok(Rendered { scene, settings, frame, panels, mattes, transparent: args.files.transparent })
    }

    /// The number of pictures of these spheres that are rendered together, on a device or the CPU path.
    #[must_use]
    pub fn together(&self, is_gpu: bool) -> usize {
        let Scene { image, spheres, .. } = &self.picture.scene;
        let pixels = image.width as usize * image.height as usize;
        together(is_gpu, pixels, spheres.len(), SpheresOf::All).max(1)
    }

    /// Writes the file of the legend, if one is requested.
    ///
    /// # Errors
    /// Errors of writing.
    pub fn write_legend(&self) -> Result<()> {
        write_legend(&self.choices.args, &self.picture)
    }

    /// The requirements of the picture.
    ///
    /// # Errors
    /// Errors of the renderer.
    pub fn explain(&self, renderer: &mut Renderer) -> Result<Explanation> {
        let mut plan = renderer.explain(&self.picture.scene, &self.settings)?;
        self.picture.skipped.report(&mut plan.skipped, &mut plan.warnings, renderer.passed_over().len());
        Ok(plan)
    }
}

/// A message in words of Python: a keyword for each setting, and for each option that it names as the command line has it.
pub fn in_keywords(message: &str) -> String {
    let message = flags(message);
    let mut words = String::with_capacity(message.len());
    let mut rest = &message[..];
    while let Some((before, after)) = rest.split_once("--") {
        let end = after.find(|c: char| !(c.is_ascii_lowercase() || c == '-')).unwrap_or(after.len());
        let name = after[..end].trim_end_matches('-');
        let is_alone = !before.ends_with(|c: char| c.is_alphanumeric() || "-_./".contains(c));
        let id = name.replace('-', "_");
        words += before;
        match is_alone && all_options().any(|row| row.id == id) {
            true => words += word_of(&id).unwrap_or(&id),
            false => {
                words += "--";
                words += name;
            }
        }
        rest = &after[name.len()..];
    }
    words + rest
}
