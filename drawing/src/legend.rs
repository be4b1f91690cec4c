//! The legend of colours: a bar from the minimum to the maximum, or a swatch for every category, under the name of the
//! coloured quantity.

use super::canvas::{Area, Drawing, Drawn, INK, bold, centered, drawing, font, plain, shortened, text};
use super::raster::{letters_width, missing, missing_letters};
use halfline::error::{Error, Result};
use halfline::frame::legend::{Legend, Tick};
use plotters::prelude::*;
use std::io;

/// Width of the picture; left, top, width and height of the bar in it.
const WIDTH: i32 = 960;
const BAR: [i32; 4] = [48, 60, 864, 44];

/// The number of strips of the bar, each of whole pixels.
const STRIPS: i32 = 216;

/// Side of a swatch, height of a row, distance between a swatch and its label, and between a label and the next swatch.
const SWATCH: i32 = 28;
const ROW: i32 = 44;
const GAPS: [i32; 2] = [12, 36];

/// The width of most letters of a label at most; the most letters of a label, and the most labels.
const LETTER: i32 = 16;
const LETTERS: usize = 41;
const LABELS: usize = 120;

/// Height of a label.
const SIZE: i32 = 24;

/// The legend as a picture.
///
/// # Errors
/// [`Error::Io`] if drawing fails.
pub fn draw(legend: &Legend) -> Result<Drawing> {
    let drawn = if legend.is_scale() { bar(legend) } else { rows(legend) };
    drawn.map_err(|error| Error::write("legend", io::Error::other(error)))
}

/// A warning about letters that the font lacks, which the pixels of [`draw`] show as boxes; `None` if it lacks none.
#[must_use]
pub fn warning(legend: &Legend) -> Option<String> {
    let labels = labels(legend).into_iter().flat_map(|label| missing(&plain(&label), false).collect::<Vec<_>>());
    missing_letters(&missing(&plain(&legend.heading()), true).chain(labels).collect())
}

fn title(legend: &Legend, area: &Area<'_>) -> Drawn {
    text(area, &legend.heading(), &bold(28), (BAR[0], 30))
}

/// The labels of the first categories.
fn labels(legend: &Legend) -> Vec<String> {
    legend.swatches().take(LABELS).map(|category| shortened(&category.label, LETTERS)).collect()
}

/// A swatch and a label for every category, in columns that fit the longest.
fn rows(legend: &Legend) -> Drawn<Drawing> {
    let top = BAR[1];
    drawing([WIDTH, top + height_of_swatches(legend) + 16], |area| {
        title(legend, area)?;
        draw_swatches(legend, area, top)?;
        Ok(Vec::new())
    })
}

/// The number of columns of swatches and the width of one; the rows.
fn columns(legend: &Legend) -> ([i32; 2], i32) {
    let labels = labels(legend);
    let longest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    let column = SWATCH + GAPS[0] + LETTER * longest as i32 + GAPS[1];
    let columns = ((BAR[2] + GAPS[1]) / column).max(1);
    ([columns, column], labels.len().div_ceil(columns as usize) as i32)
}

fn height_of_swatches(legend: &Legend) -> i32 {
    let is_cut = legend.swatches().count() > LABELS;
    ROW * (columns(legend).1 + i32::from(is_cut))
}

/// Draws the swatches below a row of pixels.
fn draw_swatches(legend: &Legend, area: &Area<'_>, top: i32) -> Drawn {
    let (left, labels, ([columns, column], rows)) = (BAR[0], labels(legend), columns(legend));
    for (n, (label, category)) in (0..).zip(labels.iter().zip(legend.swatches())) {
        let (x, y) = (left + column * (n % columns), top + ROW * (n / columns));
        let [red, green, blue] = category.color;
        let (right, bottom) = (x + SWATCH, y + SWATCH);
        area.draw(&Rectangle::new([(x, y), (right, bottom)], RGBColor(red, green, blue).filled()))?;
        // An outline, so that white is visible on white.
        let outline = vec![(x, y), (right, y), (right, bottom), (x, bottom), (x, y), (right, y)];
        area.draw(&PathElement::new(outline, RGBColor(0x80, 0x80, 0x80).stroke_width(2)))?;
        text(area, label, &font(SIZE), (right + GAPS[0], y + SWATCH / 2))?;
    }
    let more = legend.swatches().count() - labels.len();
    if more > 0 {
        text(area, &format!("and {more} more"), &font(SIZE), (left, top + ROW * rows + SWATCH / 2))?;
    }
    Ok(())
}

