//! Maps of the errors over the image, one per method, on a common scale.

use super::axis::{Unit, number, rounded};
use super::canvas::{Area, Drawing, MARGIN, WIDTH, drawing, frame, header, header_height, shortened, text};
use super::cells::Cells;
use super::look::{Drawn, INK, QUIET, bold, centered, font};
use crate::record::{Map, Record, Run};
use crate::total::main_place;
use crate::verdict::percent;
use plotters::prelude::*;

/// The colour of a cell with a wrong pixel: its distance from all of viridis is 22 or more in CIELAB, for all kinds of
/// colour vision modelled by Machado, Oliveira and Fernandes (IEEE TVCG 15, 2009).
const WRONG: [u8; 3] = [0xff, 0x2d, 0x00];
/// A cell without an error, or without a hit.
const NONE: [u8; 3] = [0xe8, 0xe8, 0xe8];
/// The most cells along a side; larger maps are reduced.
const CELLS: u32 = 256;
/// The most decades of the scale, so that f64 does not make the other methods look alike.
const DECADES: f64 = 8.0;
/// Space between the maps, and for the text above each.
const GAP: i32 = 30;
const WORDS: i32 = 74;
/// Space for the scale.
const SCALE: i32 = 190;

/// Decades of the scale.
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    fn of(maps: &[Map]) -> Self {
        let logs = maps.iter().flat_map(|map| &map.error).filter(|e| **e > 0.0 && e.is_finite());
        let (low, high) = logs
            .map(|e| f64::from(*e).log10())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        if low > high {
            return Self { low: -8.0, high: 0.0 };
        }
        let high = high.ceil();
        Self { low: low.floor().clamp(high - DECADES, high - 1.0), high }
    }

    /// viridis of van der Walt and Smith (SciPy 2015): perceptually uniform, also for colour-blind readers and in grey.
    fn color(&self, decade: f64) -> [u8; 3] {
        let share = (decade - self.low) / (self.high - self.low);
        // Finer steps would not be visible and only make the file longer.
        let step = (share.clamp(0.0, 1.0) * 48.0).round() / 48.0;
        let colorous::Color { r, g, b } = colorous::VIRIDIS.eval_continuous(step);
        [r, g, b]
    }
}

/// The maps of the first place that has maps.
pub(super) fn draw(record: &Record) -> Drawn<Drawing> {
    let place = place(record).ok_or("no maps")?;
    let runs: Vec<(&Run, Map)> = record
        .runs
        .iter()
        .filter(|run| run.place == place)
        .filter_map(|run| Some((run, coarse(run.map.as_ref().filter(|map| is_whole(map))?))))
        .collect();
    let maps: Vec<Map> = runs.iter().map(|(_, map)| map.clone()).collect();
    let scale = Scale::of(&maps);
    let [wide, high] = maps.first().map_or([1, 1], |map| map.size);
    // The number of columns that gives the largest maps on a page no higher than wide.
    let columns = (1..=maps.len().min(5))
        .max_by_key(|columns| {
            let side = (WIDTH - 2 * MARGIN - SCALE) / *columns as i32 - GAP;
            let rows = maps.len().div_ceil(*columns) as i32;
            let tall = rows * (side * high as i32 / wide.max(1) as i32 + WORDS + GAP);
            if tall <= WIDTH * 7 / 10 { side } else { -tall }
        })
        .unwrap_or(1);
    let width = (WIDTH - 2 * MARGIN - SCALE) / columns as i32 - GAP;
    let height = (width * high as i32 / wide.max(1) as i32).max(1);
    let top = header_height(&[place]) + 20;
    let pitch = height + WORDS + GAP;
    let rows = maps.len().div_ceil(columns) as i32;
    drawing([WIDTH, top + (rows * pitch).max(460) + 90], |area| {
        header(area, record, "Error of the hit distance t over the image", &[place], false)?;
        let mut over = Vec::new();
        for (index, (run, map)) in runs.iter().enumerate() {
            let x = MARGIN + (index % columns) as i32 * (width + GAP);
            let y = top + (index / columns) as i32 * pitch;
            let most = run.errors.relative.max.map_or("unbounded".into(), rounded);
            text(area, &run.method, &bold(28), (x, y + 14))?;
            let words = format!("{} wrong, up to {most}", percent(run.errors.wrong_share()));
            text(area, &shortened(&words, (width / 13) as usize), &font(22).color(&QUIET), (x, y + 48))?;
            let at = (x, y + WORDS);
            frame(area, at, (width, height))?;
            let [columns, rows] = map.size.map(|side| side as usize);
            over.push(Cells::new(at, f64::from(width) / columns as f64, [columns, rows], |cell| {
                match (map.wrong[cell], map.error[cell]) {
                    (0, error) if error > 0.0 => scale.color(f64::from(error).log10()),
                    (0, _) => NONE,
                    _ => WRONG,
                }
            }));
        }
        over.push(bar(area, &scale, top + WORDS, ((rows * pitch).max(460) - WORDS - GAP).min(900))?);
        let y = top + (rows * pitch).max(460) + 24;
        let mut x = MARGIN;
        for (color, words) in [(WRONG, "a wrong pixel in the cell"), (NONE, "nothing hit, or no error at all")] {
            let [r, g, b] = color;
            area.draw(&Rectangle::new([(x, y - 13), (x + 26, y + 13)], RGBColor(r, g, b).filled()))?;
            text(area, words, &font(24), (x + 38, y))?;
            x += 480;
        }
        let cell = runs.first().map_or(1, |(_, map)| map.cell);
        let words = format!("a cell: {cell} \u{d7} {cell} pixels, its largest error");
        text(area, &words, &font(24).color(&QUIET), (x, y))?;
        Ok(over)
    })
}

