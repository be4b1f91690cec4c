//! Circles in space, as a camera sees them: outlines of balls, and where the surfaces of two cross.

use super::wave::Wave;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A sphere in the camera's coordinates: right, up and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ball {
    /// The centre.
    pub(super) center: DVec3,
    /// The radius.
    pub(super) radius: f64,
}

/// A camera whose rays come from the origin, or are parallel and look along -z. A point is seen at `middle` + `scale` times its place
/// over its depth, or times its place where rays are parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Projection {
    /// The place of the axis in the image.
    pub(super) middle: DVec2,
    /// Units of the image for a slope of 1, or for a unit of length; the second one is negative where rows go down.
    pub(super) scale: DVec2,
    /// Whether rays are parallel.
    pub(super) is_parallel: bool,
}

impl Projection {
    /// The place of a point in the image.
    pub(super) fn place(&self, x: DVec3) -> DVec2 {
        let depth = if self.is_parallel { 1.0 } else { -x.z };
        self.middle + self.scale * x.truncate() / depth
    }

    /// The longer side of a unit of the image at a depth, in units of the scene.
    pub(super) fn pixel(&self, depth: f64) -> f64 {
        let side = self.scale.abs().min_element().recip();
        if self.is_parallel { side } else { side * depth }
    }

    /// The direction of a point's derivative in the image, times the square of the depth.
    pub(super) fn velocity(&self, x: DVec3, moved: DVec3) -> DVec2 {
        match self.is_parallel {
            true => self.scale * moved.truncate(),
            false => self.scale * (moved.truncate() * -x.z + x.truncate() * moved.z),
        }
    }

    /// The ray through a place of the image: its start and its direction, whose depth is 1.
    pub(super) fn ray(&self, place: DVec2) -> (DVec3, DVec3) {
        let at = ((place - self.middle) / self.scale).extend(0.0);
        if self.is_parallel { (at, DVec3::NEG_Z) } else { (DVec3::ZERO, at - DVec3::Z) }
    }

    /// The movement of a point of a surface with this normal, as its place in the image moves: in slopes, or in lengths of the camera.
    pub(super) fn shift(&self, normal: DVec3, x: DVec3, toward: DVec2) -> DVec3 {
        let way = if self.is_parallel { DVec3::NEG_Z } else { x / -x.z };
        let moved = (if self.is_parallel { toward } else { toward * -x.z }).extend(0.0);
        moved - way * (normal.dot(moved) / normal.dot(way))
    }

    /// The way of the ray through a point.
    pub(super) fn way(&self, x: DVec3) -> DVec3 {
        if self.is_parallel { DVec3::NEG_Z } else { x }
    }
}

/// The part of the square of a radius below which a discriminant means that the ray only touches.
const TOUCHING: f64 = 1e-11;

/// The part of the square of a radius within which a ray may touch: a cut more than is needed does no harm.
const NEAR: f64 = 1e-8;

impl Ball {
    /// The depths at which the ray of a place enters the ball and leaves it. A ray that only touches the ball has depths if it
    /// touches nearer than `near`, and not farther away. Outlines that are one in the image belong to the nearest ball.
    pub(super) fn depths(&self, projection: &Projection, place: DVec2, near: f64) -> Option<[f64; 2]> {
        let (start, along) = projection.ray(place);
        let (away, a) = (self.center - start, along.length_squared());
        let b = along.dot(away);
        let across = away - along * (b / a);
        let radius2 = self.radius * self.radius;
        let disc = radius2 - across.length_squared();
        let least = if b / a < near { -TOUCHING } else { TOUCHING };
        if disc < least * radius2 {
            return None;
        }
        let (power, root) = (away.length_squared() - radius2, (a * disc.max(0.0)).sqrt());
        let first = if projection.is_parallel { b - root } else { power / (b + root) };
        Some([first, (b + root) / a])
    }

    /// Whether the ray of a place touches the ball: its squared distance from the centre is the squared radius within [`NEAR`].
    pub(super) fn is_touched(&self, projection: &Projection, place: DVec2) -> bool {
        let (start, along) = projection.ray(place);
        let away = self.center - start;
        let across = away - along * (along.dot(away) / along.length_squared());
        (across.length_squared() / (self.radius * self.radius) - 1.0).abs() < NEAR
    }

    /// Whether a point of the surface faces the eye.
    pub(super) fn faces(&self, projection: &Projection, x: DVec3) -> bool {
        (x - self.center).dot(projection.way(x)) < 0.0
    }

    /// The same, also of a point so near the contour that arithmetic does not tell.
    pub(super) fn may_face(&self, projection: &Projection, x: DVec3) -> bool {
        let way = projection.way(x);
        (x - self.center).dot(way) < NEAR * self.radius * way.length()
    }

