//! Visible parts as closed lines: curves are cut where they cross each other in the image, and of each piece the surfaces on both sides are
//! found.

use super::cells::Cells;
use super::circle::Projection;
use super::curves::{Curve, Curves, Kind, Shape};
use super::solids::{Question, Solids, Surface};
use glam::{DVec2, DVec3};
use halfline::parallel;
use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

/// A piece of a curve, from one angle or distance on to another, or back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) curve: u32,
    pub(super) from: f64,
    pub(super) to: f64,
}

/// A part of the picture that is one path: what is seen of a sphere, or of a face, or of several that are not told apart.
#[derive(Debug, Clone)]
pub(super) struct Region {
    /// The visible surface; of several the first.
    pub(super) surface: Surface,
    /// Closed lines; a point is inside that lies within an odd number of them.
    pub(super) lines: Vec<Vec<Piece>>,
}

/// The visible parts of solids.
pub(super) struct Regions {
    pub(super) curves: Vec<Curve>,
    pub(super) regions: Vec<Region>,
    /// Pieces where the depth jumps, and around faces.
    pub(super) jumps: Vec<Piece>,
    /// Ends of lines that were joined though nothing led from one to the other.
    pub(super) joined: usize,
}

/// The distance within which places are one, in units of the image.
const SAME: f64 = 1e-7;

/// The side of the cells in which places are looked up, in units of the image.
const CELL: f64 = 1e-3;

/// The longest part of a curve for which one place tells whether the depth jumps there.
const PART: f64 = 0.2;

/// The surfaces on the left and on the right of a piece, whichever way the second axis of the image goes.
type Sides = [Option<Surface>; 2];

/// A piece with the places of its ends, and what is on its sides.
struct Edge {
    piece: Piece,
    ends: [DVec2; 2],
    sides: Sides,
}

/// The way of a plane along the ray of a point on it.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// The ray comes from the removed side.
    Entered,
    Left,
    EdgeOn,
}

struct Scene<'a> {
    solids: &'a Solids,
    cells: Cells,
    window: [DVec2; 2],
}

