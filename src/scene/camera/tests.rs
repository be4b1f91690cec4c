//! Axes of cameras beside two thousand digits, and at the ends of the range.

use super::*;

fn camera(eye: [f64; 3], look: Look, up: [f64; 3]) -> Camera {
    Camera { eye: eye.into(), look, up: up.into(), lens: Camera::CANONICAL.lens }
}

#[test]
fn the_canonical_basis_is_the_axes() {
    let b = Camera::CANONICAL.basis().expect("canonical");
    assert_eq!((b.e, b.u, b.v, b.w), (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z));
}

#[test]
fn any_basis_is_orthonormal_right_handed_and_looks_along_the_view() {
    for scale in [1e-300, 1e-20, 1.0, 1e20, 1e300] {
        for view in [[1.0, 2.0, 3.0], [-1.0, 0.0, 1e-9], [0.0, 1.0, 1e-12], [3.0, -4.0, 5e5]] {
            let view = DVec3::from_array(view) * scale;
            let b = camera([1.0, -2.0, 3.0], Look::View(view), [0.0, 1.0, 0.0]).basis().expect("a basis");
            // 2^-50: three products of components that are each within 2^-52.
            let tiny = 2f64.powi(-50);
            for (a, c) in [(b.u, b.v), (b.v, b.w), (b.w, b.u)] {
                assert!(a.dot(c).abs() <= tiny, "{b:?}");
                assert!((a.length() - 1.0).abs() <= tiny, "{b:?}");
            }
            assert!((b.u.cross(b.v) - b.w).length() <= tiny, "right-handed {b:?}");
            assert!((b.w + view / scale / (view / scale).length()).length() <= tiny, "against the view {b:?}");
            assert!(b.v.y > 0.0, "up points up {b:?}");
        }
    }
}

#[test]
fn at_and_view_agree_also_far_away_and_at_the_ends_of_the_range() {
    let eye = DVec3::new(1e9, -2e9, 3e9);
    let look = DVec3::new(3.0, -5.0, 7.0);
    let at = camera(eye.into(), Look::At(eye + look), [0.0, 0.0, 1.0]).basis().expect("at");
    let view = camera(eye.into(), Look::View(look), [0.0, 0.0, 1.0]).basis().expect("view");
    assert_eq!(at, view);
    let far = camera([-1.7e308, 0.0, 0.0], Look::At(DVec3::new(1.7e308, 0.0, 0.0)), [0.0, 1.0, 0.0]);
    assert_eq!(far.basis().expect("no overflow").w, DVec3::NEG_X);
}

/// A camera of tests/truth/axes.py.
#[derive(serde::Deserialize)]
struct Known {
    eye: [String; 3],
    at: Option<[String; 3]>,
    view: Option<[String; 3]>,
    up: [String; 3],
    axes: Vec<(String, String)>,
}

#[test]
fn axes_are_those_of_two_thousand_digits() {
    let known: Vec<Known> = serde_json::from_str(include_str!("../../../tests/truth/axes.json")).expect("the fixture");
    assert!(known.len() > 150, "{} cameras", known.len());
    let number = |bits: &String| f64::from_bits(u64::from_str_radix(bits, 16).expect("hexadecimal digits"));
    let vector = |bits: &[String; 3]| DVec3::from_array(bits.each_ref().map(number));
    let mut worst = 0.0f64;
    for case in &known {
        let look = match (&case.at, &case.view) {
            (Some(at), _) => Look::At(vector(at)),
            (_, view) => Look::View(vector(view.as_ref().expect("a view"))),
        };
        let camera = camera(vector(&case.eye).into(), look, vector(&case.up).into());
        let axes = camera.axes().expect("axes");
        for (axis, (near, tail)) in axes.iter().flatten().zip(&case.axes) {
            let (near, tail) = (number(near), tail.parse::<f64>().expect("digits"));
            // Both low words are below an ulp of the high one, so their difference is exact enough.
            let off = ((axis.hi - near) + (axis.lo - tail)).abs();
            // The tail has 20 digits, and the smallest f64 is 2^-1074.
            assert!(off <= near.abs() * 2f64.powi(-104) + 2f64.powi(-1073), "{off:e} of {near:e}: {camera:?}");
            worst = worst.max(off / near.abs().max(f64::MIN_POSITIVE));
        }
    }
    println!("axes are off by 2^{:.1} at most", worst.log2());
}

