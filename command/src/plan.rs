//! `halfline plan SCENE`.

use super::messages::{QuietArgs, note, warn};
use super::picture_scene::PictureScene;
use super::process::ExitCode;
use super::scene_args::SceneArgs;
use super::scene_frames::SceneFrames;
use super::standard::{print, print_json};
use super::visible;
use clap::builder::ArgPredicate;
use clap::{Arg, Command};
use halfline::camera::Curve;
use halfline::error::{Error, Result};
use halfline::explain::{DeviceBuffer, Explanation, MaterialCounts, PixelRays, Room, ShaderFile, wgsl};
use halfline::frame::tone::Tone;
use halfline::progress::Cancel;
use halfline::quote::{count, number};
use halfline::render::Renderer;
use halfline::scene::{Sky, SkyColors};
use std::fmt::{self, Display};

/// Explains what rendering a scene would compile, upload and compute, and why, without tracing a ray.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, next_line_help = true)]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    args: SceneArgs,
    /// Prints one JSON object on standard output.
    #[arg(long, help_heading = "Reporting")]
    json: bool,
    /// Prints the whole compute shader, with the name of its file above each part.
    #[arg(long, help_heading = "Reporting", conflicts_with = "json")]
    wgsl: bool,
    #[command(flatten)]
    quiet: QuietArgs,
}

const EXAMPLES: &str = "\
The command takes the options of halfline render; without an output it plans a picture.

Examples:
  halfline plan scenes/weekend.toml
  halfline plan scenes/weekend.toml -o weekend.png --aov distance=t.npy
  halfline plan scenes/weekend.toml -o weekend.png --tolerance 1e-3 --json
  halfline plan scenes/weekend.toml --aov depth=z.npy --wgsl";

/// The command line in which a plan without an output is the plan of a picture, as people mean it.
pub(super) fn of_a_picture(command: Command) -> Command {
    let assumed =
        |output: Arg| output.default_value("out.png").default_value_if("aov", ArgPredicate::IsPresent, None::<&str>);
    command.mut_subcommand("plan", |plan| plan.mut_arg("output", assumed))
}

impl PlanArgs {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        let targets = self.args.targets(1)?;
        self.args.files.check_formats(&targets)?;
        let settings = self.args.settings(&targets);
        let first = match self.args.visible[..] {
            [] => SceneFrames::open(&self.args, &settings, &Cancel::default())?.next_frame()?,
            [..] => {
                visible::check(&self.args)?;
                Some(visible::picture(&self.args, &settings, &targets)?)
            }
        };
        let picture = first.ok_or_else(|| Error::settings("no frame of the file is selected", "use other --frames"))?;
        let settings = self.args.settings_for(&picture, &settings, &targets)?;
        let PictureScene { scene, skipped, look, framed, .. } = picture;
        if self.wgsl {
            print(&wgsl(&scene, &settings)?)?;
            return Ok(ExitCode::SUCCESS);
        }
        let mut renderer = Renderer::new(&settings)?;
        let mut explanation = renderer.explain(&scene, &settings)?;
        skipped.report(&mut explanation.skipped, &mut explanation.warnings, renderer.passed_over().len());
        look.words().for_each(|words| note(format_args!("{words}")));
        warn(&explanation.warnings);
        match self.json {
            true => print_json(&explanation)?,
            false => print(&format!("{}\n", PlanText(&explanation, framed.as_deref()).to_string().trim_end()))?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// An explanation as text, and what the camera frames.
struct PlanText<'a>(&'a Explanation, Option<&'a str>);

impl Display for PlanText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_scene(f)?;
        self.write_camera(f)?;
        self.write_window(f)?;
        self.write_light(f)?;
        self.write_engine(f)?;
        self.write_device(f)?;
        self.write_memory(f)?;
        writeln!(f, "left out")?;
        self.0.left_out.iter().try_for_each(|left| writeln!(f, "  {}: {}", left.what, left.why))
    }
}

