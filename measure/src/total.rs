//! Sums over the scenes of a record, for each method and place.

use super::record::{Record, Run};

/// The results of a method in a place, over all its scenes.
#[derive(Debug, Clone, PartialEq)]
pub struct Total<'a> {
    /// Index of the place in the record.
    pub place: usize,
    /// Its name.
    pub method: &'a str,
    /// The number of scenes that the method ran.
    pub scenes: usize,
    /// The number of scenes that any method ran in this place.
    pub of_scenes: usize,
    /// Pixels compared with the exact answer.
    pub pixels: u64,
    /// Wrong pixels.
    pub wrong: u64,
    /// Largest relative error of a distance; `None` is unbounded.
    pub relative: Option<f64>,
    /// Nanoseconds per ray, from whole steady frames: minimum, median, maximum.
    pub ns: Option<[f64; 3]>,
}

impl Total<'_> {
    /// Wrong pixels as a share of all.
    #[must_use]
    pub fn wrong_share(&self) -> f64 {
        self.wrong as f64 / self.pixels.max(1) as f64
    }

    /// Whether it ran every scene, so that its sums are comparable.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.scenes == self.of_scenes
    }
}

/// The totals of a record, place by place, with methods in the order of their first run.
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

/// The methods among `runs`, without duplicates, in order.
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

/// Nanoseconds per ray over some runs: minimum, median and maximum; `None` if any of them was not timed.
#[must_use]
pub fn ns_per_ray(runs: &[&Run]) -> Option<[f64; 3]> {
    let mut ms = [0.0; 3];
    let mut rays = 0.0;
    for run in runs {
        // One ray per pixel; the pictures of a family have different sizes.
        rays += run.errors.pixels as f64;
        for (sum, value) in ms.iter_mut().zip(spread(&run.steady_ms)?) {
            *sum += value;
        }
    }
    (rays > 0.0).then(|| ms.map(|ms| ms * 1e6 / rays))
}

/// Minimum, median and maximum of samples; `None` without any.
#[must_use]
pub fn spread(samples: &[f64]) -> Option<[f64; 3]> {
    let mut sorted = samples.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (first, last, half) = (*sorted.first()?, *sorted.last()?, sorted.len() / 2);
    let median = if sorted.len() % 2 == 1 { sorted[half] } else { (sorted[half - 1] + sorted[half]) / 2.0 };
    Some([first, median, last])
}

/// The place whose errors are reported: the first adapter with a run, else the first place with one.
#[must_use]
pub fn main_place(record: &Record) -> Option<usize> {
    let ran = |place: &usize| record.runs.iter().any(|run| run.place == *place && run.refused.is_none());
    let mut gpus = (0..record.places.len()).filter(|place| record.places[*place].backend == "gpu");
    gpus.find(ran).or_else(|| (0..record.places.len()).find(ran))
}