impl Scene<'_> {
    fn way(&self, plane: u32, x: DVec3) -> Way {
        let cut = &self.solids.cuts[plane as usize];
        match cut.plane.normal.dot(self.solids.projection.way(x)) {
            _ if cut.is_edge_on => Way::EdgeOn,
            slope if slope < 0.0 => Way::Entered,
            _ => Way::Left,
        }
    }

    /// Whether a plane that is seen from its side keeps what is toward a direction of the image.
    fn is_kept_toward(&self, plane: u32, toward: DVec2) -> bool {
        let moved = (toward / self.solids.projection.scale).extend(0.0);
        self.solids.cuts[plane as usize].plane.normal.dot(moved) < 0.0
    }

    /// Two surfaces on the left and the right of a piece.
    fn sorted(is_left: bool, one: Option<Surface>, other: Option<Surface>) -> Option<Sides> {
        (one != other).then_some(if is_left { [one, other] } else { [other, one] })
    }

    /// The nearest surface at a place, or none, behind a point of a curve at a depth; `None` if one hides the point.
    fn beyond(&self, place: DVec2, near: f64, question: Question) -> Option<Option<Surface>> {
        let other = self.solids.nearest(self.cells.at(place), place, Question { near, ..question });
        (!other.is_some_and(|(depth, _)| depth < near)).then(|| other.map(|(_, surface)| surface))
    }

    /// The surfaces on the sides of a piece; `None` where it bounds nothing.
    fn sides(&self, curve: &Curve, piece: &Piece) -> Option<Sides> {
        let Self { solids, cells, window: [low, high] } = self;
        let projection = &solids.projection;
        let at = 0.5 * (piece.from + piece.to);
        let x = curve.shape.point(at);
        let (place, own) = (projection.place(x), -x.z);
        let left = curve.shape.tangent(projection, at).perp();
        let is_left = |of: DVec2| (of - place).dot(left) > 0.0;
        let ball = |n: u32| &solids.balls[n as usize];
        if curve.kind == Kind::Edge {
            let nearest = solids.nearest(cells.at(place), place, Question::default())?.1;
            return Self::sorted(is_left(0.5 * (*low + *high)), Some(nearest), None);
        }
        if place.cmplt(*low).any() || place.cmpgt(*high).any() {
            return None;
        }
        let is_there = |n: u32| !solids.is_cut[n as usize] || solids.keep(x, [u32::MAX; 2]);
        let beyond = |question: Question| self.beyond(place, own, question);
        match curve.kind {
            Kind::Edge => None,
            Kind::Outline(n) => {
                if !is_there(n) {
                    return None;
                }
                let other = beyond(Question { but: [n; 2], ..Question::default() })?;
                Self::sorted(is_left(projection.place(ball(n).center)), Some(Surface::of(n)), other)
            }
            Kind::Crossing(of) => {
                if !of.iter().all(|n| ball(*n).faces(projection, x) && is_there(*n)) {
                    return None;
                }
                beyond(Question { but: of, ..Question::default() })?;
                let rise = |n: u32| -projection.shift(x - ball(n).center, x, left / projection.scale).z;
                Self::sorted(rise(of[0]) < rise(of[1]), Some(Surface::of(of[0])), Some(Surface::of(of[1])))
            }
            Kind::Rim { ball: n, plane } => self.sides_of_rim(curve, [n, plane], x, left),
            Kind::Ridge(planes) => self.sides_of_ridge(planes, x, left),
        }
    }

    /// Adds the parts of a piece at which the depth jumps, and all of it beside a face.
    fn add_jumps(&self, edge: &Edge, curves: &[Curve], least: f64, parts: &mut Vec<Piece>) {
        let (Edge { piece, sides, .. }, Self { solids, cells, .. }) = (edge, self);
        let Curve { shape, kind } = &curves[piece.curve as usize];
        let has_face = sides.iter().flatten().any(|surface| surface.face.is_some());
        let but = match kind {
            _ if has_face && *kind != Kind::Edge => return parts.push(*piece),
            Kind::Outline(n) | Kind::Rim { ball: n, .. } => [*n; 2],
            _ => return,
        };
        let count = ((piece.to - piece.from) / PART).ceil().max(1.0);
        let step = (piece.to - piece.from) / count;
        for n in 0..count as u32 {
            let from = piece.from + f64::from(n) * step;
            let x = shape.point(from + 0.5 * step);
            let question = Question { but, near: -x.z, ..Question::default() };
            let place = solids.projection.place(x);
            let other = solids.nearest(cells.at(place), place, question);
            let gap = other.map_or(f64::INFINITY, |(depth, _)| depth + x.z);
            if gap > least * solids.projection.pixel(-x.z) {
                parts.push(Piece { from, to: from + step, ..*piece });
            }
        }
    }

    fn sides_of_rim(&self, curve: &Curve, [n, plane]: [u32; 2], x: DVec3, left: DVec2) -> Option<Sides> {
        let Self { solids, cells, .. } = self;
        let projection = &solids.projection;
        let (place, own) = (projection.place(x), -x.z);
        let (is_cut, is_entry) = (solids.is_cut[n as usize], solids.balls[n as usize].faces(projection, x));
        if !solids.keep(x, [plane; 2]) {
            return None;
        }
        let beyond = |on_edge: Option<(u32, bool)>| {
            self.beyond(place, own, Question { but: [n; 2], without: [plane; 2], on_edge, ..Question::default() })
        };
        match self.way(plane, x) {
            Way::EdgeOn if is_cut && is_entry => {
                beyond(Some((plane, true)))?;
                let other = beyond(Some((plane, false)))?;
                Self::sorted(self.is_kept_toward(plane, left), Some(Surface::of(n)), other)
            }
            Way::Left if is_cut && is_entry => {
                let other = beyond(None)?;
                let normal = x - solids.balls[n as usize].center;
                let moved = projection.shift(normal, x, left / projection.scale);
                let is_left = solids.cuts[plane as usize].plane.normal.dot(moved) < 0.0;
                Self::sorted(is_left, Some(Surface::of(n)), other)
            }
            Way::Entered => {
                let other = beyond(None)?;
                let owner = solids.owner(cells.at(place), x, n);
                let face = |sphere: u32| Some(Surface { sphere, face: Some(plane) });
                let Shape::Circle(circle) = curve.shape else { return None };
                let is_left = (projection.place(circle.center) - place).dot(left) > 0.0;
                if is_cut {
                    if owner.is_some_and(|owner| solids.is_before(owner, n)) {
                        return None;
                    }
                    let outside = if is_entry { Some(Surface::of(n)) } else { other };
                    return Self::sorted(is_left, face(n), owner.map_or(outside, face));
                }
                // A whole ball comes out of a face.
                let owner = owner.filter(|_| is_entry)?;
                Self::sorted(is_left, Some(Surface::of(n)), face(owner))
            }
            _ => None,
        }
    }

    fn sides_of_ridge(&self, planes: [u32; 2], x: DVec3, left: DVec2) -> Option<Sides> {
        let Self { solids, cells, .. } = self;
        let projection = &solids.projection;
        if !solids.keep(x, planes) {
            return None;
        }
        let (place, own) = (projection.place(x), -x.z);
        let owner = solids.owner(cells.at(place), x, u32::MAX)?;
        let beyond = |on_edge: Option<(u32, bool)>| {
            self.beyond(place, own, Question { without: planes, on_edge, ..Question::default() })
        };
        let other = beyond(None)?;
        let ways = planes.map(|plane| self.way(plane, x));
        let side = |toward: DVec2| {
            let rise = |n: usize| {
                let normal = solids.cuts[planes[n] as usize].plane.normal;
                -projection.shift(normal, x, toward / projection.scale).z
            };
            let face = |n: usize| Some(Surface { sphere: owner, face: Some(planes[n]) });
            match ways {
                [Way::Entered, Way::Entered] => face(usize::from(rise(1) > rise(0))),
                [Way::Entered, Way::Left] => {
                    if rise(0) < rise(1) {
                        face(0)
                    } else {
                        other
                    }
                }
                [Way::Left, Way::Entered] => {
                    if rise(1) < rise(0) {
                        face(1)
                    } else {
                        other
                    }
                }
                [Way::Entered, Way::EdgeOn] if self.is_kept_toward(planes[1], toward) => face(0),
                [Way::EdgeOn, Way::Entered] if self.is_kept_toward(planes[0], toward) => face(1),
                [Way::Entered, Way::EdgeOn] => beyond(Some((planes[1], false))).flatten(),
                [Way::EdgeOn, Way::Entered] => beyond(Some((planes[0], false))).flatten(),
                _ => other,
            }
        };
        let [one, two] = [side(left), side(-left)];
        (one != two).then_some([one, two])
    }
}