/// The colour map from one end to the other, with numbers under it, and swatches of selections below.
fn bar(legend: &Legend) -> Drawn<Drawing> {
    let [left, top, wide, high] = BAR;
    const BELOW: i32 = 168;
    drawing([WIDTH, BELOW + height_of_swatches(legend)], |area| {
        title(legend, area)?;
        for strip in 0..STRIPS {
            let [red, green, blue] = legend.map.srgb(f64::from(strip) / f64::from(STRIPS - 1));
            let edge = |strip| left + wide * strip / STRIPS;
            let corners = [(edge(strip), top), (edge(strip + 1), top + high)];
            area.draw(&Rectangle::new(corners, RGBColor(red, green, blue).filled()))?;
        }
        for Tick { place, label } in legend.ticks() {
            let (x, y) = (left + (f64::from(wide) * place).round() as i32, top + high);
            area.draw(&PathElement::new(vec![(x, y), (x, y + 8)], INK.stroke_width(2)))?;
            // A long number at an end stays within the picture.
            let half = (letters_width(&label, false, SIZE as f32) / 2.0).ceil() as i32;
            text(
                area,
                &label,
                &centered(&font(SIZE)),
                (x.clamp(half.min(WIDTH / 2), WIDTH - half.min(WIDTH / 2)), y + 30),
            )?;
        }
        draw_swatches(legend, area, BELOW)?;
        Ok(Vec::new())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::frame::color_map::ColorMap;
    use halfline::frame::legend::Category;

    fn texts(plot: &Drawing) -> Vec<String> {
        let document = roxmltree::Document::parse(&plot.svg).expect("SVG");
        let texts = document.descendants().filter(|node| node.is_text()).filter_map(|node| node.text());
        texts.map(str::trim).filter(|text| !text.is_empty()).map(str::to_owned).collect()
    }

    fn pixels(Drawing { size: [width, height], levels, .. }: Drawing) -> image::RgbImage {
        image::RgbImage::from_raw(width as u32, height as u32, levels).expect("three levels a pixel")
    }

    #[test]
    fn categories_have_swatches_with_bare_labels() {
        let label = |n: usize| ["A", "B<&", "(blank)", &"long ".repeat(20)][n % 4].to_owned();
        let legend = |count: usize| Legend {
            name: "chain".into(),
            title: None,
            map: ColorMap::Category,
            range: [0.0, 3.0],
            log: false,
            categories: (0..count)
                .map(|n| Category { label: label(n), color: [n as u8, 0x80, 0xff], count: 1 })
                .collect(),
            names: Vec::new(),
            overrides: Vec::new(),
        };
        let plot = |count| draw(&legend(count)).expect("a picture");
        assert_eq!(texts(&plot(3)), ["chain", "A", "B<&", "(blank)"], "no numbers of a bar");
        for color in ["#0080ff", "#0180ff", "#0280ff"] {
            assert!(plot(3).svg.contains(color), "{color} in {}", plot(3).svg);
        }
        let picture = |count| pixels(plot(count));
        let one = picture(1);
        let middle = SWATCH / 2;
        assert_eq!(one.get_pixel((BAR[0] + middle) as u32, (BAR[1] + middle) as u32).0, [0, 0x80, 0xff]);
        assert!(picture(4).height() > one.height(), "long labels take a row each");
        let many = texts(&plot(200));
        assert!(many.iter().any(|text| text == "and 80 more"), "{many:?}");
        assert!(many.iter().any(|text| text.starts_with("long long") && text.ends_with('\u{2026}')), "{many:?}");
    }

    #[test]
    fn a_legend_names_its_ends_and_is_drawn() {
        let legend = Legend {
            name: "a<b".into(),
            title: None,
            map: ColorMap::Viridis,
            range: [1.0, 100.0],
            log: true,
            categories: Vec::new(),
            names: Vec::new(),
            overrides: Vec::new(),
        };
        let plot = draw(&legend).expect("a picture");
        let texts = texts(&plot);
        assert_eq!(texts, ["a<b (logarithmic)", "1", "10", "100"]);
        assert_eq!(Legend { title: Some("mass / kg".into()), ..legend }.heading(), "mass / kg");
        for color in ["#440154", "#fde725"] {
            assert!(plot.svg.contains(color), "{color} in {}", plot.svg);
        }
        // The numbers are drawn too: dark pixels under the bar's marks.
        let picture = pixels(plot);
        let below = (BAR[1] + BAR[3] + 12) as u32;
        let dark =
            picture.enumerate_pixels().filter(|(_, y, p)| *y >= below && p.0.iter().all(|level| *level < 64)).count();
        assert!(dark > 50, "{dark} dark pixels in the numbers");
        // A mark for each number.
        let [left, top, wide, high] = BAR;
        let is_dark = |x: &i32| picture.get_pixel(*x as u32, (top + high + 5) as u32).0.iter().all(|level| *level < 64);
        let marks: Vec<i32> = (0..picture.width() as i32).filter(is_dark).collect();
        for tick in 0..3 {
            let at = left + wide * tick / 2;
            assert!(marks.iter().any(|x| (x - at).abs() <= 1), "no mark at {at}: {marks:?}");
        }
        assert!(marks.len() <= 9, "{marks:?}");
    }
}
