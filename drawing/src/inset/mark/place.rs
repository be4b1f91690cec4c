//! The places of texts at the things that they name.

use super::super::Panels;
use super::super::line::Line;
use super::super::page::{Page, Panel};
use super::visible::{VisibleThing, VisibleThings};

/// A text is on its thing where the thing has this share of its pixels, of those that are looked at.
const ON_IT: f32 = 0.95;

/// The pixels of a text that are looked at: columns and rows of a grid.
const GRID: [i64; 2] = [16, 6];

/// The cost of a text beside its thing, of one with a line, and of a line as long as the shorter side of the picture. A text
/// on another thing costs 1. A text beside its thing costs a little more in each next direction.
const ADJACENT: f32 = 0.03;
const NEXT: f32 = 1e-3;
const WITH_LINE: f32 = 0.12;
const LONG_LINE: f32 = 0.45;

/// The cost of a line that crosses another one, or leads along it.
const CROSSED: f32 = 0.5;

/// The cost of a line that leads over other things all the way.
const OVER: f32 = 0.6;

/// The cost of a text without a line that is as near to another thing, or, all of it, on spheres without a name: readers take these
/// for what it names.
const DOUBTFUL: f32 = 0.3;

/// The distance in heights of a text at which another thing, or a line, is near to it.
const NEAR: f64 = 0.4;

/// The places of a thing from which lines are tried.
const STARTS: usize = 3;

/// The directions of a text from its thing, in the order in which they are tried: right, above, below, left.
const DIRECTIONS: [[i64; 2]; 8] = [[1, 0], [1, -1], [1, 1], [-1, 0], [0, -1], [0, 1], [-1, -1], [-1, 1]];

/// The lengths of lines in heights of a text.
const LENGTHS: [f64; 9] = [0.8, 1.2, 1.7, 2.4, 3.4, 4.8, 6.7, 9.4, 13.0];

/// The target of a text.
pub(super) enum Target<'a> {
    /// A thing that some pixel shows.
    Visible(&'a VisibleThing),
    /// The place of a hidden thing.
    Hidden(Disc),
}

/// A disc around spheres: the column and the row of its middle, and half of its width.
pub(super) struct Disc {
    pub(super) at: [i64; 2],
    pub(super) reach: i64,
}

/// The place of a text: column and row of its top left corner, and a line from a pixel of its thing, or none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) at: [i64; 2],
    pub(super) line: Option<Line>,
}

/// A place and its cost.
type Choice = Option<(f32, Place)>;