/// Places that are one within [`SAME`].
#[derive(Default)]
struct Places {
    all: Vec<DVec2>,
    by_cell: HashMap<[i64; 2], Vec<u32>>,
}

impl Places {
    fn number(&mut self, place: DVec2) -> u32 {
        let cell = [place.x, place.y].map(|x| (x / CELL).floor() as i64);
        // Mostly one cell.
        let [columns, rows] =
            [place.x, place.y].map(|x| [x - SAME, x + SAME].map(|x| (x / CELL).floor() as i64)).map(|[a, b]| a..=b);
        for (column, row) in columns.flat_map(|column| rows.clone().map(move |row| (column, row))) {
            let near = self.by_cell.get(&[column, row]).into_iter().flatten();
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
    /// The visible parts of solids within a window of the image. Surfaces of one key are one region. `jump` is the gap in depth, in pixels,
    /// above which there is a jump; without one none is looked for.
    pub(super) fn of(solids: &Solids, window: [DVec2; 2], jump: Option<f64>, key: impl Fn(Surface) -> Surface) -> Self {
        let cells = Cells::new(solids, window);
        let curves = Curves::new(solids, &cells, window);
        let scene = Scene { solids, cells, window };
        let edges = parallel::collect(curves.all.len(), 64, &|range, edges: &mut Vec<Edge>| {
            for n in range {
                let curve = &curves.all[n];
                let mut last: Option<(Piece, Sides)> = None;
                let mut add = |(piece, sides): (Piece, Sides)| {
                    let ends = [piece.from, piece.to].map(|at| solids.projection.place(curve.shape.point(at)));
                    edges.push(Edge { piece, ends, sides });
                };
                for [from, to] in curves.pieces(n as u32) {
                    let piece = Piece { curve: n as u32, from, to };
                    let Some(sides) = scene.sides(curve, &piece) else { continue };
                    match &mut last {
                        Some((before, known)) if before.to == from && *known == sides => before.to = to,
                        _ => last.replace((piece, sides)).into_iter().for_each(&mut add),
                    }
                }
                last.into_iter().for_each(add);
            }
        });
        let jumps = jump.map(|least| {
            let parts = parallel::collect(edges.len(), 64, &|range, parts: &mut Vec<Piece>| {
                edges[range].iter().for_each(|edge| scene.add_jumps(edge, &curves.all, least, parts));
            });
            merged(parts, &curves.all, false)
        });
        let (regions, joined) = lines(&edges, &curves.all, key);
        Self { curves: curves.all, regions, jumps: jumps.unwrap_or_default(), joined }
    }
}

/// The closed lines of each region.
fn lines(edges: &[Edge], curves: &[Curve], key: impl Fn(Surface) -> Surface) -> (Vec<Region>, usize) {
    let mut own: HashMap<Surface, Vec<(Piece, [u32; 2])>> = HashMap::new();
    let mut places = Places::default();
    for Edge { piece, ends, sides } in edges {
        let sides = sides.map(|side| side.map(&key));
        if sides[0] == sides[1] {
            continue;
        }
        let [a, b] = ends.map(|end| places.number(end));
        let is_point = a == b && (piece.to - piece.from < 1.0 || matches!(shape(curves, piece), Shape::Line(_)));
        if is_point {
            continue;
        }
        if let Some(left) = sides[0] {
            own.entry(left).or_default().push((*piece, [a, b]));
        }
        if let Some(right) = sides[1] {
            own.entry(right).or_default().push((Piece { from: piece.to, to: piece.from, ..*piece }, [b, a]));
        }
    }
    let (mut regions, mut joined) = (Vec::new(), 0);
    let mut all: Vec<_> = own.into_iter().collect();
    all.sort_unstable_by_key(|(surface, _)| *surface);
    for (surface, pieces) in all {
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
            lines.push(merged(line, curves, true));
        }
        regions.push(Region { surface, lines });
    }
    (regions, joined)
}

fn shape<'a>(curves: &'a [Curve], piece: &Piece) -> &'a Shape {
    &curves[piece.curve as usize].shape
}