#[test]
fn a_step_of_the_subnormal_numbers_is_a_direction() {
    let step = f64::from_bits(1);
    let at = |at: [f64; 3]| camera([0.0; 3], Look::At(at.into()), [0.0, 1.0, 0.0]).basis().expect("a direction");
    assert_eq!(at([0.0, 0.0, -step]).w, DVec3::Z);
    // 3 steps right and 1 ahead.
    let w = DVec3::new(-3.0, 0.0, 1.0) / 10f64.sqrt();
    assert!((at([3.0 * step, 0.0, -step]).w - w).length() < 1e-15);
}

#[test]
fn degenerate_cameras_are_refused_with_the_field() {
    let y = [0.0, 1.0, 0.0];
    for (camera, field) in [
        (camera([1.0; 3], Look::At(DVec3::ONE), y), "camera.at"),
        (camera([1.0; 3], Look::View(DVec3::ZERO), y), "camera.view"),
        (camera([1.0; 3], Look::View(DVec3::X), [0.0; 3]), "camera.up"),
        (camera([1.0; 3], Look::View(DVec3::NEG_Y * 1e-20), y), "camera.up"),
        (camera([f64::NAN, 0.0, 0.0], Look::View(DVec3::X), y), "camera.eye"),
        (camera([0.0; 3], Look::View(DVec3::new(f64::INFINITY, 0.0, 0.0)), y), "camera.view"),
    ] {
        let error = camera.basis().expect_err(field).to_string();
        assert!(error.contains(field), "{error}");
    }
}

#[test]
fn nearly_parallel_is_judged_relative_to_the_lengths() {
    let up = |x: f64| camera([0.0; 3], Look::View(DVec3::Y * 1e-20), [x * 1e20, 1e20, 0.0]).basis();
    assert!(up(0.9 * PARALLEL).is_err());
    assert!(up(1.1 * PARALLEL).is_ok());
}

#[test]
fn lenses_give_the_viewport() {
    let lens = |lens| Camera { lens, ..Camera::CANONICAL }.viewport(200, 100);
    let square = lens(Lens::Vfov { degrees: 90.0, distance: 3.0 }).expect("vfov");
    // tan(45 degrees) rounds to within an ulp of 1.
    assert!((square.vh - 6.0).abs() < 1e-14 && (square.vw - 12.0).abs() < 1e-14, "{square:?}");
    let rows = lens(Lens::RowCentres { degrees: 90.0 }).expect("rows");
    assert!((rows.vh * 99.0 / 100.0 - 2.0).abs() < 1e-14, "{rows:?}");
    let parallel = lens(Lens::Orthographic { height: 12.0 }).expect("orthographic");
    assert_eq!(parallel, Viewport { vw: 24.0, vh: 12.0, d: f64::INFINITY });
    for bad in [
        Lens::Vfov { degrees: 180.0, distance: 1.0 },
        Lens::Vfov { degrees: 0.0, distance: 1.0 },
        Lens::Vfov { degrees: 40.0, distance: -1.0 },
        Lens::Viewport { vw: 0.0, vh: 1.0, distance: 1.0 },
        Lens::Viewport { vw: 1.0, vh: f64::INFINITY, distance: 1.0 },
        Lens::RowCentres { degrees: f64::NAN },
        Lens::Orthographic { height: 0.0 },
        Lens::Orthographic { height: f64::NAN },
        Lens::Orthographic { height: 1.7e308 },
    ] {
        lens(bad).expect_err("a lens that opens no viewport");
    }
}
