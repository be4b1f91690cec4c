//! The curves along which what is seen may change, and the places at which they are cut: where they cross each other in the image.

use super::cells::{Cells, Extent};
use super::circle::{Ball, Circle, Line, Plane, Projection};
use super::solids::{Cut, Solids};
use glam::{DVec2, DVec3};
use halfline::parallel;
use std::f64::consts::TAU;

/// A circle or a straight line in space.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    Circle(Circle),
    Line(Line),
}

impl Shape {
    /// A point of it: at an angle, or at a distance.
    pub(super) fn point(&self, at: f64) -> DVec3 {
        match self {
            Self::Circle(circle) => circle.point(at),
            Self::Line(line) => line.from + at * line.along,
        }
    }

    /// The direction in which its picture goes on.
    pub(super) fn tangent(&self, projection: &Projection, at: f64) -> DVec2 {
        match self {
            Self::Circle(circle) => circle.tangent(projection, at),
            Self::Line(line) => projection.velocity(self.point(at), line.along).normalize_or_zero(),
        }
    }

    /// The depth behind which none of a circle lies.
    fn deepest(&self) -> f64 {
        match self {
            Self::Circle(circle) => circle.deepest(),
            Self::Line(_) => f64::INFINITY,
        }
    }

    fn through(&self, plane: &Plane) -> Vec<f64> {
        match self {
            Self::Circle(circle) => circle.through(plane),
            Self::Line(line) => vec![line.through(plane)].into_iter().filter(|at| at.is_finite()).collect(),
        }
    }
}

/// The kind of a curve, by the surfaces that it bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The outline of a ball.
    Outline(u32),
    /// The circle in which the surfaces of two balls cross.
    Crossing([u32; 2]),
    /// The circle in which a plane cuts the surface of a ball.
    Rim { ball: u32, plane: u32 },
    /// The line in which two planes cross.
    Ridge([u32; 2]),
    /// An edge of the window.
    Edge,
}

/// A curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    pub(super) shape: Shape,
    pub(super) kind: Kind,
}

/// All curves of a scene, and the places at which each is cut.
pub(super) struct Curves<'a> {
    solids: &'a Solids,
    pub(super) all: Vec<Curve>,
    pub(super) cuts: Vec<Vec<f64>>,
}

/// Curves that are cut together on one core.
const BLOCK: usize = 64;

/// The distance in the image from a point where two curves touch within which they are not cut again.
const CLOSE: f64 = 1e-4;

/// The pairs of balls that share a cell, the lower one first.
fn pairs(cells: &Cells) -> Vec<[u32; 2]> {
    let mut all = Vec::new();
    for balls in cells.all() {
        for (k, a) in balls.iter().enumerate() {
            all.extend(balls[k + 1..].iter().map(|b| [*a.min(b), *a.max(b)]));
        }
    }
    all.sort_unstable();
    all.dedup();
    all
}