    /// The circle of points where rays touch the ball.
    pub(super) fn contour(&self, projection: &Projection) -> Circle {
        if projection.is_parallel {
            return Circle::new(self.center, DVec3::Z, self.radius);
        }
        let length2 = self.center.length_squared();
        let inner = 1.0 - self.radius * self.radius / length2;
        Circle::new(self.center * inner, self.center / length2.sqrt(), self.radius * inner.sqrt())
    }

    /// The circle in which the surfaces of two balls cross; `None` where they do not.
    pub(super) fn crossing(&self, other: &Self) -> Option<Circle> {
        let between = other.center - self.center;
        let distance2 = between.length_squared();
        let distance = distance2.sqrt();
        if !(distance < self.radius + other.radius && distance > (self.radius - other.radius).abs()) {
            return None;
        }
        let share = 0.5 * (1.0 + (self.radius - other.radius) * (self.radius + other.radius) / distance2);
        let radius2 = self.radius * self.radius - share * share * distance2;
        (radius2 > 0.0).then(|| Circle::new(self.center + share * between, between / distance, radius2.sqrt()))
    }
}

/// A circle: the points center + cos a u + sin a v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    pub(super) center: DVec3,
    u: DVec3,
    v: DVec3,
}

/// A plane: the points x with normal.x = distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub(super) normal: DVec3,
    pub(super) distance: f64,
}

impl Plane {
    /// The plane of the contour of a ball.
    pub(super) fn of_contour(ball: &Ball, projection: &Projection) -> Self {
        match projection.is_parallel {
            true => Self { normal: DVec3::Z, distance: ball.center.z },
            false => Self { normal: ball.center, distance: ball.center.length_squared() - ball.radius * ball.radius },
        }
    }

    /// The plane in which the surfaces of two balls cross.
    pub(super) fn between(a: &Ball, b: &Ball) -> Self {
        let between = b.center - a.center;
        let share = 0.5 * (between.length_squared() + (a.radius - b.radius) * (a.radius + b.radius));
        Self { normal: between, distance: between.dot(a.center) + share }
    }

    /// The plane of the rays through the points of a line.
    pub(super) fn of_rays(line: &Line, projection: &Projection) -> Self {
        let normal = line.along.cross(if projection.is_parallel { DVec3::Z } else { line.from });
        Self { normal, distance: if projection.is_parallel { normal.dot(line.from) } else { 0.0 } }
    }

    /// The height of a point above it, in lengths of its normal.
    pub(super) fn height(&self, x: DVec3) -> f64 {
        self.normal.dot(x) - self.distance
    }

    /// The point of the plane on the ray through a point.
    fn on_ray(&self, x: DVec3, projection: &Projection) -> DVec3 {
        match projection.is_parallel {
            true => x - DVec3::Z * (self.height(x) / self.normal.z),
            false => x * (self.distance / self.normal.dot(x)),
        }
    }

    /// The circle in which it cuts the surface of a ball; `None` where it does not. Its normal has the length 1.
    pub(super) fn cut(&self, ball: &Ball) -> Option<Circle> {
        let height = self.height(ball.center);
        let radius2 = (ball.radius - height) * (ball.radius + height);
        (radius2 > 0.0).then(|| Circle::new(ball.center - height * self.normal, self.normal, radius2.sqrt()))
    }

    /// The line in which it cuts another plane; `None` for parallel ones. Both normals have the length 1.
    pub(super) fn crossing(&self, other: &Self) -> Option<Line> {
        let along = self.normal.cross(other.normal);
        let length2 = along.length_squared();
        let from = (self.distance * other.normal.cross(along) + other.distance * along.cross(self.normal)) / length2;
        (length2 > 1e-20).then(|| Line { from, along: along / length2.sqrt() })
    }
}

/// A straight line: the points from + t along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub(super) from: DVec3,
    pub(super) along: DVec3,
}

impl Line {
    /// The t at which it passes through a plane.
    pub(super) fn through(&self, plane: &Plane) -> f64 {
        -plane.height(self.from) / plane.normal.dot(self.along)
    }

    /// The t of the point that is seen where a point is seen, which is seen on the line.
    pub(super) fn under(&self, x: DVec3, projection: &Projection) -> f64 {
        if projection.is_parallel {
            let along = self.along.truncate();
            return (x - self.from).truncate().dot(along) / along.length_squared();
        }
        let across = self.along.cross(self.from).cross(x);
        -across.dot(self.from) / across.dot(self.along)
    }
}

