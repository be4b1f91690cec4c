//! The visible part of every ball, as closed lines of arcs: the outlines of balls and the circles where two meet are cut where they cross
//! each other in the image, and of each piece the balls on both sides are found.

use super::cells::Cells;
use super::circle::{Ball, Circle, Plane, Projection};
use glam::DVec2;
use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

/// A circle with what it bounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    pub(super) circle: Circle,
    /// The ball that it outlines, or the two that meet.
    pub(super) of: [u32; 2],
}

impl Curve {
    fn is_outline(&self) -> bool {
        self.of[0] == self.of[1]
    }
}

/// A piece of a curve, from one angle on to another, or back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) curve: u32,
    pub(super) from: f64,
    pub(super) to: f64,
}

/// The visible part of a ball.
#[derive(Debug, Clone)]
pub struct Region {
    /// The id of its sphere.
    pub sphere: u32,
    /// Closed lines; a point is inside that lies within an odd number of them.
    pub(super) lines: Vec<Vec<Piece>>,
}

/// The visible parts of balls.
pub(super) struct Regions {
    pub(super) curves: Vec<Curve>,
    pub(super) regions: Vec<Region>,
    /// Ends of lines that were joined though nothing led from one to the other.
    pub(super) joined: usize,
}

/// The distance within which places are one, in units of the image.
const SAME: f64 = 1e-7;

struct Scene<'a> {
    balls: &'a [Ball],
    projection: &'a Projection,
    cells: Cells,
}

/// A piece with its ends, and the balls on the left and on the right.
struct Edge {
    piece: Piece,
    ends: [u32; 2],
    sides: [Option<u32>; 2],
}

impl Scene<'_> {
    /// The nearest ball at a place but for two, with its depth; among balls that are nearer than `near` also one that its ray only touches.
    fn nearest(&self, place: DVec2, but: [u32; 2], near: f64) -> Option<(f64, u32)> {
        let others = self.cells.at(place).iter().filter(|n| !but.contains(n));
        let depth = |n: &u32| Some((self.balls[*n as usize].depth_within(self.projection, place, near)?, *n));
        others.filter_map(depth).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    /// The balls on the left and on the right of a piece, whichever way the second axis of the image goes; `None` where it bounds nothing.
    fn sides(&self, curve: &Curve, piece: &Piece) -> Option<[Option<u32>; 2]> {
        let angle = 0.5 * (piece.from + piece.to);
        let x = curve.circle.point(angle);
        let (place, own) = (self.projection.place(x), -x.z);
        let [a, b] = curve.of.map(|n| &self.balls[n as usize]);
        if !curve.is_outline() && ![a, b].iter().all(|ball| ball.faces(self.projection, x)) {
            return None;
        }
        let other = self.nearest(place, curve.of, own);
        if other.is_some_and(|(depth, _)| depth < own) {
            return None;
        }
        let left = curve.circle.tangent(self.projection, angle).perp();
        let (one, two) = if curve.is_outline() {
            // The ball lies on the side of its centre.
            let inward = self.projection.place(a.center) - place;
            (inward.dot(left) > 0.0, other.map(|(_, n)| n))
        } else {
            let rise = |ball: &Ball| ball.rise(self.projection, x, left / self.projection.scale);
            (rise(a) < rise(b), Some(curve.of[1]))
        };
        Some(if one { [Some(curve.of[0]), two] } else { [two, Some(curve.of[0])] })
    }
}

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

/// Places that are one within [`SAME`].
#[derive(Default)]
struct Places {
    all: Vec<DVec2>,
    by_cell: HashMap<[i64; 2], Vec<u32>>,
}

impl Places {
    fn number(&mut self, place: DVec2) -> u32 {
        let cell = [place.x, place.y].map(|x| (x / SAME).floor() as i64);
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            let near = self.by_cell.get(&[cell[0] + dx, cell[1] + dy]).into_iter().flatten();
            if let Some(known) = near.copied().find(|n| self.all[*n as usize].distance(place) < SAME) {
                return known;
            }
        }
        self.all.push(place);
        let n = self.all.len() as u32 - 1;
        self.by_cell.entry(cell).or_default().push(n);
        n
    }
}