impl<'a> Curves<'a> {
    /// The curves of what is listed in cells, cut at each other and at the edges of a window.
    pub(super) fn new(solids: &'a Solids, cells: &Cells, window: [DVec2; 2]) -> Self {
        let Solids { balls, projection, cuts: planes, .. } = solids;
        let mut listed: Vec<u32> = cells.all().flatten().copied().collect();
        listed.sort_unstable();
        listed.dedup();
        let pairs = pairs(cells);
        let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); balls.len()];
        for [a, b] in &pairs {
            neighbors[*a as usize].push(*b);
            neighbors[*b as usize].push(*a);
        }
        let mut curves = Self { solids, all: Vec::new(), cuts: Vec::new() };
        let mut outline_of = vec![u32::MAX; balls.len()];
        for &n in &listed {
            let contour = balls[n as usize].contour(projection);
            outline_of[n as usize] = curves.push(Shape::Circle(contour), Kind::Outline(n));
        }
        let mut rims_of: Vec<Vec<u32>> = vec![Vec::new(); balls.len()];
        for &n in listed.iter().filter(|n| solids.is_cut[**n as usize] || solids.is_spared[**n as usize]) {
            for (plane, cut) in (0..).zip(planes) {
                if let Some(circle) = cut.plane.cut(&balls[n as usize]) {
                    let rim = curves.push(Shape::Circle(circle), Kind::Rim { ball: n, plane });
                    rims_of[n as usize].push(rim);
                }
            }
        }
        let is_hidden = |circle: &Circle| {
            let Extent { low, high, depth, .. } = Extent::of(&circle.ball(), projection);
            cells.hide([low, high], depth)
        };
        let crossings = curves.all.len();
        for of in &pairs {
            let [a, b] = of.map(|n| &balls[n as usize]);
            if let Some(circle) = a.crossing(b).filter(|circle| !is_hidden(circle)) {
                curves.push(Shape::Circle(circle), Kind::Crossing(*of));
            }
        }
        let lines = curves.all.len();
        curves.add_lines(window);
        let about = About { balls, planes, outline_of, rims_of, neighbors };
        let pass = |count: usize, each: &(dyn Fn(usize, &mut Cutter<'_>) + Sync)| {
            parallel::collect(count, BLOCK, &|range, found: &mut Vec<(u32, f64)>| {
                let mut cutter = Cutter { solids, curves: &curves.all, found: Vec::new() };
                range.for_each(|n| each(n, &mut cutter));
                *found = cutter.found;
            })
        };
        let found = [
            pass(pairs.len(), &|n, cutter| {
                let [a, b] = pairs[n].map(|n| about.outline_of[n as usize]);
                cutter.cross(a, b, &[]);
            }),
            pass(lines - crossings, &|n, cutter| about.cut_crossing((crossings + n) as u32, cutter)),
            pass(listed.len(), &|n, cutter| about.cut_rims(listed[n], cutter)),
            pass(curves.all.len() - lines, &|n, cutter| {
                let line = (lines + n) as u32;
                (0..line).for_each(|n| cutter.cross(n, line, &[]));
            }),
        ];
        found.iter().flatten().for_each(|(curve, at)| curves.cuts[*curve as usize].push(*at));
        curves
    }

    fn push(&mut self, shape: Shape, kind: Kind) -> u32 {
        self.all.push(Curve { shape, kind });
        self.cuts.push(Vec::new());
        self.all.len() as u32 - 1
    }

    /// The lines in which planes cross, and the edges of the window.
    fn add_lines(&mut self, [low, high]: [DVec2; 2]) {
        let planes = &self.solids.cuts;
        for (b, q) in (0..).zip(planes) {
            for (a, p) in (0..b).zip(planes) {
                if let Some(line) = p.plane.crossing(&q.plane) {
                    self.push(Shape::Line(line), Kind::Ridge([a, b]));
                }
            }
        }
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        for n in 0..4 {
            let [from, to] = [corners[n], corners[(n + 1) % 4]].map(|corner| {
                let (start, along) = self.solids.projection.ray(corner);
                start + along
            });
            let edge = self.push(Shape::Line(Line { from, along: to - from }), Kind::Edge);
            self.cuts[edge as usize] = vec![0.0, 1.0];
        }
    }

    /// The pieces of a curve, from each cut on to the next.
    pub(super) fn pieces(&self, curve: u32) -> Vec<[f64; 2]> {
        let mut cuts = self.cuts[curve as usize].clone();
        cuts.sort_by(f64::total_cmp);
        match self.all[curve as usize].shape {
            Shape::Circle(_) => {
                if cuts.is_empty() {
                    cuts.push(0.0);
                }
                cuts.push(cuts[0] + TAU);
            }
            // Beyond its edges nothing is seen.
            Shape::Line(_) if self.all[curve as usize].kind == Kind::Edge => cuts.retain(|at| (0.0..=1.0).contains(at)),
            Shape::Line(_) => {}
        }
        cuts.windows(2).map(|two| [two[0], two[1]]).filter(|[from, to]| to - from > 1e-13).collect()
    }
}

/// Curves that are cut, and the places.
struct Cutter<'a> {
    solids: &'a Solids,
    curves: &'a [Curve],
    found: Vec<(u32, f64)>,
}

impl Cutter<'_> {
    /// Whether a point of a curve is not on the far side of one of two balls that cross there.
    fn may_be_visible(&self, curve: u32, x: DVec3) -> bool {
        let Solids { balls, projection, .. } = self.solids;
        match self.curves[curve as usize].kind {
            Kind::Crossing(of) => of.iter().all(|n| balls[*n as usize].may_face(projection, x)),
            _ => true,
        }
    }

    /// Cuts a curve where it passes through a plane, and curves that pass through the same points.
    fn join(&mut self, curve: u32, plane: &Plane, others: &[u32]) {
        let shape = self.curves[curve as usize].shape;
        for at in shape.through(plane) {
            if self.may_be_visible(curve, shape.point(at)) {
                self.found.push((curve, at));
                others.iter().for_each(|other| self.cut_under(*other, shape.point(at)));
            }
        }
    }

    /// Cuts two curves where they cross in the image, but for crossings that are close to points where they touch: arithmetic may find
    /// two there, or none.
    fn cross(&mut self, a: u32, b: u32, touched: &[DVec3]) {
        let projection = self.solids.projection;
        let projection = &projection;
        let [one, other] = [a, b].map(|n| self.curves[n as usize]);
        let found = match (one.shape, other.shape, other.kind) {
            (Shape::Line(_), Shape::Circle(_), _) => return self.cross(b, a, touched),
            (_, Shape::Line(line), _) => one.shape.through(&Plane::of_rays(&line, projection)),
            (Shape::Circle(circle), _, Kind::Outline(n)) => circle.touching(&self.solids.balls[n as usize], projection),
            (Shape::Circle(circle), Shape::Circle(rim), Kind::Rim { plane, .. }) => {
                let cut = &self.solids.cuts[plane as usize];
                match cut.is_edge_on {
                    true => circle.through(&cut.plane),
                    false => circle.meeting(&rim, &cut.plane, projection),
                }
            }
            _ => Vec::new(),
        };
        for at in found {
            let x = one.shape.point(at);
            let is_close = |other: &DVec3| projection.place(*other).distance(projection.place(x)) < CLOSE;
            // What lies behind the circle in which two balls cross is hidden there.
            let is_behind = || {
                matches!((one.kind, other.kind), (Kind::Crossing(_), Kind::Outline(n)) if {
                    Circle::touched(&self.solids.balls[n as usize], x, projection).z < x.z
                })
            };
            if !touched.iter().any(is_close) && !is_behind() && self.may_be_visible(a, x) {
                self.found.push((a, at));
                self.cut_under(b, x);
            }
        }
    }

    /// Cuts a curve where a point is seen.
    fn cut_under(&mut self, curve: u32, x: DVec3) {
        let (projection, Curve { shape, kind }) = (&self.solids.projection, self.curves[curve as usize]);
        let found = match (shape, kind) {
            (Shape::Line(line), _) => vec![line.under(x, projection)],
            (Shape::Circle(circle), Kind::Outline(n)) => {
                vec![circle.angle(Circle::touched(&self.solids.balls[n as usize], x, projection))]
            }
            (Shape::Circle(circle), Kind::Rim { plane, .. }) => {
                let cut = &self.solids.cuts[plane as usize];
                match cut.is_edge_on {
                    true => circle.on_edge(x, &cut.plane, projection),
                    false => vec![circle.under(x, &cut.plane, projection)],
                }
            }
            (Shape::Circle(circle), _) => vec![circle.angle(x)],
        };
        self.found.extend(found.into_iter().filter(|at| at.is_finite()).map(|at| (curve, at)));
    }
}