impl PlanText<'_> {
    fn write_scene(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let e = self.0;
        writeln!(
            f,
            "scene      {}, {} x {} rays, {} skipped",
            count(e.spheres, "sphere"),
            e.size[0],
            e.size[1],
            count(e.skipped, "object")
        )
    }

    /// The window, the spheres in its lists, and the samples.
    fn write_window(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let e = self.0;
        let [x0, y0, x1, y1] = e.window;
        if [x0, y0, x1, y1] != [0, 0, e.size[0], e.size[1]] {
            writeln!(f, "crop       columns {x0} to {x1}, rows {y0} to {y1}, ends excluded: {} rays", e.rays)?;
        }
        if let Some(staged) = e.staged {
            let halfline::explain::BinnedCounts { front, near, unseen } = staged;
            writeln!(f, "           {front} in front, {near} near, {unseen} that no ray can hit and are not uploaded")?;
        }
        if e.samples > 1 {
            let samples = e.samples;
            writeln!(f, "samples    {samples} per pixel for colour and alpha: one more pass each, of ids and colour")?;
        }
        Ok(())
    }

    /// The backend, the accuracy, the method and the search, with their reasons.
    fn write_engine(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let e = self.0;
        writeln!(f, "place      {}: {}", e.backend, e.adapter)?;
        writeln!(f, "           {}", e.backend_reason)?;
        writeln!(f, "accuracy   {}, tolerance {}", e.accuracy, number(e.tolerance, 2))?;
        writeln!(f, "method     {}", e.method)?;
        writeln!(f, "why        {}", e.reason)?;
        if let Some(p) = &e.predicted {
            let [outline, distance, radii] = [p.outline, p.distance, p.radii].map(|x| number(x, 2));
            writeln!(
                f,
                "predicted  outline within {outline} radii, distance within {distance}; worst sphere {}, {radii} radii away",
                p.sphere
            )?;
        }
        writeln!(f, "precision  {}", e.precision)?;
        writeln!(f, "search     {}: {}", e.search, e.search_reason)?;
        let titles = std::iter::once("passes").chain(std::iter::repeat(""));
        e.passes
            .iter()
            .zip(titles)
            .try_for_each(|(pass, title)| writeln!(f, "{title:10} {}: {}", pass.name, pass.output))
    }

    /// The kernel and the buffers of the device.
    fn write_device(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let e = self.0;
        let lines = |parts: &[ShaderFile]| parts.iter().map(|part| part.lines).sum::<usize>();
        if !e.kernel.is_empty() {
            let what = if e.dispatches == 1 { "dispatch" } else { "dispatches" };
            writeln!(f, "kernel     {} lines of WGSL, {} {what}", lines(&e.kernel), e.dispatches)?;
            write_parts(f, &e.kernel)?;
        }
        write_bindings(f, "uploaded", &e.uploaded)?;
        write_bindings(f, "written and read back", &e.written)
    }

    /// The room in memory, and the buffers of the frame.
    fn write_memory(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let e = self.0;
        let known = |n: Option<u64>| n.map_or("an unknown number".to_owned(), |n| n.to_string());
        let Room { adapter, host, needed, free } = e.room;
        write!(f, "room       for {} spheres in this machine's memory", known(host))?;
        match adapter {
            Some(adapter) => writeln!(f, ", for {adapter} on the adapter")?,
            None => writeln!(f)?,
        }
        writeln!(f, "           {needed} bytes are needed besides the scene, {} are free", known(free))?;
        writeln!(f, "frame")?;
        for shown in &e.frame {
            let shape: Vec<_> = shown.shape.iter().map(u64::to_string).collect();
            let always = if shown.asked { "" } else { ", always present" };
            let [name, dtype, shape] = [shown.name, shown.dtype, &shape.join(" x ")];
            writeln!(f, "  {name:20} {:>14} bytes, {shape} of {dtype}{always}", shown.bytes)?;
        }
        Ok(())
    }

    fn write_camera(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let camera = &self.0.camera;
        let point = |p: [f64; 3]| p.map(|x| number(x, 6)).join(", ");
        let [eye, view, up] = [camera.eye, camera.view, camera.up].map(point);
        writeln!(f, "camera     eye {eye}; view {view}; up {up}")?;
        let [vw, vh] = camera.viewport.map(|side| number(side, 6));
        let lens = camera.curve.map(|curve| match curve {
            Curve::Distorted { .. } => "with distortion",
            Curve::Fisheye { .. } => "of a fisheye",
            Curve::Panorama => "of a panorama",
        });
        match camera.distance {
            _ if lens.is_some() => writeln!(f, "           lens {}", lens.unwrap_or_default())?,
            Some(distance) => writeln!(f, "           viewport {vw} x {vh} at distance {}", number(distance, 6))?,
            None => writeln!(f, "           orthographic, a view of {vw} x {vh}")?,
        }
        if let [Some(aperture), Some(focus)] = [camera.aperture, camera.focus].map(|x| x.map(|x| number(x, 6))) {
            writeln!(f, "           lens of diameter {aperture}, in focus {focus} away")?;
        }
        self.1.map_or(Ok(()), |framed| writeln!(f, "           frames {framed}"))
    }

    /// The lights, the sky and the lines of the picture.
    fn write_light(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let e = self.0;
        match (e.lights, e.occlusion) {
            (0, None) => writeln!(f, "light      at the eye")?,
            (lights, _) => {
                let shadows = if e.shadows { "with shadows" } else { "without shadows" };
                writeln!(f, "light      {}, {shadows}", count(lights, "light"))?;
            }
        }
        e.lit_by.iter().try_for_each(|light| writeln!(f, "           {light}"))?;
        if let Some(Sky { rays, reach, at_centers, colors, share }) = e.occlusion {
            let reach = if reach.is_finite() { format!("that end after {reach}") } else { "without end".to_owned() };
            let each = if at_centers { "from each pixel's centre" } else { "for each point" };
            let share = if share == 1.0 { String::new() } else { format!(", {share} of its light") };
            writeln!(f, "sky        {} {each}, {reach}{share}", count(rays.into(), "ray"))?;
            if let Some(SkyColors { zenith, horizon, is_shown }) = colors {
                let rgb = |color: [f32; 3]| color.map(|c| c.to_string()).join(", ");
                let hidden = if is_shown { "" } else { "; the background is seen in its place" };
                writeln!(f, "           zenith {}, horizon {}{hidden}", rgb(zenith), rgb(horizon))?;
            }
        }
        let PixelRays { viewing, lights, sky, onward } = e.rays_per_pixel;
        let MaterialCounts { mirrors, metals, clear } = e.materials;
        if !e.materials.is_none() {
            writeln!(
                f,
                "materials  spheres: {mirrors} with a mirror image, {metals} of metal, {clear} of glass or clear"
            )?;
        }
        if e.bounces > 0 {
            writeln!(f, "bounces    up to {}", e.bounces)?;
        }
        if [lights, sky, onward] != [0; 3] {
            write!(f, "rays       per pixel {viewing} to the scene, {lights} to lights, {sky} to the sky")?;
            match onward {
                0 => writeln!(f)?,
                onward => writeln!(f, ", up to {onward} onward, and lights and sky again at their hits")?,
            }
        }
        if let Some(layers) = e.layers {
            let nearest = if layers == 1 { "the nearest".to_owned() } else { format!("the {layers} nearest") };
            let what = "of the translucent spheres before the first opaque one, over the picture of the opaque ones";
            writeln!(f, "layers     {nearest} {what}")?;
        }
        let drawn = [(e.silhouette, "silhouette"), (e.depth_cue, "depth cue")];
        let drawn: Vec<_> = drawn.iter().filter(|(drawn, _)| *drawn).map(|(_, name)| *name).collect();
        if !drawn.is_empty() {
            writeln!(f, "drawn      {}", drawn.join(", "))?;
        }
        if let Some(tone) = e.tone {
            let beyond = match tone {
                Tone::Linear => "light beyond 1 is cut off",
                Tone::Soft => "colours beyond 1 become whiter",
            };
            let exposure = if e.exposure == 0.0 { String::new() } else { format!(", exposure {} stops", e.exposure) };
            writeln!(f, "tone       {}: {beyond}{exposure}", tone.name())?;
        }
        Ok(())
    }
}

fn write_parts(f: &mut fmt::Formatter<'_>, parts: &[ShaderFile]) -> fmt::Result {
    parts.iter().try_for_each(|part| writeln!(f, "  shaders/{:32} {:>4} lines", part.file, part.lines))
}

fn write_bindings(f: &mut fmt::Formatter<'_>, title: &str, bindings: &[DeviceBuffer]) -> fmt::Result {
    if bindings.is_empty() {
        return Ok(());
    }
    writeln!(f, "{title}, {} bytes", bindings.iter().map(|b| b.bytes).sum::<u64>())?;
    bindings.iter().try_for_each(|b| writeln!(f, "  {:20} {:>14} bytes", b.name, b.bytes))
}
