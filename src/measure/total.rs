//! Sums over the scenes of a record: one line a method and place.

use super::record::{Record, Run};

/// What one method did in one place, over every scene it ran.
#[derive(Debug, Clone, PartialEq)]
pub struct Total<'a> {
    /// Index into the record's places.
    pub place: usize,
    /// Its name.
    pub method: &'a str,
    /// Scenes it ran.
    pub scenes: usize,
    /// Scenes that anything ran in this place.
    pub of_scenes: usize,
    /// Pixels judged.
    pub pixels: u64,
    /// Pixels that show what is not there.
    pub wrong: u64,
    /// Largest relative error of a distance; `None` is unbounded.
    pub relative: Option<f64>,
    /// Nanoseconds a ray, from whole steady frames: least, median, greatest.
    pub ns: Option<[f64; 3]>,
}

impl Total<'_> {
    /// Pixels that show what is not there, as a share of all.
    #[must_use]
    pub fn wrong_share(&self) -> f64 {
        self.wrong as f64 / self.pixels.max(1) as f64
    }

    /// Whether it ran every scene, so that its sums compare with the others'.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.scenes == self.of_scenes
    }
}

/// The totals of a record, place by place, methods in the order in which they first ran.
#[must_use]
pub fn totals(record: &Record) -> Vec<Total<'_>> {
    let mut totals = Vec::new();
    for place in 0..record.places.len() {
        let here: Vec<&Run> = record.runs.iter().filter(|run| run.place == place && run.refused.is_none()).collect();
        let mut scenes: Vec<usize> = here.iter().map(|run| run.scene).collect();
        scenes.sort_unstable();
        scenes.dedup();
        for method in methods(here.iter().copied()) {
            let runs: Vec<&Run> = here.iter().copied().filter(|run| run.method == method).collect();
            totals.push(Total {
                place,
                method,
                scenes: runs.len(),
                of_scenes: scenes.len(),
                pixels: runs.iter().map(|run| run.errors.pixels).sum(),
                wrong: runs.iter().map(|run| run.errors.wrong()).sum(),
                relative: runs.iter().try_fold(0.0, |most: f64, run| Some(most.max(run.errors.relative.max?))),
                ns: ns_per_ray(&runs),
            });
        }
    }
    totals
}

/// The methods among `runs`, each once, in order.
#[must_use]
pub fn methods<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<&'a str> {
    let mut names = Vec::new();
    for run in runs {
        if !names.contains(&run.method.as_str()) {
            names.push(run.method.as_str());
        }
    }
    names
}

/// Nanoseconds a ray over some runs: least, median and greatest; `None` if any of them was not timed.
#[must_use]
pub fn ns_per_ray(runs: &[&Run]) -> Option<[f64; 3]> {
    let mut ms = [0.0; 3];
    let mut rays = 0.0;
    for run in runs {
        // One ray a pixel; the pictures of a family have no common size.
        rays += run.errors.pixels as f64;
        for (sum, value) in ms.iter_mut().zip(spread(&run.steady_ms)?) {
            *sum += value;
        }
    }
    (rays > 0.0).then(|| ms.map(|ms| ms * 1e6 / rays))
}

/// Least, median and greatest of some samples; `None` without any.
#[must_use]
pub fn spread(samples: &[f64]) -> Option<[f64; 3]> {
    let mut sorted = samples.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (first, last, half) = (*sorted.first()?, *sorted.last()?, sorted.len() / 2);
    let median = if sorted.len() % 2 == 1 { sorted[half] } else { (sorted[half - 1] + sorted[half]) / 2.0 };
    Some([first, median, last])
}

/// Where the errors are looked at: the first adapter that ran anything, else the first place that did.
#[must_use]
pub fn main_place(record: &Record) -> Option<usize> {
    let ran = |place: &usize| record.runs.iter().any(|run| run.place == *place && run.refused.is_none());
    let mut gpus = (0..record.places.len()).filter(|place| record.places[*place].backend == "gpu");
    gpus.find(ran).or_else(|| (0..record.places.len()).find(ran))
}
