//! `halfline trace SCENE`: given rays instead of a camera's.

mod report;
mod source;

use super::adapters::note_fallback;
use super::bar::Bar;
use super::camera_args::PoseArgs;
use super::clash::{check_inputs, check_one_standard, place, written_twice};
use super::cut_args::PlaneArgs;
use super::lines::ProgressArgs;
use super::messages::{QuietArgs, note, warn};
use super::process::ExitCode;
use super::read_args::ReadArgs;
use super::scene_args::ComputeArgs;
use super::scene_frames::arrange;
use super::signals::{go_on, watch};
use super::standard::print_json;
use super::threads;
use clap::Args;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::progress::{Cancel, Progress, Step};
use halfline::render::Renderer;
use halfline::render::trace::echoes::Echoes;
use halfline::render::trace::{Hits, Occlusion, Tracer};
use halfline::scene::Spheres;
use halfline::scene::lidar::Lidar;
use halfline::settings::{Search, Settings};
use halfline_files::read::rays::RayBlock;
use halfline_files::read::{Keep, SceneFrame, Sequence};
use halfline_files::write::file::{check_writable, is_standard};
use halfline_files::write::hits::{HitFile, HitWriter};
use report::{Cloud, Tally, TraceReport};
use source::{RaySource, SourceArgs, rays_of_a_block};
use std::path::{Path, PathBuf};
use web_time::Instant;

/// Traces given rays, or the beams of a spinning scanner, and writes the nearest hit of each.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, next_line_help = true)]
pub(crate) struct Trace {
    /// The scene or particle file, as for halfline render; - for standard input. Of its camera only the pose is used,
    /// for --pattern.
    scene: PathBuf,
    #[command(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    pose: PoseArgs,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    cut: PlaneArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    /// The hits: .npz with the arrays id, t, distance, normal, position and certainty, or .csv, a row per ray; - is CSV on
    /// standard output. Or as a point cloud without the misses, with distance, sphere, ray and colour: .ply (f64), .pcd
    /// (f32), .las. A row or a point is an echo where the pattern has a divergence or noise.
    #[arg(short, long, help_heading = "Output", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Only whether each ray hits anything: the columns hit and certainty.
    #[arg(long, help_heading = "Output")]
    any: bool,
    /// Prints one JSON object about the rays on standard output.
    #[arg(long, help_heading = "Reporting")]
    json: bool,
    #[command(flatten)]
    progress: ProgressArgs,
    #[command(flatten)]
    quiet: QuietArgs,
}

/// The options for accuracy and speed.
#[derive(Debug, Args)]
#[command(next_help_heading = "Accuracy and speed")]
struct AccuracyArgs {
    #[command(flatten)]
    compute: ComputeArgs,
    /// Candidate search: auto, all, tree. The answers do not depend on it.
    #[arg(long, value_name = "S", default_value = "auto")]
    search: Search,
}

const EXAMPLES: &str = "\
A ray is a row ox,oy,oz,dx,dy,dz[,tmax]: origin, direction of any length, and a limit of t, in units of the direction.

Examples:
  halfline trace capsid.toml --rays rays.npy -o hits.npz
  halfline trace molecule.pdb --rays rays.csv --any -o occluded.csv --skip-invalid
  generate-rays | halfline trace cloud.ply --radius 0.05 --rays - -o - > hits.csv
  halfline trace street.npy -o scan.ply --pattern lidar:rings=64,vfov=-25..15,step=0.2,range=120 \\
      --eye 0,0,1.8 --view 1,0,0 --up 0,0,1 --rays-out beams.npy";

impl Trace {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        let file = self.check()?;
        let settings = self.settings();
        // Opening a device takes time, so it runs beside the reading of the scene.
        let (opened, renderer) = threads::both(|| self.scene(), || Renderer::new(&settings));
        let (frame, inputs) = opened?;
        check_inputs(self.outputs(), &inputs)?;
        let mut renderer = renderer?.watched_by(watch());
        note_fallback(&renderer);
        self.outputs().into_iter().try_for_each(check_writable)?;
        let cancel = Cancel::default();
        let mut source = self.source.open(&self.pose, &frame, watch().cancelled_by(&cancel))?;
        if let Some(lidar) = source.lidar() {
            note(format_args!("{} rings x {} azimuths", lidar.rings(), lidar.azimuths()));
        }
        self.source.write_beams(&source)?;

