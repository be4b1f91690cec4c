//! Lights, sky and lines of the picture as options, and the looks that stand for several of them.

use super::lens_args::PictureLens;
use super::typed::Typed;
use super::values::{color, length, numbers, share, whole};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec3;
use halfline::error::Result;
use halfline::frame::Aov;
use halfline::quote::setting::DEPTH_CUE_STRENGTH;
use halfline::scene::{MOST_BOUNCES, MOST_RAYS, Sky};
use halfline::settings::{AddedLight, ChosenLook, FileLook, Look, MOST_LAYERS, Outline, Settings};
use halfline::shade::Shade;
use halfline_files::read::SceneFrame;

/// The options for light.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
pub(super) struct LightArgs {
    #[command(flatten)]
    typed: Typed,
    /// Look of the picture, to which other options add: plain (nothing), soft (--samples 4, --silhouette, a sky with 3 rays
    /// from each pixel's centre, and a light from above left if the scene has none), figure (--samples 16, --silhouette,
    /// and a sky with 8 rays) [default: the scene file's, else plain; for particles soft, unless --shade or --stream is given].
    #[arg(long, value_name = "L", value_parser = looks(), hide_possible_values = true)]
    look: Option<Look>,
    /// Ambient occlusion: a white sky, parts of it hidden by other spheres; N rays for each point [default: the scene
    /// file's, else 16].
    #[arg(long, value_name = "N", value_parser = whole(1..=MOST_RAYS), num_args = 0..=1)]
    occlusion: Option<Option<u32>>,
    /// Spheres farther than this from a point, in scene units, hide nothing of the sky [default: the scene file's, else
    /// no limit].
    #[arg(long, value_name = "R", value_parser = length, allow_negative_numbers = true)]
    reach: Option<f64>,
    /// Adds a white light infinitely far in this direction; may be repeated.
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    sun: Vec<DVec3>,
    /// Lights cast shadows, as lights of scene files always do; without any light, adds one from above left of the
    /// camera.
    #[arg(long)]
    shadows: bool,
    /// The most bounces of a ray at mirrors and in glass, up to 64; 0 switches them off [default: 6].
    #[arg(long, value_name = "N", value_parser = whole(0..=MOST_BOUNCES))]
    bounces: Option<u32>,
    /// Draws dark lines where the depth jumps.
    #[arg(long)]
    silhouette: bool,
    /// Width of these lines, from 0.1 to 40 pixels; below 1.3 they become paler instead of narrower [default: 1.3].
    #[arg(long, value_name = "PIXELS", value_parser = outline_width, allow_negative_numbers = true)]
    outline_width: Option<f64>,
    /// Colour of these lines, as of --background [default: black].
    #[arg(long, value_name = "COLOR", value_parser = color)]
    outline_color: Option<[f32; 3]>,
    /// Fades colours to the background with depth.
    #[arg(long)]
    depth_cue: bool,
    /// Share of the background in the colour of the farthest sphere, above 0 and at most 1 [default: 0.6].
    #[arg(long, value_name = "S", value_parser = share, allow_negative_numbers = true)]
    depth_cue_strength: Option<f64>,
    /// Shows so many translucent spheres before the first opaque one, the nearest, up to 64; see --opacity [default: 1].
    #[arg(long, value_name = "N", value_parser = whole(1..=MOST_LAYERS))]
    layers: Option<u32>,
    /// Lets translucent spheres block lights and sky as opaque ones do.
    #[arg(long)]
    opacity_shadows: bool,
    /// Lets translucent spheres grow opaque toward their rim, so that their shapes are seen.
    #[arg(long)]
    ghost_rim: bool,
}

/// The inputs that choose a look together with `--look`.
#[derive(Debug, Clone, Copy)]
pub(super) struct LookRequest {
    /// The kind of the file, and the look and the samples that it asks for.
    pub(super) file: FileLook,
    /// Whether the colour of the picture is computed.
    pub(super) has_picture: bool,
    /// Whether the picture is a figure without pixels, which has the lines of a look and not its light.
    pub(super) is_figure: bool,
    /// The samples and the shading that options ask for.
    pub(super) samples: Option<u32>,
    pub(super) shade: Option<Shade>,
}

/// The look of one picture: what its options stand for, and its lens.
#[derive(Debug, Clone, Copy)]
pub(super) struct PictureLook {
    chosen: ChosenLook,
    lens: PictureLens,
    has_picture: bool,
    is_figure: bool,
    shade: Option<Shade>,
    silhouette: bool,
    depth_cue: bool,
    /// Whether lights cast shadows.
    shadows: bool,
    /// The sky of the buffer `occlusion` in a scene without one.
    buffer_sky: Sky,
    /// Whether `--occlusion` replaces the sky rays of the look.
    has_own_sky: bool,
}

impl LightArgs {
    /// Whether the picture would have the look of particles.
    pub(super) fn would_be_soft(&self, LookRequest { file, has_picture, samples, shade, .. }: LookRequest) -> bool {
        file.choose(has_picture, self.look, samples, shade).is_default
    }