/// The curves of balls, and the balls that share cells with each.
struct About<'a> {
    balls: &'a [Ball],
    planes: &'a [Cut],
    outline_of: Vec<u32>,
    rims_of: Vec<Vec<u32>>,
    neighbors: Vec<Vec<u32>>,
}

impl About<'_> {
    /// Cuts the circle in which two balls cross.
    fn cut_crossing(&self, n: u32, cutter: &mut Cutter<'_>) {
        let Self { balls, planes, outline_of, rims_of, neighbors } = self;
        let Curve { shape, kind: Kind::Crossing(of) } = cutter.curves[n as usize] else { return };
        let projection = &cutter.solids.projection;
        let deepest = shape.deepest();
        for k in of {
            let contour = Plane::of_contour(&balls[k as usize], &cutter.solids.projection);
            cutter.join(n, &contour, &[outline_of[k as usize]]);
            for &rim in &rims_of[k as usize] {
                if let Kind::Rim { plane, .. } = cutter.curves[rim as usize].kind {
                    cutter.join(n, &planes[plane as usize].plane, &[rim]);
                }
                cutter.cross(n, rim, &[]);
            }
        }
        let [a, b] = of.map(|k| &neighbors[k as usize]);
        for &k in a.iter().filter(|k| !of.contains(k) && b.binary_search(k).is_ok()) {
            let ball = &balls[k as usize];
            // Where all three surfaces face the eye; elsewhere the point is hidden.
            for at in shape.through(&Plane::between(&balls[of[0] as usize], ball)) {
                let x = shape.point(at);
                if ball.may_face(projection, x) && cutter.may_be_visible(n, x) {
                    cutter.found.push((n, at));
                }
            }
            if -ball.center.z - ball.radius < deepest {
                cutter.cross(n, outline_of[k as usize], &[]);
            }
            rims_of[k as usize].iter().for_each(|rim| cutter.cross(n, *rim, &[]));
        }
    }

    /// Cuts the circles in which planes cut a ball.
    fn cut_rims(&self, n: u32, cutter: &mut Cutter<'_>) {
        let Self { balls, planes, outline_of, rims_of, neighbors } = self;
        let projection = &cutter.solids.projection;
        for (k, &rim) in rims_of[n as usize].iter().enumerate() {
            let contour = Plane::of_contour(&balls[n as usize], projection);
            let shape = cutter.curves[rim as usize].shape;
            let ends: Vec<f64> = shape.through(&contour);
            for &at in &ends {
                cutter.found.push((rim, at));
                cutter.cut_under(outline_of[n as usize], shape.point(at));
            }
            for &other in &rims_of[n as usize][k + 1..] {
                if let Kind::Rim { plane, .. } = cutter.curves[other as usize].kind {
                    cutter.join(rim, &planes[plane as usize].plane, &[other]);
                }
                cutter.cross(rim, other, &[]);
            }
            for &b in &neighbors[n as usize] {
                cutter.join(rim, &Plane::between(&balls[n as usize], &balls[b as usize]), &[]);
                // Where an outline ends at a plane, one that is the same in the image may be seen.
                let is_touched = |x: &DVec3| balls[b as usize].is_touched(projection, projection.place(*x));
                let touched: Vec<DVec3> = ends.iter().map(|at| shape.point(*at)).filter(is_touched).collect();
                touched.iter().for_each(|x| cutter.cut_under(outline_of[b as usize], *x));
                cutter.cross(rim, outline_of[b as usize], &touched);
                rims_of[b as usize].iter().filter(|_| n < b).for_each(|other| cutter.cross(rim, *other, &[]));
            }
        }
    }
}