        let mut warnings = frame.skipped.warnings();
        warnings.extend_from_slice(renderer.passed_over());
        let mut spheres = frame.scene.spheres;
        if !file.as_ref().is_some_and(HitFile::has_colors) {
            // Colours take memory and are not used.
            spheres.colors = None;
        }
        warn(&warnings);
        let mut tracer = renderer.tracer(&spheres, &settings)?;
        warn(tracer.warning());
        warnings.extend(tracer.warning().map(str::to_owned));
        note(format_args!("tracing on {} ({})", tracer.adapter(), tracer.driver()));
        let report = self.trace(file.as_ref(), &mut source, &cancel, &spheres, &mut tracer)?;
        warnings.extend_from_slice(&report.warnings);
        if self.json {
            print_json(&TraceReport { skipped: frame.skipped.total(), warnings, ..report })?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Traces all rays, writes the hits into the file, if there is one, and reports on the rays.
    fn trace(
        &self,
        file: Option<&HitFile>,
        source: &mut RaySource,
        cancel: &Cancel,
        spheres: &Spheres,
        tracer: &mut Tracer<'_>,
    ) -> Result<TraceReport> {
        let start = Instant::now();
        let bar = Bar::with_output(self.progress.progress, 1);
        let echoes = source.lidar().filter(|lidar| lidar.echoes().is_some()).copied();
        let (total, tally) = (source.count().unwrap_or(0), Tally::default());
        let mut work = Work { bar: &bar, total, any: self.any, echoes, spheres, tally };
        let is_known = tracer.warning().is_some();
        let scan = source.lidar().map(|lidar| [lidar.rings(), lidar.azimuths()]);
        let cloud = match file {
            Some(file) => file
                .write(&watch(), scan, spheres, |out| work.run(source, cancel, tracer, Some(out)))?
                .map(|summary| Cloud::new(file.path(), summary, echoes.is_some())),
            None => work.run(source, cancel, tracer, None).map(|()| None)?,
        };
        if let Some(cloud) = &cloud {
            bar.suspended(|| note(format_args!("{}", cloud.words())));
        }
        let mut warnings = work.tally.warnings(spheres);
        warnings.extend(cloud.as_ref().and_then(Cloud::warning));
        // Of an adapter that failed meanwhile.
        warnings.extend(tracer.warning().filter(|_| !is_known).map(str::to_owned));
        bar.suspended(|| warn(&warnings));
        let report = TraceReport {
            pattern: source.lidar().map(Into::into),
            cloud,
            elapsed_ms: start.elapsed().as_secs_f64() * 1e3,
            warnings,
            ..TraceReport::new(spheres, tracer, work.tally, self.any)
        };
        bar.finish();
        Ok(report)
    }

    /// Checks combinations of options; the file of the hits.
    fn check(&self) -> Result<Option<HitFile>> {
        let query = self.source.query(self.any)?;
        let file = self.output.as_deref().map(|path| HitFile::new(path, query)).transpose()?;
        if file.is_none() && !self.json {
            return Err(Error::settings("no output is requested", "use -o for the hits, or --json for a report"));
        }
        let prints_hits = file.as_ref().is_some_and(HitFile::is_standard);
        check_one_standard("the hits", [prints_hits, self.json, self.progress.is_openjd()])?;
        if self.read.frames.as_ref().is_some_and(|frames| frames.count() > 1) {
            return Err(Error::settings("rays are traced in one frame", "use --frames with a single number"));
        }
        self.source.check(&self.pose)?;
        let inputs: Vec<_> = [&self.scene]
            .into_iter()
            .chain(&self.read.topology)
            .chain(&self.read.add)
            .chain(self.source.rays())
            .cloned()
            .collect();
        if inputs.iter().filter(|input| is_standard(input)).count() > 1 {
            let problem = "two inputs cannot both come from standard input";
            return Err(Error::settings(problem, "use a file for one of them"));
        }
        let outputs = self.outputs();
        if let [hits, beams] = outputs[..]
            && place(hits) == place(beams)
        {
            return written_twice(hits, "use another file for the beams");
        }
        check_inputs(outputs, &inputs)?;
        Ok(file)
    }

    /// The files that are written.
    fn outputs(&self) -> Vec<&Path> {
        self.output.iter().chain(self.source.beams()).map(PathBuf::as_path).collect()
    }

    fn settings(&self) -> Settings {
        Settings {
            search: self.accuracy.search,
            aovs: if self.any { Vec::new() } else { vec![Aov::Normal] },
            ..self.accuracy.compute.settings()
        }
    }

    /// The scene, and every file that is read for it.
    fn scene(&self) -> Result<(SceneFrame, Vec<PathBuf>)> {
        let mut options = self.read.options();
        if self.cut.selects() {
            options.particles.keep = Keep::All;
        }
        let mut sequence = Sequence::open(&self.scene, &options)?;
        let frame = sequence.next_scene()?;
        let mut frame = frame.ok_or_else(|| sequence.nothing())?;
        arrange(&self.read, &mut frame)?;
        frame.cut_for_rays(&self.cut.rules())?;
        Ok((frame, sequence.files().to_vec()))
    }
}

/// The answers to a block of rays.
enum Answers {
    Any(Occlusion),
    /// The hits, and the echoes where they are measured.
    Nearest(Hits, Option<Echoes>),
}

/// The work on all blocks.
struct Work<'a> {
    bar: &'a Bar,
    /// The number of rays, or 0 if it is not known.
    total: u64,
    any: bool,
    /// The scanner whose echoes are measured.
    echoes: Option<Lidar>,
    spheres: &'a Spheres,
    tally: Tally,
}

