//! Crops of the pictures at growing distance, one row per method, with wrong pixels marked.

use super::axis::rounded;
use super::canvas::{Drawing, MARGIN, WIDTH, drawing, frame, header, header_height, mark, text};
use super::cells::Cells;
use super::look::{Drawn, KINDS, QUIET, bold, centered, font, look};
use crate::record::{Crop, Record, Run};
use crate::total::{main_place, methods};
use crate::verdict::percent;
use plotters::prelude::*;

/// The colour where no sphere is shown.
const SKY: [u8; 3] = [0xdc, 0xe9, 0xf5];
/// Space for the methods' names, for the share below a crop, between crops, and for the rungs above them.
const NAMES: i32 = 236;
const SHARE: i32 = 44;
const GAP: i32 = 14;
const RUNGS: i32 = 80;
/// The most columns; more rungs are thinned out evenly, and the last one is kept.
const COLUMNS: usize = 10;

/// The crops of the main place.
pub(super) fn draw(record: &Record) -> Drawn<Drawing> {
    let place = place(record).ok_or("no crops")?;
    let runs: Vec<(&Run, &Crop)> = cropped(record).filter(|(run, _)| run.place == place).collect();
    let names = methods(runs.iter().map(|(run, _)| *run));
    let mut rungs: Vec<usize> = runs.iter().map(|(run, _)| run.scene).collect();
    rungs.sort_unstable();
    rungs.dedup();
    let (all, kept) = (rungs.len(), rungs.len().min(COLUMNS));
    let rungs: Vec<usize> = (0..kept).map(|i| rungs[((i + 1) * all).div_ceil(kept) - 1]).collect();
    let side = ((WIDTH - 2 * MARGIN - NAMES) / rungs.len() as i32 - GAP).min(300);
    let top = header_height(&[place]) + 10;
    let pitch = side + SHARE + GAP;
    let bottom = top + RUNGS + pitch * names.len() as i32;
    drawing([WIDTH, bottom + 80], |area| {
        header(area, record, "What each method shows", &[place], false)?;
        let mut over = Vec::new();
        let column = |rung: usize| MARGIN + NAMES + rung as i32 * (side + GAP);
        text(area, "distance / radius", &font(24).color(&QUIET), (MARGIN, top + 50))?;
        for (rung, scene) in rungs.iter().enumerate() {
            let scene = record.scenes.get(*scene);
            let words = scene.and_then(|scene| scene.farthest).map_or("\u{2013}".into(), rounded);
            text(area, &words, &centered(&font(26)), (column(rung) + side / 2, top + 50))?;
        }
        for (row, name) in names.iter().enumerate() {
            let y = top + RUNGS + pitch * row as i32;
            mark(area, &look(name), (MARGIN + 12, y + side / 2), 11, true)?;
            text(area, name, &bold(25), (MARGIN + 34, y + side / 2))?;
            for (rung, scene) in rungs.iter().enumerate() {
                let at = (column(rung), y);
                frame(area, at, (side, side))?;
                let found = runs.iter().find(|(run, _)| run.scene == *scene && run.method == *name);
                let words = match found {
                    None => "not run".into(),
                    Some((run, crop)) => {
                        over.push(picture(crop, at, side));
                        percent(run.errors.wrong_share())
                    }
                };
                let color = if found.is_some_and(|(run, _)| run.errors.wrong() > 0) {
                    RGBColor(0xb0, 0x30, 0x00)
                } else {
                    QUIET
                };
                text(area, &words, &centered(&font(23).color(&color)), (at.0 + side / 2, y + side + 22))?;
            }
        }
        let mut x = MARGIN + NAMES;
        for (_, name, [r, g, b]) in KINDS {
            area.draw(&Rectangle::new([(x, bottom + 16), (x + 26, bottom + 42)], RGBColor(r, g, b).filled()))?;
            text(area, name, &font(24), (x + 38, bottom + 29))?;
            x += 260;
        }
        text(area, "below each: wrong pixels of the whole picture", &font(24).color(&QUIET), (x, bottom + 29))?;
        Ok(over)
    })
}

/// The place whose crops are shown: the main one if it has any.
pub(super) fn place(record: &Record) -> Option<usize> {
    let main = main_place(record);
    let places = || cropped(record).map(|(run, _)| run.place);
    places().find(|place| Some(*place) == main).or_else(|| places().min())
}

/// Runs whose crop has its stated number of pixels; a record may come from anywhere.
fn cropped(record: &Record) -> impl Iterator<Item = (&Run, &Crop)> {
    record.runs.iter().filter_map(|run| {
        let crop = run.crop.as_ref()?;
        let pixels = crop.size[0] as usize * crop.size[1] as usize;
        let whole = pixels > 0 && crop.shade.len() == pixels && crop.verdict.len() == pixels;
        (whole && run.place < record.places.len()).then_some((run, crop))
    })
}

fn picture(crop: &Crop, (x, y): (i32, i32), side: i32) -> Cells {
    let [columns, rows] = crop.size.map(|side| side as usize);
    let (shade, verdict) = (crop.shade.as_bytes(), crop.verdict.as_bytes());
    let cell = f64::from(side) / columns.max(rows) as f64;
    let spare = |pixels: usize| (f64::from(side) - cell * pixels as f64) as i32 / 2;
    Cells::new((x + spare(columns), y + spare(rows)), cell, [columns, rows], |pixel| {
        if let Some((.., color)) = KINDS.iter().find(|(letter, ..)| *letter == char::from(verdict[pixel])) {
            return *color;
        }
        // A range of grey in which marked pixels remain visible.
        char::from(shade[pixel]).to_digit(16).map_or(SKY, |level| [0x38 + (level * 11) as u8; 3])
    })
}