impl Circle {
    fn new(center: DVec3, normal: DVec3, radius: f64) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        Self { center, u: radius * u, v: radius * v }
    }

    /// A point of the circle.
    pub(super) fn point(&self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        self.center + cos * self.u + sin * self.v
    }

    /// The direction in which its picture goes on at an angle.
    pub(super) fn tangent(&self, projection: &Projection, angle: f64) -> DVec2 {
        let (sin, cos) = angle.sin_cos();
        projection.velocity(self.point(angle), cos * self.v - sin * self.u).normalize_or_zero()
    }

    /// The depth of its farthest point.
    pub(super) fn deepest(&self) -> f64 {
        self.u.z.hypot(self.v.z) - self.center.z
    }

    /// A ball around it.
    pub(super) fn ball(&self) -> Ball {
        Ball { center: self.center, radius: self.u.length() }
    }

    /// The angle of a point near the circle, from 0 to a turn.
    pub(super) fn angle(&self, x: DVec3) -> f64 {
        let away = x - self.center;
        away.dot(self.v).atan2(away.dot(self.u)).rem_euclid(TAU)
    }

    /// The angles at which the circle passes through a plane.
    pub(super) fn through(&self, plane: &Plane) -> Vec<f64> {
        let a = plane.normal.dot(self.center) - plane.distance;
        let [b, c] = [self.u, self.v].map(|axis| plane.normal.dot(axis));
        let size = b.hypot(c);
        if a.abs() >= size {
            return Vec::new();
        }
        let (middle, half) = (c.atan2(b), (-a / size).acos());
        [middle - half, middle + half].map(|angle| angle.rem_euclid(TAU)).to_vec()
    }

    /// The angles at which the ray through a point of the circle touches a ball, and crosses its outline.
    pub(super) fn touching(&self, ball: &Ball, projection: &Projection) -> Vec<f64> {
        let Self { center, u, v } = *self;
        let wave = if projection.is_parallel {
            let [m, u, v] = [center - ball.center, u, v].map(DVec3::truncate);
            let [uu, vv] = [u, v].map(DVec2::length_squared);
            Wave {
                mean: m.length_squared() + 0.5 * (uu + vv) - ball.radius * ball.radius,
                first: [2.0 * m.dot(u), 2.0 * m.dot(v)],
                second: [0.5 * (uu - vv), u.dot(v)],
            }
        } else {
            let power = ball.center.length_squared() - ball.radius * ball.radius;
            let [m, a, b] = [center, u, v].map(|x| x.dot(ball.center));
            let length2 = center.length_squared() + u.length_squared();
            Wave {
                mean: m * m + 0.5 * (a * a + b * b) - power * length2,
                first: [2.0 * (m * a - power * center.dot(u)), 2.0 * (m * b - power * center.dot(v))],
                second: [0.5 * (a * a - b * b), a * b],
            }
        };
        wave.zeros()
    }

    /// The angles at which the ray through a point of the circle passes through a circle of a plane.
    pub(super) fn meeting(&self, other: &Self, plane: &Plane, projection: &Projection) -> Vec<f64> {
        let linear = |of: DVec3| [self.center, self.u, self.v].map(|x| x.dot(of));
        let radius2 = other.u.length_squared();
        if projection.is_parallel {
            // The point on the plane is x - Z h/nz; its distance from the middle, in x, y and z times nz.
            let [mut height, inner] = [linear(plane.normal), other.center.to_array()];
            height[0] -= plane.distance;
            let nz = plane.normal.z;
            let away = |k: usize| {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z][k];
                let own = linear(axis);
                [0, 1, 2]
                    .map(|n| nz * (own[n] - if n == 0 { inner[k] } else { 0.0 }) - if k == 2 { height[n] } else { 0.0 })
            };
            let [x, y, z] = [0, 1, 2].map(away);
            let wave = Wave::product(x, x).plus(1.0, &Wave::product(y, y)).plus(1.0, &Wave::product(z, z));
            return wave.plus(-radius2 * nz * nz, &Wave::product([1.0, 0.0, 0.0], [1.0, 0.0, 0.0])).zeros();
        }
        // With p = x d / n.x: |p - m|^2 - r^2, times (n.x)^2.
        let [along, middle] = [plane.normal, other.center].map(linear);
        let d = plane.distance;
        let own = [DVec3::X, DVec3::Y, DVec3::Z].map(linear).map(|axis| Wave::product(axis, axis));
        let square = own[0].plus(1.0, &own[1]).plus(1.0, &own[2]);
        let wave = Wave::product([0.0; 3], [0.0; 3]).plus(d * d, &square);
        let wave = wave.plus(-2.0 * d, &Wave::product(along, middle));
        wave.plus(other.center.length_squared() - radius2, &Wave::product(along, along)).zeros()
    }

    /// The angle of the point of a circle of a plane that is seen where a point is seen.
    pub(super) fn under(&self, x: DVec3, plane: &Plane, projection: &Projection) -> f64 {
        self.angle(plane.on_ray(x, projection))
    }

    /// The angles of the points that are seen where a point is seen, of a circle of a plane that is seen from its side.
    pub(super) fn on_edge(&self, x: DVec3, plane: &Plane, projection: &Projection) -> Vec<f64> {
        let normal = projection.way(x).cross(plane.normal);
        self.through(&Plane { normal, distance: normal.dot(x) })
    }

    /// The point of a ball's contour that the ray through a point touches, if it touches the ball.
    pub(super) fn touched(ball: &Ball, x: DVec3, projection: &Projection) -> DVec3 {
        match projection.is_parallel {
            true => DVec3::new(x.x, x.y, ball.center.z),
            false => x * (x.dot(ball.center) / x.length_squared()),
        }
    }

    /// The picture of the circle as a matrix: columns of u, v and the centre, rows of place times depth, and depth.
    fn picture(&self, projection: &Projection) -> [DVec3; 3] {
        let column = |x: DVec3, one: f64| {
            let depth = if projection.is_parallel { one } else { -x.z };
            (projection.scale * x.truncate() + projection.middle * depth).extend(depth)
        };
        [column(self.u, 0.0), column(self.v, 0.0), column(self.center, 1.0)]
    }

    /// The ellipse that the camera sees; `None` for a circle that is seen from its side.
    pub(super) fn ellipse(&self, projection: &Projection) -> Option<Ellipse> {
        // With p = M (cos, sin, 1) the conic is p' M^-T diag(1, 1, -1) M^-1 p = 0, and its dual M diag(1, 1, -1) M'.
        let [u, v, c] = self.picture(projection);
        let dual = |i: usize, j: usize| u[i] * u[j] + v[i] * v[j] - c[i] * c[j];
        let w = dual(2, 2);
        let center = DVec2::new(dual(0, 2), dual(1, 2)) / w;
        // The dual of an ellipse around its centre is the matrix of its squared half axes, negated.
        let xx = center.x * center.x - dual(0, 0) / w;
        let xy = center.x * center.y - dual(0, 1) / w;
        let yy = center.y * center.y - dual(1, 1) / w;
        let (mean, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let turn = 0.5 * xy.atan2(0.5 * (xx - yy));
        let axes = [mean + half, mean - half].map(|x| x.max(0.0).sqrt());
        (w < 0.0 && axes[1] > 1e-9 * axes[0]).then_some(Ellipse { center, axes, turn })
    }
}