impl Panels {
    /// The place of a text of this size: on its thing, beginning at a pixel of it, or at the end of a line from there. The text of a
    /// visible thing covers no pixel of another thing, and the fewest of spheres without a name. `None` where no place is free.
    pub(super) fn place(
        &self,
        page: &Page,
        visible: &VisibleThings,
        target: &Target<'_>,
        size: [i64; 2],
    ) -> Option<Place> {
        let mut best: Choice = None;
        let mut consider = |at: [i64; 2], line: Option<Line>, cost: f32| {
            if best.is_none_or(|(least, _)| cost < least) && self.is_free(page, at, size) {
                let thing = if let Target::Visible(thing) = target { Some(*thing) } else { None };
                let doubt = match line {
                    Some(line) => self.crossings(line, size[1]) + OVER * over(visible, thing, line),
                    None if cost > 0.0 => doubt(visible, thing, at, size),
                    // All of it is on its thing.
                    None => 0.0,
                };
                let cost = cost + covered(visible, thing, at, size) + doubt;
                let is_alone = || thing.is_none_or(|thing| visible.is_clear_of_others(thing, at, size));
                if best.is_none_or(|(least, _)| cost < least) && is_alone() {
                    best = Some((cost, Place { at, line }));
                }
            }
        };
        let [wide, high] = size;
        let starts = match target {
            Target::Visible(thing) => {
                for [x, y] in thing.places.iter().map(|place| place.map(|x| x as i64)) {
                    let at = [x - wide / 2, y - high / 2];
                    if shown(visible, thing, at, size) >= ON_IT {
                        consider(at, None, 0.0);
                    }
                }
                for place in &thing.places {
                    for (n, direction) in DIRECTIONS.into_iter().enumerate() {
                        let edge = visible.edge(thing, *place, direction);
                        consider(adjacent(edge, direction, size, 1), None, ADJACENT + NEXT * n as f32);
                    }
                }
                thing.places.iter().take(STARTS).map(|place| place.map(|x| x as i64)).collect()
            }
            Target::Hidden(Disc { at, reach }) => {
                let [x, y] = *at;
                if 2 * reach >= wide.max(high) {
                    consider([x - wide / 2, y - high / 2], None, 0.0);
                }
                for (n, [dx, dy]) in DIRECTIONS.into_iter().enumerate() {
                    // Diagonals begin at the edge of a disc.
                    let reach = if dx * dy == 0 { *reach } else { reach * 5 / 7 };
                    consider(
                        adjacent([x + dx * reach, y + dy * reach], [dx, dy], size, 1),
                        None,
                        ADJACENT + NEXT * n as f32,
                    );
                }
                vec![*at]
            }
        };
        let ways = LENGTHS.into_iter().flat_map(|length| around().map(move |direction| (length, direction)));
        for ((length, [dx, dy]), from) in ways.flat_map(|way| starts.iter().map(move |from| (way, *from))) {
            let away = length * high as f64 / ((dx * dx + dy * dy) as f64).sqrt();
            let end = [(dx, from[0]), (dy, from[1])].map(|(d, x)| x + (d as f64 * away).round() as i64);
            let at = adjacent(end, [dx, dy].map(i64::signum), size, 0);
            let to = [0, 1].map(|k| from[k].clamp(at[k], at[k] + size[k]));
            let line = Line { from, to };
            if self.is_clear(line) {
                let share = line.length() / page.width.min(page.height);
                consider(at, Some(line), WITH_LINE + LONG_LINE * share);
            }
        }
        best.map(|(_, place)| place)
    }

    /// Whether a rectangle lies in the picture, beside all panels and lines.
    fn is_free(&self, page: &Page, [left, top]: [i64; 2], [wide, high]: [i64; 2]) -> bool {
        let inside = left >= 0 && top >= 0 && left + wide <= page.width as i64 && top + high <= page.height as i64;
        let is_apart = |panel: &Panel| {
            let [x, y] = panel.at.map(|x| x as i64);
            let [w, h] = [panel.sheet.width(), panel.sheet.height()].map(i64::from);
            left >= x + w || x >= left + wide || top >= y + h || y >= top + high
        };
        let is_inside = |[x, y]: [i64; 2]| (left..left + wide).contains(&x) && (top..top + high).contains(&y);
        inside && self.panels.iter().all(is_apart) && !self.lines.iter().any(|(line, _)| line.points().any(is_inside))
    }

    /// Whether a line crosses no panel.
    fn is_clear(&self, line: Line) -> bool {
        let is_inside = |panel: &Panel, [x, y]: [i64; 2]| {
            let [left, top] = panel.at.map(|x| x as i64);
            let [w, h] = [panel.sheet.width(), panel.sheet.height()].map(i64::from);
            (left..left + w).contains(&x) && (top..top + h).contains(&y)
        };
        !self.panels.iter().any(|panel| line.points().any(|at| is_inside(panel, at)))
    }

    /// The cost of the lines that a line crosses, or comes near to with its dot or theirs, where a text has this height.
    fn crossings(&self, line: Line, high: i64) -> f32 {
        let near = (NEAR * high as f64) as f32;
        let touches = |one: &Line, other: &Line| one.distance(other.from) < near;
        let meets = |other: &Line| line.crosses(other) || touches(&line, other) || touches(other, &line);
        CROSSED * self.lines.iter().filter(|(other, _)| meets(other)).count() as f32
    }
}

