//! Checks every claim at every sampled pixel, in every mode of the adversary and in plain f32.

use super::claims::{Case, Checks, check};
use super::wild::{Mode, Wild, under};
use super::worlds::{FAMILIES, Make};
use crate::certify::binned::BinnedScene;
use crate::certify::{TERMS, Terms};
use crate::testing::Rng;

/// Scenes of each family; `HALFLINE_SCENES` replaces the number.
fn scenes() -> u64 {
    std::env::var("HALFLINE_SCENES").map_or(150, |scenes| scenes.parse().expect("a number"))
}

/// The tolerances of the scenes.
fn tolerance(rng: &mut Rng) -> f64 {
    [1e-5, 1e-3, 1e-6, 0.9, 2f64.powi(-50)][rng.below(5) as usize]
}

/// The n-th scene of a family.
pub(super) fn case(make: Make, n: u64, terms: &Terms) -> Option<Case> {
    let mut rng = Rng(n.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let world = make(&mut rng);
    let tolerance = tolerance(&mut rng);
    (!world.scene.spheres.is_empty()).then(|| Case::new(world.scene, tolerance, &world.pixels, terms))?
}

/// The numbers of certain pixels and of all; or the first false claim.
pub(super) fn hold(
    case: &Case,
    binned: &BinnedScene,
    terms: &Terms,
    checks: Checks,
    seed: u64,
) -> Result<[u64; 2], String> {
    let mut count = [0, 0];
    let mut add = |certain: bool| count = [count[0] + u64::from(certain), count[1] + 1];
    case.with::<f32, _>(binned, terms, |twin| -> Result<(), String> {
        case.judged.iter().try_for_each(|judged| check(case, twin, judged, checks).map(&mut add))
    })?;
    case.with::<Wild, _>(binned, terms, |twin| -> Result<(), String> {
        for judged in &case.judged {
            for (k, mode) in (0..).zip(Mode::BLIND.into_iter().chain([Mode::Random; 3])) {
                let claim = under(mode, seed.wrapping_add(k), || check(case, twin, judged, checks));
                add(claim.map_err(|e| format!("{mode:?}: {e}"))?);
            }
        }
        Ok(())
    })?;
    Ok(count)
}

fn family(k: usize) {
    let (name, make) = FAMILIES[k];
    let (mut certain, mut all, mut staged) = (0, 0, 0);
    for n in 0..scenes() {
        let Some(case) = case(make, n, &TERMS) else { continue };
        let [some, every] = hold(&case, &case.binned, &TERMS, Checks::ALL, n)
            .unwrap_or_else(|e| panic!("{name} {n}: {e}\n{:?}", case.scene));
        (certain, all, staged) = (certain + some, all + every, staged + 1);
    }
    println!("{name:16} {staged:5} scenes {all:7} answers, certain {:5.1} %", 100.0 * certain as f64 / all as f64);
    assert!(staged > scenes() / 2, "{name}: few scenes could be binned");
    assert!(certain > 0, "{name}: no pixel was certain");
}

#[test]
fn no_claim_is_false_however_the_device_rounds() {
    (0..FAMILIES.len() / 2).for_each(family);
}

#[test]
fn no_claim_is_false_however_the_device_rounds_further_families() {
    (FAMILIES.len() / 2..FAMILIES.len()).for_each(family);
}