impl Regions {
    /// The visible parts of balls in an image of this size; balls that are not in front of the eye are left out.
    pub(super) fn of(balls: &[Ball], projection: &Projection, size: DVec2) -> Self {
        let scene = Scene { balls, projection, cells: Cells::new(balls, projection, size) };
        let pairs = pairs(&scene.cells);
        let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); balls.len()];
        for [a, b] in &pairs {
            neighbors[*a as usize].push(*b);
            neighbors[*b as usize].push(*a);
        }
        let mut listed: Vec<u32> = scene.cells.all().flatten().copied().collect();
        listed.sort_unstable();
        listed.dedup();
        let ball = |n: u32| &balls[n as usize];
        let mut outline_of = vec![u32::MAX; balls.len()];
        let mut curves: Vec<Curve> = Vec::new();
        for &n in &listed {
            outline_of[n as usize] = curves.len() as u32;
            curves.push(Curve { circle: ball(n).contour(projection), of: [n; 2] });
        }
        let outlines = curves.len();
        curves
            .extend(pairs.iter().filter_map(|of| Some(Curve { circle: ball(of[0]).crossing(ball(of[1]))?, of: *of })));
        let mut cuts: Vec<Vec<f64>> = vec![Vec::new(); curves.len()];
        for [a, b] in &pairs {
            let [one, other] = [a, b].map(|n| outline_of[*n as usize]);
            let circle = curves[one as usize].circle;
            for angle in circle.touching(ball(*b), projection) {
                let touched = Circle::touched(ball(*b), circle.point(angle), projection);
                cuts[one as usize].push(angle);
                cuts[other as usize].push(curves[other as usize].circle.angle(touched));
            }
        }
        for n in outlines..curves.len() {
            let Curve { circle, of } = curves[n];
            for k in of {
                for angle in circle.through(&Plane::of_contour(ball(k), projection)) {
                    cuts[n].push(angle);
                    let outline = outline_of[k as usize] as usize;
                    cuts[outline].push(curves[outline].circle.angle(circle.point(angle)));
                }
            }
            let [a, b] = of.map(|k| &neighbors[k as usize]);
            for &k in a.iter().filter(|k| !of.contains(k) && b.contains(k)) {
                cuts[n].extend(circle.through(&Plane::between(ball(of[0]), ball(k))));
                for angle in circle.touching(ball(k), projection) {
                    cuts[n].push(angle);
                    let touched = Circle::touched(ball(k), circle.point(angle), projection);
                    let outline = outline_of[k as usize] as usize;
                    cuts[outline].push(curves[outline].circle.angle(touched));
                }
            }
        }
        let (mut places, mut edges) = (Places::default(), Vec::new());
        for (n, curve) in (0..).zip(&curves) {
            let angles = &mut cuts[n as usize];
            angles.sort_by(f64::total_cmp);
            if angles.is_empty() {
                angles.push(0.0);
            }
            let count = angles.len();
            for (k, from) in angles.iter().enumerate() {
                let to = if k + 1 < count { angles[k + 1] } else { angles[0] + TAU };
                let piece = Piece { curve: n, from: *from, to };
                if to - from < 1e-13 {
                    continue;
                }
                let Some(sides) = scene.sides(curve, &piece) else { continue };
                let ends = [*from, to].map(|angle| places.number(projection.place(curve.circle.point(angle))));
                if ends[0] == ends[1] && to - from < 1.0 {
                    continue;
                }
                edges.push(Edge { piece, ends, sides });
            }
        }
        let (regions, joined) = lines(&edges);
        Self { curves, regions, joined }
    }
}

/// The closed lines of each ball.
fn lines(edges: &[Edge]) -> (Vec<Region>, usize) {
    let mut own: HashMap<u32, Vec<(Piece, [u32; 2])>> = HashMap::new();
    for Edge { piece, ends: [a, b], sides } in edges {
        if let Some(left) = sides[0] {
            own.entry(left).or_default().push((*piece, [*a, *b]));
        }
        if let Some(right) = sides[1] {
            own.entry(right).or_default().push((Piece { from: piece.to, to: piece.from, ..*piece }, [*b, *a]));
        }
    }
    let (mut regions, mut joined) = (Vec::new(), 0);
    let mut all: Vec<_> = own.into_iter().collect();
    all.sort_unstable_by_key(|(ball, _)| *ball);
    for (ball, pieces) in all {
        let mut from: HashMap<u32, Vec<usize>> = HashMap::new();
        pieces.iter().enumerate().for_each(|(n, (_, [a, _]))| from.entry(*a).or_default().push(n));
        let (mut is_taken, mut lines) = (vec![false; pieces.len()], Vec::new());
        // Lines that begin where none ends come first.
        let ends: HashSet<u32> = pieces.iter().map(|(_, [_, b])| *b).collect();
        let mut order: Vec<usize> = (0..pieces.len()).collect();
        order.sort_by_key(|n| ends.contains(&pieces[*n].1[0]));
        for start in order {
            if is_taken[start] {
                continue;
            }
            let (mut line, mut at) = (Vec::new(), start);
            loop {
                is_taken[at] = true;
                line.push(pieces[at].0);
                let end = pieces[at].1[1];
                if end == pieces[start].1[0] {
                    break;
                }
                match from.get(&end).into_iter().flatten().copied().find(|n| !is_taken[*n]) {
                    Some(next) => at = next,
                    None => {
                        joined += 1;
                        break;
                    }
                }
            }
            lines.push(merged(line));
        }
        regions.push(Region { sphere: ball, lines });
    }
    (regions, joined)
}

/// A closed line, in which pieces of a curve that follow each other are one.
fn merged(line: Vec<Piece>) -> Vec<Piece> {
    let follows = |a: &Piece, b: &Piece| {
        let gap = (a.to - b.from).rem_euclid(TAU);
        a.curve == b.curve && (a.to > a.from) == (b.to > b.from) && gap.min(TAU - gap) < 1e-9
    };
    let mut all: Vec<Piece> = Vec::new();
    for piece in line {
        match all.last_mut() {
            Some(last) if follows(last, &piece) => last.to += piece.to - piece.from,
            _ => all.push(piece),
        }
    }
    if all.len() > 1 && follows(&all[all.len() - 1], &all[0]) {
        let last = all.pop().unwrap_or(all[0]);
        all[0].from -= last.to - last.from;
    }
    all
}