/// An ellipse in the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ellipse {
    /// The centre.
    pub(super) center: DVec2,
    /// Half the longer and the shorter axis.
    pub(super) axes: [f64; 2],
    /// The angle from the first axis of the image to the longer axis, toward the second.
    pub(super) turn: f64,
}

impl Ellipse {
    /// The angle of a place in the frame where the ellipse is a circle.
    pub(super) fn angle(&self, place: DVec2) -> f64 {
        let away = DVec2::from_angle(-self.turn).rotate(place - self.center);
        (away.y / self.axes[1]).atan2(away.x / self.axes[0])
    }

    /// The place at such an angle.
    pub(super) fn place(&self, angle: f64) -> DVec2 {
        let (sin, cos) = angle.sin_cos();
        self.center + DVec2::from_angle(self.turn).rotate(DVec2::new(self.axes[0] * cos, self.axes[1] * sin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipses_hold_the_points_of_their_circles() {
        for is_parallel in [false, true] {
            let projection = Projection { middle: DVec2::new(50.0, 40.0), scale: DVec2::new(30.0, -30.0), is_parallel };
            let [a, b] = [([0.3, 0.2, -5.0], 1.0), ([0.9, 0.5, -5.5], 0.8)]
                .map(|(center, radius)| Ball { center: DVec3::from_array(center), radius });
            for circle in [a.contour(&projection), b.contour(&projection), a.crossing(&b).expect("a circle")] {
                let ellipse = circle.ellipse(&projection).expect("an ellipse");
                for n in 0..20 {
                    let place = projection.place(circle.point(f64::from(n)));
                    assert!(place.distance(ellipse.place(ellipse.angle(place))) < 1e-12, "{ellipse:?}");
                }
            }
            // Along an outline another ball is touched where it crosses the other outline.
            let outline = a.contour(&projection);
            let angles = outline.touching(&b, &projection);
            assert_eq!(angles.len(), 2);
            for angle in angles {
                let x = outline.point(angle);
                let other = Circle::touched(&b, x, &projection);
                assert!((other.distance(b.center) - b.radius).abs() < 1e-12);
                assert!(projection.place(x).distance(projection.place(other)) < 1e-11);
                assert!((x.distance(a.center) - a.radius).abs() < 1e-12);
            }
        }
    }
}
