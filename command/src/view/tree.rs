//! A tree of the spheres, which traces the few rays of a small picture faster than all spheres are staged again.

use super::rays::ViewingRays;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::render::Renderer;
use halfline::scene::Spheres;
use halfline::settings::{Accuracy, Backend, Settings};
use halfline::trace::{Hits, Rays};
use rayon::prelude::*;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Builder;

/// Rays, and where their hits go.
struct Job {
    origins: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    hits: Sender<Result<Hits>>,
}

/// A tree in a thread of its own, which builds it first.
pub(super) struct Tree {
    jobs: Sender<Job>,
    /// Gets a word when the tree is there.
    built: Receiver<()>,
    is_built: bool,
}

impl Tree {
    /// Starts to build the tree; `None` where the system allows no thread.
    pub(super) fn of(spheres: Spheres) -> Option<Self> {
        let ((jobs, asked), (done, built)) = (channel::<Job>(), channel());
        let work = move || -> Result<()> {
            let settings = Settings {
                backend: Backend::Cpu,
                accuracy: Accuracy::Certified,
                aovs: vec![Aov::Normal],
                ..Settings::default()
            };
            let mut renderer = Renderer::new(&settings)?;
            let mut tracer = renderer.tracer(&spheres, &settings)?;
            let _ = done.send(());
            for Job { origins, directions, hits } in asked {
                // The receiver is gone where the page has ended.
                let _ = hits.send(tracer.hits(&Rays { origins: &origins, directions: &directions, limits: &[] }));
            }
            Ok(())
        };
        Builder::new().name("tree".into()).spawn(work).ok()?;
        Some(Self { jobs, built, is_built: false })
    }

    /// Whether the tree is there.
    pub(super) fn is_built(&mut self) -> bool {
        self.is_built |= self.built.try_recv().is_ok();
        self.is_built
    }

    /// The hits of all rays.
    ///
    /// # Errors
    /// Those of tracing.
    pub(super) fn hits(&self, rays: &ViewingRays) -> Result<Hits> {
        let all = (0..rays.len()).into_par_iter().map(|n| rays.nth(n).map(|vector| vector.to_array()));
        let (origins, directions) = all.map(|[origin, direction]| (origin, direction)).unzip();
        let (hits, found) = channel();
        let gone = |_| Error::settings("the tree of the spheres is gone", "start the command again");
        self.jobs.send(Job { origins, directions, hits }).map_err(|_| gone(()))?;
        found.recv().map_err(|_| gone(()))?
    }
}
