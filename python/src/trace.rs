//! Given rays, traced in blocks whose hits go straight into the arrays of the answer.

use crate::arrays::{list, owned};
use crate::errors::OrRaise;
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::words::settings;
use crate::work::Job;
use halfline::error::{Error, Result};
use halfline::parallel;
use halfline::settings::Settings;
use halfline::{Aov, Progress, Rays, Step, Tracer};
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The rays of a block. The answers do not depend on it.
const BLOCK: usize = 1 << 19;

/// The answers so far.
#[derive(Default)]
struct Answers {
    id: Vec<i32>,
    t: Vec<f64>,
    distance: Vec<f64>,
    normal: Vec<[f32; 3]>,
    certainty: Vec<u8>,
    hit: Vec<u8>,
}

/// Allocates all of it, so that memory is known to suffice before the work begins.
fn room<T>(values: &mut Vec<T>, count: usize) -> Result<()> {
    values.try_reserve_exact(count).map_err(|_| Error::Limits {
        problem: format!("{} bytes for the hits cannot be allocated", count.saturating_mul(size_of::<T>())),
        mend: "trace fewer rays".into(),
    })
}

impl Answers {
    fn with_room(count: usize, any: bool) -> Result<Self> {
        let mut answers = Self::default();
        room(&mut answers.certainty, count)?;
        if any {
            room(&mut answers.hit, count)?;
            return Ok(answers);
        }
        room(&mut answers.id, count)?;
        room(&mut answers.t, count)?;
        room(&mut answers.distance, count)?;
        room(&mut answers.normal, count)?;
        Ok(answers)
    }

    fn add(&mut self, tracer: &mut Tracer<'_>, rays: &Rays<'_>, any: bool) -> Result<()> {
        if any {
            let occlusion = tracer.occluded(rays)?;
            self.hit.extend(occlusion.hit);
            self.certainty.extend(occlusion.certainty);
            return Ok(());
        }
        let hits = tracer.hits(rays)?;
        self.id.extend(hits.id);
        self.t.extend(hits.t);
        self.distance.extend(hits.distance);
        self.normal.extend(hits.normal.unwrap_or_default());
        self.certainty.extend(hits.certainty);
        Ok(())
    }
}

/// Checks all rays; an error names the argument and the row.
fn check(rays: &Rays<'_>) -> Result<()> {
    let three = |[x, y, z]: [f64; 3]| format!("[{x}, {y}, {z}]");
    if let Some(row) = parallel::position(rays.origins, |origin| origin.iter().any(|x| !x.is_finite())) {
        let problem = format!("origins[{row}] is {}: coordinates are finite", three(rays.origins[row]));
        return Err(Error::settings(problem, "remove the ray or give it three finite numbers"));
    }
    let bad = |d: &[f64; 3]| d.iter().any(|x| !x.is_finite()) || d.iter().all(|x| *x == 0.0);
    if let Some(row) = parallel::position(rays.directions, bad) {
        let found = three(rays.directions[row]);
        let problem = format!("directions[{row}] is {found}: directions are finite and not zero");
        return Err(Error::settings(problem, "remove the ray or give it a direction"));
    }
    if let Some(row) = parallel::position(rays.limits, |limit| limit.is_nan()) {
        let problem = format!("tmax[{row}] is NaN");
        return Err(Error::settings(problem, "use a number, or inf for no limit"));
    }
    Ok(())
}

/// Traces rays, and returns the arrays of the hits, or with `any` whether there is one.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the package names them")]
pub(crate) fn trace<'py>(
    py: Python<'py>,
    renderer: &Renderer,
    scene: &Scene,
    origins: PyReadonlyArrayDyn<'py, f64>,
    directions: PyReadonlyArrayDyn<'py, f64>,
    limits: Option<PyReadonlyArrayDyn<'py, f64>>,
    any: bool,
    options: &Bound<'_, PyDict>,
    search: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let aovs = if any { Vec::new() } else { vec![Aov::Normal] };
    let search = search.parse().or_raise()?;
    let (settings, cuts) = settings(options)?;
    let settings = Settings { backend: renderer.backend, aovs, search, ..settings };
    let origins = list::<f64, [f64; 3], 3>(&origins)?;
    let directions = list::<f64, [f64; 3], 3>(&directions)?;
    let limits = limits.map(|limits| list::<f64, f64, 1>(&limits)).transpose()?.unwrap_or_default();
    let (count, job) = (directions.len(), Job::default());
    let answers = job.run(py, progress.as_ref(), || {
        check(&Rays { origins: &origins, directions: &directions, limits: &limits })?;
        let mut answers = Answers::with_room(count, any)?;
        renderer.shared.with(&job, |renderer| {
            let frame = scene.cut_for_rays(&cuts)?;
            let mut tracer = renderer.tracer(&frame.scene.spheres, &settings)?;
            for start in (0..count).step_by(BLOCK) {
                let part = start..count.min(start + BLOCK);
                if job.cancel.is_cancelled() {
                    return Err(Error::Interrupted);
                }
                let rays = Rays {
                    origins: if origins.len() == 1 { &origins } else { &origins[part.clone()] },
                    directions: &directions[part.clone()],
                    limits: if limits.is_empty() { &limits } else { &limits[part.clone()] },
                };
                answers.add(&mut tracer, &rays, any)?;
                job.reached(Progress { step: Step::Rays, done: part.end as u64, total: count as u64 });
            }
            Ok(())
        })?;
        Ok(answers)
    })?;
    let Answers { id, t, distance, normal, certainty, hit } = answers;
    let certainty = owned(py, certainty, &[count])?;
    if any {
        return (owned(py, hit, &[count])?, certainty).into_pyobject(py);
    }
    let normal = owned(py, normal.into_flattened(), &[count, 3])?;
    (owned(py, id, &[count])?, owned(py, t, &[count])?, owned(py, distance, &[count])?, normal, certainty)
        .into_pyobject(py)
}