impl Work<'_> {
    /// Traces all rays block by block, while the next block is read and the one before is written.
    fn run(
        &mut self,
        source: &mut RaySource,
        cancel: &Cancel,
        tracer: &mut Tracer<'_>,
        mut out: Option<&mut HitWriter<'_>>,
    ) -> Result<()> {
        self.progress(self.total);
        let Self { any, echoes, spheres, .. } = *self;
        threads::three_stages(
            || source.next_block(rays_of_a_block()),
            (tracer, 0),
            cancel,
            |(tracer, before), block| {
                if !go_on() {
                    return Err(Error::Interrupted);
                }
                let (start, rays) = (Instant::now(), block.rays());
                let mut answers = match any {
                    true => Answers::Any(tracer.occluded(&rays)?),
                    false => Answers::Nearest(tracer.hits(&rays)?, None),
                };
                let trace_ms = start.elapsed().as_secs_f64() * 1e3;
                if let (Answers::Nearest(hits, found), Some(lidar)) = (&mut answers, echoes) {
                    *found = Echoes::new(&lidar, *before / u64::from(lidar.rays_per_beam()), &rays, hits, spheres);
                }
                *before += block.rows() as u64;
                Ok((block, answers, trace_ms))
            },
            |(block, answers, trace_ms)| {
                self.add(&block, &answers, trace_ms, out.as_deref_mut())?;
                self.tally.fault = self.tally.fault.take().or(block.fault);
                self.progress(self.total);
                Ok(())
            },
        )?;
        self.progress(self.tally.rays);
        Ok(())
    }

    /// Counts the answers to a block, and writes them into the file, if there is one.
    fn add(
        &mut self,
        block: &RayBlock,
        answers: &Answers,
        trace_ms: f64,
        out: Option<&mut HitWriter<'_>>,
    ) -> Result<()> {
        match answers {
            Answers::Any(occlusion) => {
                self.tally.occlusion(block, occlusion, trace_ms);
                out.map_or(Ok(()), |out| out.occlusion(occlusion, &block.invalid))
            }
            Answers::Nearest(hits, echoes) => {
                self.tally.hits(block, hits, trace_ms);
                match echoes {
                    Some(echoes) => {
                        self.tally.echoes(echoes);
                        out.map_or(Ok(()), |out| out.echoes(echoes))
                    }
                    None => out.map_or(Ok(()), |out| out.hits(&block.rays(), hits, &block.invalid)),
                }
            }
        }
    }

    fn progress(&self, total: u64) {
        self.bar.report(Progress { step: Step::Rays, done: self.tally.rays, total });
    }
}