/// The top left corner of a text that begins at a pixel in one of the [`DIRECTIONS`], so many pixels behind it.
fn adjacent([x, y]: [i64; 2], [dx, dy]: [i64; 2], [wide, high]: [i64; 2], behind: i64) -> [i64; 2] {
    let along = |at: i64, direction: i64, side: i64| match direction {
        1 => at + behind,
        0 => at - side / 2,
        _ => at - side - behind + 1,
    };
    [along(x, dx, wide), along(y, dy, high)]
}

/// Sixteen directions, two or three to each eighth of a turn.
fn around() -> impl Iterator<Item = [i64; 2]> {
    let far = (-2..=2_i64).flat_map(|x| (-2..=2_i64).map(move |y| [x, y]));
    far.filter(|[x, y]| x.abs().max(y.abs()) == 2)
}

/// The pixels of a text of this size that are looked at.
fn samples([left, top]: [i64; 2], [wide, high]: [i64; 2]) -> impl Iterator<Item = [i64; 2]> {
    let [columns, rows] = GRID;
    let place = move |n: i64, of: i64, side: i64| (2 * n + 1) * side / (2 * of);
    (0..columns).flat_map(move |column| {
        (0..rows).map(move |row| [left + place(column, columns, wide), top + place(row, rows, high)])
    })
}

/// The mean of what a text covers.
fn covered(visible: &VisibleThings, thing: Option<&VisibleThing>, at: [i64; 2], size: [i64; 2]) -> f32 {
    samples(at, size).map(|at| visible.covers(thing, at)).sum::<f32>() / (GRID[0] * GRID[1]) as f32
}

/// The share of a line's pixels that show other things.
fn over(visible: &VisibleThings, thing: Option<&VisibleThing>, line: Line) -> f32 {
    let (mut all, mut others) = (0.0, 0.0);
    for at in line.points() {
        all += 1.0;
        others += if visible.covers(thing, at) == 1.0 { 1.0 } else { 0.0 };
    }
    others / all
}

/// The cost of a text without a line that readers may take for the name of something else.
fn doubt(visible: &VisibleThings, thing: Option<&VisibleThing>, [left, top]: [i64; 2], [wide, high]: [i64; 2]) -> f32 {
    let near = (NEAR * high as f64).round() as i64;
    let around = samples([left - near, top - near], [wide + 2 * near, high + 2 * near]);
    let has_other = around.into_iter().any(|at| visible.covers(thing, at) == 1.0);
    let unnamed = samples([left, top], [wide, high]).filter(|at| visible.covers(thing, *at) == 0.5).count();
    DOUBTFUL * (if has_other { 1.0 } else { unnamed as f32 / (GRID[0] * GRID[1]) as f32 })
}

/// The share of a text's pixels that show its thing.
fn shown(visible: &VisibleThings, thing: &VisibleThing, at: [i64; 2], size: [i64; 2]) -> f32 {
    samples(at, size).filter(|at| visible.shows(thing, *at)).count() as f32 / (GRID[0] * GRID[1]) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_along_another_costs_as_much_as_one_across() {
        let line = |from: [i64; 2], to: [i64; 2]| Line { from, to };
        let page = Page::new(400, 300);
        let mut panels = Panels::default();
        panels.lines.extend(page.line_to(line([50, 50], [150, 150]), false));
        for (other, cost) in [
            (line([50, 150], [150, 50]), CROSSED),
            // In a row with it, two pixels apart, which reads as one line.
            (line([100, 104], [200, 204]), CROSSED),
            (line([0, 2], [36, 38]), 0.0),
            (line([0, 0], [47, 49]), CROSSED),
            (line([100, 130], [200, 230]), 0.0),
        ] {
            assert_eq!(panels.crossings(other, 20), cost, "{other:?}");
        }
    }
}
