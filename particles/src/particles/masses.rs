//! Elements by mass, for files without element names.

/// Standard atomic weights by atomic number from 1, abridged: Prohaska et al., Pure Appl. Chem. 94, 573 (2022). 0 for
/// elements without one.
#[rustfmt::skip]
const WEIGHTS: [f64; 92] = [
    1.008, 4.0026, 6.94, 9.0122, 10.81, 12.011, 14.007, 15.999, 18.998, 20.180,
    22.990, 24.305, 26.982, 28.085, 30.974, 32.06, 35.45, 39.95, 39.098, 40.078,
    44.956, 47.867, 50.942, 51.996, 54.938, 55.845, 58.933, 58.693, 63.546, 65.38,
    69.723, 72.630, 74.922, 78.971, 79.904, 83.798, 85.468, 87.62, 88.906, 91.224,
    92.906, 95.95, 0.0, 101.07, 102.91, 106.42, 107.87, 112.41, 114.82, 118.71,
    121.76, 127.60, 126.90, 131.29, 132.91, 137.33, 138.91, 140.12, 140.91, 144.24,
    0.0, 150.36, 151.96, 157.25, 158.93, 162.50, 164.93, 167.26, 168.93, 173.05,
    174.97, 178.49, 180.95, 183.84, 186.21, 190.23, 192.22, 195.08, 196.97, 200.59,
    204.38, 207.2, 208.98, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 232.04,
    231.04, 238.03,
];

/// The largest difference of a mass from an element's. It allows usual rounding (14.0067, 1.0, 35.5) and is smaller
/// than the difference of any two neighbours except nickel and cobalt, where the nearer is taken.
const TOLERANCE: f64 = 0.1;

/// The atomic numbers of these masses, if all of them look like atomic masses in u. Whole numbers up to 4 do not: they
/// are usual in reduced units.
pub(crate) fn elements(masses: &[f64]) -> Option<Vec<u8>> {
    if masses.iter().all(|mass| mass.fract() == 0.0 && *mass <= 4.0) {
        return None;
    }
    masses.iter().map(|mass| nearest(*mass)).collect()
}

/// The atomic number of this mass, if it looks like an atomic mass.
pub(super) fn nearest(mass: f64) -> Option<u8> {
    let away = |weight: &f64| (weight - mass).abs();
    let (place, weight) = WEIGHTS.iter().enumerate().min_by(|a, b| away(a.1).total_cmp(&away(b.1)))?;
    (away(weight) <= TOLERANCE && *weight > 0.0).then_some(place as u8 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_give_elements_where_they_match() {
        assert_eq!(elements(&[12.0107, 1.0, 15.9994, 55.845]), Some(vec![6, 1, 8, 26]));
        assert_eq!(elements(&[58.6934, 58.9332, 39.948, 39.0983]), Some(vec![28, 27, 18, 19]));
        for reduced in [&[1.0][..], &[1.0, 2.0], &[72.0, 12.011], &[0.5], &[f64::NAN], &[]] {
            assert_eq!(elements(reduced), None, "{reduced:?}");
        }
    }
}