    /// The settings with width and colour of outlines, and with the layers of translucent spheres.
    pub(super) fn drawn(&self, settings: Settings) -> Settings {
        Settings {
            outline: Outline::of(self.outline_width, self.outline_color),
            layers: self.layers.unwrap_or_default(),
            opacity_shadows: self.opacity_shadows,
            ghost_rim: self.ghost_rim,
            depth_cue_strength: self.depth_cue_strength,
            ..settings
        }
    }

    /// The width of outlines that words give, else `other`.
    pub(super) fn width_or(&self, other: f64) -> f64 {
        self.outline_width.filter(|_| self.typed.has("outline_width")).unwrap_or(other)
    }

    /// Applies the options to the scene, whose camera is final.
    ///
    /// # Errors
    /// Errors of [`AddedLight::apply`].
    pub(super) fn apply(
        &self,
        SceneFrame { scene, skipped, .. }: &mut SceneFrame,
        aovs: &[Aov],
        request: LookRequest,
        lens: PictureLens,
    ) -> Result<PictureLook> {
        let LookRequest { file, has_picture, is_figure, samples, shade } = request;
        let samples = samples.or(lens.samples);
        let chosen = file.choose(has_picture, self.look, samples, shade);
        let look = chosen.look;
        let silhouette = self.silhouette || look.has_silhouette();
        // A preference from elsewhere may apply to no picture.
        let typed = ["outline_width", "outline_color"].map(|id| self.typed.has(id));
        skipped.assumed.extend(Outline::idle(typed, has_picture, silhouette));
        if self.typed.has("depth_cue_strength") && !self.depth_cue {
            skipped.assumed.push(format!("{DEPTH_CUE_STRENGTH} changes nothing: no depth cue is drawn"));
        }
        let light = AddedLight {
            look: if is_figure { Look::Plain } else { look },
            suns: self.sun.clone(),
            shadows: self.shadows,
            occlusion: self.occlusion,
            reach: self.reach,
            bounces: self.bounces,
        };
        skipped.assumed.extend(light.apply(scene, aovs)?);
        Ok(PictureLook {
            chosen,
            lens,
            has_picture,
            is_figure,
            shade,
            silhouette,
            depth_cue: self.depth_cue,
            shadows: scene.lighting.shadows,
            buffer_sky: light.buffer_sky(),
            has_own_sky: self.occlusion.is_some(),
        })
    }
}

impl PictureLook {
    /// The settings with this look.
    pub(super) fn settings(&self, settings: &Settings) -> Settings {
        Settings {
            shade: self.shade.unwrap_or(settings.shade),
            samples: self.chosen.samples,
            aperture: self.lens.aperture,
            silhouette: self.silhouette,
            depth_cue: self.depth_cue,
            sky: self.buffer_sky,
            ..settings.clone()
        }
    }

    /// The name of the look; `None` without a picture.
    pub(super) fn name(&self) -> Option<&'static str> {
        self.has_picture.then(|| self.chosen.look.name())
    }

    /// Sentences that name the options of the look and describe the lens.
    pub(super) fn words(&self) -> impl Iterator<Item = String> {
        self.look_words().into_iter().chain(self.lens.words())
    }

    /// The options that the look stands for, with the samples of this picture; `None` for the plain one.
    fn look_words(&self) -> Option<String> {
        let ChosenLook { look, is_default, samples } = self.chosen;
        if look == Look::Plain {
            return None;
        }
        if self.is_figure {
            let name = look.name();
            return Some(format!(
                "look {name}: a figure has its lines, and a light at the eye; its sky and light need pixels"
            ));
        }
        let sky = match self.lens.aperture {
            None => format!("a sky with {} rays from each pixel's centre", Sky::AT_CENTERS.rays_at_center(samples)),
            Some(_) => format!("a sky with {} rays from each sample", Sky::AT_CENTERS.rays),
        };
        let longer = "--occlusion at every sample, which takes much longer";
        let sky = if self.has_own_sky { format!("{longer} than {sky}") } else { sky };
        let shadows = if self.shadows { "with" } else { "without" };
        let light = match look {
            Look::Figure if !self.shadows => String::new(),
            _ => format!(", and a light from above left {shadows} shadows if the scene has no light"),
        };
        let stands_for = format!("--silhouette --samples {samples}, {sky}{light}");
        let default = if is_default { " (the default for particles; see --look plain)" } else { "" };
        Some(format!("look {}{default}: {stands_for}", look.name()))
    }
}

fn looks() -> impl TypedValueParser<Value = Look> {
    let value = |look: &Look| {
        let help = match look {
            Look::Plain => "Nothing",
            Look::Soft => "For particles: depth is visible without any setting",
            Look::Figure => "For print: smooth shade and lines",
        };
        PossibleValue::new(look.name()).help(help)
    };
    PossibleValuesParser::new(Look::ALL.iter().map(value)).try_map(|name| name.parse())
}

fn outline_width(text: &str) -> Result<f64, String> {
    let [least, most] = Outline::WIDTHS;
    let width = text.parse().ok().filter(|width| (least..=most).contains(width));
    width.ok_or_else(|| format!("expected a number of pixels from {least} to {most}"))
}

fn direction(text: &str) -> Result<DVec3, String> {
    let vector = numbers(text).map(DVec3::from_array).filter(|sun| *sun != DVec3::ZERO);
    vector.ok_or_else(|| "expected three finite numbers, not all 0, that point toward the light, such as -1,2,1".into())
}
