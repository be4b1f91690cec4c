//! Parts of a frame become the frame: samples are copied as they are stored, so the file of the whole is byte for byte the
//! one that rendering it whole would have written.

use super::format::Format;
use super::sheet::{Layer, Sheet};
use crate::error::{Error, Place, Result};
use crate::window::Window;
use std::collections::HashMap;

/// A part of a frame and what errors call it.
#[derive(Debug, Clone)]
pub struct Tile {
    /// The file's name.
    pub name: String,
    /// Its format.
    pub format: Format,
    /// Its content.
    pub sheet: Sheet<'static>,
}

/// Puts `tiles` together: every pixel of the full frame exactly once.
///
/// # Errors
/// [`Error::Scene`] at the tile that is foreign to most of the others (another scene, size, setting, adapter, driver or
/// program) or overlaps another, and with the rectangles that no tile holds. [`Error::Settings`] where there is no tile.
pub fn merge(tiles: &[Tile]) -> Result<(Format, Sheet<'static>)> {
    let Some(common) = most_common(tiles) else {
        return Err(Error::settings("there is no tile to merge", "name the files that hold the parts of a frame"));
    };
    tiles.iter().try_for_each(|tile| belongs(tile, common))?;
    overlap(tiles)?;
    let [width, height] = common.sheet.full;
    let full = Window::full(width, height);
    let missing = missing(full, tiles.iter().map(|tile| tile.sheet.window));
    if !missing.is_empty() {
        let pixels: u64 = missing.iter().map(area).sum();
        let mut named: Vec<_> = missing.iter().take(MOST).map(ToString::to_string).collect();
        if missing.len() > MOST {
            named.push(format!("{} more", missing.len() - MOST));
        }
        let problem = format!("none holds {} of {width} x {height} pixels ({pixels} pixels)", named.join(" and "));
        let mend = "render each missing part with --crop x0,y0,x1,y1 and name it too";
        return Err(Error::scene(Place::file(format!("{} tiles", tiles.len())), problem, mend));
    }
    let provenance = common.sheet.provenance.clone().of_window(full);
    let layers = (0..common.sheet.layers.len()).map(|n| layer(tiles, n, full)).collect();
    let sheet = Sheet { layers, provenance, window: full, full: common.sheet.full };
    Ok((common.format, sheet))
}

/// More rectangles than this are counted, not named.
const MOST: usize = 8;

/// A tile of the rendering that most tiles are of, the first of it; where two renderings are as common, of the first.
fn most_common(tiles: &[Tile]) -> Option<&Tile> {
    let mut counts: HashMap<_, usize> = HashMap::new();
    let renderings: Vec<_> =
        tiles.iter().map(|tile| (tile.format, tile.sheet.provenance.clone().of_window(Window::full(0, 0)))).collect();
    renderings.iter().for_each(|rendering| *counts.entry(rendering).or_default() += 1);
    // Of equal ones the last is taken, so they are asked backwards.
    tiles.iter().zip(&renderings).rev().max_by_key(|(_, rendering)| counts[rendering]).map(|(tile, _)| tile)
}

fn belongs(tile: &Tile, common: &Tile) -> Result<()> {
    let other = &common.name;
    let foreign = |what: String| Err(Error::scene(Place::file(&tile.name), what, "merge tiles of one rendering only"));
    if tile.format != common.format {
        let [this, that] = [tile.format, common.format].map(Format::ending);
        return foreign(format!("a tile in {this} among tiles in {that}"));
    }
    if let Some([key, this, that]) = tile.sheet.provenance.foreign(&common.sheet.provenance) {
        return foreign(format!("a tile of another rendering: {key} is {this:?}, but {that:?} in {other}"));
    }
    let form = |layer: &Layer<'_>| (layer.aov, layer.kind, layer.channels);
    if !tile.sheet.layers.iter().map(form).eq(common.sheet.layers.iter().map(form)) {
        return foreign(format!("its samples are of another type than those of {other}"));
    }
    Ok(())
}

fn overlap(tiles: &[Tile]) -> Result<()> {
    for (n, tile) in tiles.iter().enumerate() {
        let this = tile.sheet.window;
        for other in &tiles[..n] {
            if let Some(both) = common(this, other.sheet.window) {
                let problem = format!("the tile holds {both}, which {} holds already", other.name);
                return Err(Error::scene(Place::file(&tile.name), problem, "leave one of the two out"));
            }
        }
    }
    Ok(())
}

/// The pixels of both.
fn common(a: Window, b: Window) -> Option<Window> {
    let [x0, y0, x1, y1] = [a.x0.max(b.x0), a.y0.max(b.y0), a.x1.min(b.x1), a.y1.min(b.y1)];
    (x0 < x1 && y0 < y1).then_some(Window { x0, y0, x1, y1 })
}

fn area(window: &Window) -> u64 {
    u64::from(window.width()) * u64::from(window.height())
}

/// The pixels of `full` that none of `windows` holds, as few rectangles.
fn missing(full: Window, windows: impl Iterator<Item = Window>) -> Vec<Window> {
    let mut rest = vec![full];
    for window in windows {
        rest = rest.into_iter().flat_map(|part| without(part, window)).collect();
    }
    loop {
        let before = rest.len();
        rest.sort_by_key(|part| (part.y0, part.y1, part.x0));
        rest.dedup_by(|next, part| {
            let beside = part.x1 == next.x0 && (part.y0, part.y1) == (next.y0, next.y1);
            if beside {
                part.x1 = next.x1;
            }
            beside
        });
        rest.sort_by_key(|part| (part.x0, part.x1, part.y0));
        rest.dedup_by(|next, part| {
            let below = part.y1 == next.y0 && (part.x0, part.x1) == (next.x0, next.x1);
            if below {
                part.y1 = next.y1;
            }
            below
        });
        if rest.len() == before {
            break;
        }
    }
    rest.sort_by_key(|part| (part.y0, part.x0));
    rest
}

/// What is left of `part`: above, below, left and right.
fn without(part: Window, window: Window) -> Vec<Window> {
    let Some(hole) = common(part, window) else { return vec![part] };
    let around = [
        Window { y1: hole.y0, ..part },
        Window { y0: hole.y1, ..part },
        Window { x1: hole.x0, y0: hole.y0, y1: hole.y1, ..part },
        Window { x0: hole.x1, y0: hole.y0, y1: hole.y1, ..part },
    ];
    around.into_iter().filter(|left| left.x0 < left.x1 && left.y0 < left.y1).collect()
}

/// Layer `n` of all tiles.
fn layer(tiles: &[Tile], n: usize, full: Window) -> Layer<'static> {
    let Layer { aov, kind, channels, .. } = tiles[0].sheet.layers[n];
    let pixel = kind.size() * channels;
    let mut bytes = vec![0; area(&full) as usize * pixel];
    for tile in tiles {
        let window = tile.sheet.window;
        let row = window.width() as usize * pixel;
        for (source, y) in tile.sheet.layers[n].bytes.chunks_exact(row).zip(window.y0..) {
            let place = (y as usize * full.x1 as usize + window.x0 as usize) * pixel;
            bytes[place..place + row].copy_from_slice(source);
        }
    }
    Layer { aov, kind, channels, bytes: bytes.into() }
}
