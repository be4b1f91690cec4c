//! A camera's axes for the exact values of these tests, in integers on one fixed grid: independent of the code under test,
//! [`Camera::axes`].

use crate::double_double::{Dd, Dd3};
use crate::scene::camera::{Camera, Look};
use dashu_int::IBig;
use dashu_int::ops::SquareRoot;
use std::cell::Cell;

/// Bits after the binary point.
const POINT: usize = 140;
/// Additional bits of roots and quotients.
const SPARE: usize = 60;

/// x 2^1074, which is an integer for every finite f64.
fn whole(x: f64) -> IBig {
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as usize, bits & ((1 << 52) - 1));
    let magnitude = if field == 0 { IBig::from(fraction) } else { IBig::from(fraction | 1 << 52) << (field - 1) };
    if x < 0.0 { -magnitude } else { magnitude }
}

type Vector = [IBig; 3];

fn cross(a: &Vector, b: &Vector) -> Vector {
    let part = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
    [part(1, 2), part(2, 0), part(0, 1)]
}

/// a / |a|, each component within 2^-139.
fn unit(a: &Vector) -> Dd3 {
    let square = &a[0] * &a[0] + &a[1] * &a[1] + &a[2] * &a[2];
    let (_, square) = (square << (2 * SPARE)).into_parts();
    let length = IBig::from(square.sqrt());
    a.each_ref().map(|x| {
        let fixed = (x << (POINT + SPARE)) / &length;
        // 53 bits, and the 87 below them.
        let high = &fixed >> 87;
        let low = &fixed - (&high << 87);
        let [high, low] = [high, low].map(|part| i128::try_from(part).expect("at most 2^140") as f64);
        Dd::sum(high * 2f64.powi(87 - POINT as i32), low * 2f64.powi(-(POINT as i32)))
    })
}

thread_local! {
    /// The last camera and its axes, which are the same for every pixel of a scene.
    static LAST: Cell<Option<(Camera, [Dd3; 3])>> = const { Cell::new(None) };
}

/// u, v and w.
pub(super) fn axes(camera: &Camera) -> [Dd3; 3] {
    if let Some((last, axes)) = LAST.get()
        && last == *camera
    {
        return axes;
    }
    let vector = |a: glam::DVec3| a.to_array().map(whole);
    let view = match camera.look {
        Look::At(at) => {
            let (at, eye) = (vector(at), vector(camera.eye));
            std::array::from_fn(|k| &at[k] - &eye[k])
        }
        Look::View(view) => vector(view),
    };
    let back = view.map(|x| -x);
    let right = cross(&vector(camera.up), &back);
    let axes = [unit(&right), unit(&cross(&back, &right)), unit(&back)];
    LAST.set(Some((*camera, axes)));
    axes
}

#[test]
fn an_axis_is_a_pythagorean_triple() {
    let camera = Camera {
        eye: glam::DVec3::new(1.0, 2.0, 3.0),
        look: Look::View(glam::DVec3::new(3.0, 0.0, 4.0) * 2f64.powi(-1000)),
        ..Camera::CANONICAL
    };
    let [u, v, w] = axes(&camera).map(|axis| axis.map(Dd::value));
    assert_eq!((u, v, w), ([-0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, -0.8]));
}