/// A line, in which pieces of a curve that follow each other are one.
fn merged(line: Vec<Piece>, curves: &[Curve], is_closed: bool) -> Vec<Piece> {
    let follows = |a: &Piece, b: &Piece| {
        let gap = match shape(curves, a) {
            Shape::Circle(_) => (a.to - b.from).rem_euclid(TAU),
            Shape::Line(_) => (a.to - b.from).abs(),
        };
        a.curve == b.curve && (a.to > a.from) == (b.to > b.from) && gap.min((TAU - gap).abs()) < 1e-9
    };
    let mut all: Vec<Piece> = Vec::new();
    for piece in line {
        match all.last_mut() {
            Some(last) if follows(last, &piece) => last.to += piece.to - piece.from,
            _ => all.push(piece),
        }
    }
    if is_closed && all.len() > 1 && follows(&all[all.len() - 1], &all[0]) {
        let last = all.pop().unwrap_or(all[0]);
        all[0].from -= last.to - last.from;
    }
    all
}

impl Region {
    /// The corners of the box around the ends and the middles of its pieces.
    pub(super) fn bounds(&self, curves: &[Curve], projection: &Projection) -> [DVec2; 2] {
        let pieces = self.lines.iter().flatten();
        let places = pieces.flat_map(|piece| {
            [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| {
                let at = piece.from + share * (piece.to - piece.from);
                projection.place(shape(curves, piece).point(at))
            })
        });
        places.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], place| [low.min(place), high.max(place)])
    }
}