/// The main place if it has maps, else the first that has.
pub(super) fn place(record: &Record) -> Option<usize> {
    let has =
        |place: &usize| record.runs.iter().any(|run| run.place == *place && run.map.as_ref().is_some_and(is_whole));
    main_place(record).filter(has).or_else(|| (0..record.places.len()).find(has))
}

/// Whether a map has its stated number of cells; a record may come from anywhere.
fn is_whole(map: &Map) -> bool {
    let cells = map.size[0] as usize * map.size[1] as usize;
    cells > 0 && map.error.len() == cells && map.wrong.len() == cells
}

/// The map reduced to at most [`CELLS`] cells per side: the largest error, all wrong pixels.
fn coarse(map: &Map) -> Map {
    let factor = map.size[0].max(map.size[1]).div_ceil(CELLS);
    let [columns, rows] = map.size.map(|side| side.div_ceil(factor));
    let count = columns as usize * rows as usize;
    let mut coarse =
        Map { cell: map.cell * factor, size: [columns, rows], error: vec![0.0; count], wrong: vec![0; count] };
    for (index, (error, wrong)) in map.error.iter().zip(&map.wrong).enumerate() {
        let (row, column) = (index as u32 / map.size[0], index as u32 % map.size[0]);
        let cell = (row / factor * columns + column / factor) as usize;
        coarse.error[cell] = coarse.error[cell].max(*error);
        coarse.wrong[cell] += wrong;
    }
    coarse
}

/// The scale of colours at the right edge.
fn bar(area: &Area<'_>, scale: &Scale, top: i32, height: i32) -> Drawn<Cells> {
    let (x, steps) = (WIDTH - MARGIN - 120, 96usize);
    let side = f64::from(height) / steps as f64;
    let decades = scale.high - scale.low;
    // One column of cells, widened by repeating it.
    let columns = (34.0 / side).ceil().max(1.0) as usize;
    let cells = Cells::new((x, top), side, [columns, steps], |cell| {
        scale.color(scale.high - decades * ((cell / columns) as f64 + 0.5) / steps as f64)
    });
    let right = x + (columns as f64 * side) as i32;
    let stride = (decades / 10.0).ceil() as i32;
    for decade in (scale.low as i32..=scale.high as i32).filter(|decade| decade.rem_euclid(stride) == 0) {
        let y = top + ((scale.high - f64::from(decade)) / decades * f64::from(height)) as i32;
        area.draw(&PathElement::new(vec![(right, y), (right + 8, y)], INK.stroke_width(2)))?;
        let least = if decade == scale.low as i32 { "\u{2264} " } else { "" };
        text(area, &format!("{least}{}", number(1, decade, Unit::Plain)), &font(24), (right + 14, y))?;
    }
    let turned = centered(&font(24)).transform(FontTransform::Rotate270);
    text(area, "largest |t \u{2212} t*| / t* in a cell", &turned, (x - 24, top + height / 2))?;
    Ok(cells)
}
