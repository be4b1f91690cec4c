//! Whether the columns of a matrix are the axes of a camera. A picture of a mirrored or sheared camera would silently show
//! the view of another one, because the basis is made of the view and of up alone.

use glam::{DMat3, DVec3};

/// The largest difference of a quotient of two lengths from 1, and the largest cosine of an angle that should be right:
/// 0.06 degrees. Matrices that were written with four digits are within it.
const TOLERANCE: f64 = 1e-3;

/// The reason that three columns are no axes, and the remedy.
pub type AxesProblem = (String, &'static str);

/// Checks that three columns are perpendicular, equally long and not mirrored. With `unit` their length must be 1.
///
/// # Errors
/// The first fault that is found, and its remedy.
pub fn check_axes(columns: [[f64; 3]; 3], unit: bool) -> Result<(), AxesProblem> {
    let given = columns.map(DVec3::from);
    let largest = given.iter().map(|column| column.abs().max_element()).fold(0.0, f64::max);
    if !(largest > 0.0 && largest.is_finite()) {
        return Err((
            format!("the largest number of its rotation is {largest}"),
            "give three perpendicular columns of length 1",
        ));
    }
    // Squares of the quotients do not overflow.
    let columns = given.map(|column| column / largest);
    let lengths = columns.map(DVec3::length);
    let [least, most] = [lengths.iter().copied().fold(f64::MAX, f64::min), lengths.iter().copied().fold(0.0, f64::max)];
    let shown = lengths.map(|length| short(length * largest)).join(", ");
    if most > least * (1.0 + TOLERANCE) {
        let problem = format!("the columns of its rotation have the lengths {shown}");
        return Err((problem, "remove the scale: divide each column by its length"));
    }
    let axes = [0, 1, 2].map(|k| columns[k] / lengths[k]);
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let cosine = axes[a].dot(axes[b]);
        if cosine.abs() > TOLERANCE {
            let degrees = short(cosine.clamp(-1.0, 1.0).acos().to_degrees());
            let problem = format!("the columns {a} and {b} of its rotation form an angle of {degrees} degrees");
            return Err((problem, "give a rotation, whose columns are perpendicular"));
        }
    }
    if DMat3::from_cols(axes[0], axes[1], axes[2]).determinant() < 0.0 {
        let problem = "its rotation is mirrored: the determinant is negative".to_owned();
        return Err((problem, "change the sign of the column whose axis points the other way"));
    }
    if unit && [least, most].iter().any(|length| (length * largest - 1.0).abs() > TOLERANCE) {
        let problem = format!("the columns of its rotation have the lengths {shown}");
        return Err((problem, "divide each column by its length, and the eye by the scale if it is scaled too"));
    }
    Ok(())
}

/// A number with six digits.
fn short(number: f64) -> String {
    let rounded = format!("{number:.5e}").parse().unwrap_or(number);
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn turned() -> [[f64; 3]; 3] {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        turn.to_cols_array_2d()
    }

    #[test]
    fn rotations_are_axes() {
        for columns in [ONE, turned()] {
            assert_eq!(check_axes(columns, true), Ok(()));
            for scale in [1e-200, 0.3, 1e200] {
                let scaled = columns.map(|column| column.map(|x| x * scale));
                assert_eq!(check_axes(scaled, false), Ok(()), "{scale}");
                let (problem, _) = check_axes(scaled, true).expect_err("not of length 1");
                assert!(problem.contains("lengths"), "{problem}");
            }
            // Four digits after the point.
            let rounded = columns.map(|column| column.map(|x| (x * 1e4).round() / 1e4));
            assert_eq!(check_axes(rounded, true), Ok(()));
        }
    }

    #[test]
    fn other_matrices_are_not() {
        let [x, y, z] = turned();
        for (columns, word) in [
            ([x.map(|c| -c), y, z], "mirrored"),
            ([y, x, z], "mirrored"),
            ([x.map(|c| c * 1.002), y, z], "lengths"),
            ([x, y, [0.0; 3]], "lengths"),
            ([x, [y[0] + 0.002 * x[0], y[1] + 0.002 * x[1], y[2] + 0.002 * x[2]], z], "0 and 1"),
            ([[0.0; 3]; 3], "is 0"),
            ([[f64::MAX, f64::INFINITY, 0.0], y, z], "inf"),
        ] {
            let (problem, _) = check_axes(columns, false).expect_err(word);
            assert!(problem.contains(word), "{problem}");
        }
    }
}
