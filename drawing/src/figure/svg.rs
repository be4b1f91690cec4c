//! Figures as SVG 1.1, with arcs as they are.

use super::paint::{Lines, Page, Paint, Path, SEAM, Stop, paper};
use super::path::{Step, number, numbers};
use super::xml;
use crate::canvas::FONT;
use crate::inset::sheet::{Halo, Shape, Sheet};
use glam::DVec2;
use std::fmt::Write;

/// The radius that is rounded to 0.
const NONE: f64 = 5e-5;

/// The value of `d` of a path of closed lines, in units of the picture to 1e-4.
pub(super) fn d(path: &[Step]) -> String {
    lines(path, "Z")
}

/// The same of lines that each end so.
fn lines(path: &[Step], end: &str) -> String {
    let (mut d, mut last) = (String::new(), String::new());
    for (n, step) in path.iter().enumerate() {
        let (Step::Start(to) | Step::Line(to) | Step::Arc { to, .. }) = step;
        let place = numbers(*to);
        // Writing to a String does not fail.
        let _ = match step {
            Step::Start(_) => write!(d, "{}M{place}", if n > 0 { end } else { "" }),
            // Arcs and lines without a length are left out by what reads the file.
            Step::Line(_) if place == last => Ok(()),
            Step::Arc { way, .. } if place == last && way.abs() < 1.0 => Ok(()),
            Step::Line(_) => write!(d, "L{place}"),
            // An ellipse without a width is a line.
            Step::Arc { ellipse, .. } if ellipse.axes[1] < NONE => write!(d, "L{place}"),
            Step::Arc { ellipse, way, .. } => {
                let [a, b] = ellipse.axes;
                let turn = if number(a) == number(b) { "0".into() } else { number(ellipse.turn.to_degrees()) };
                write!(d, "A{} {turn} 0 {} {place}", numbers(DVec2::new(a, b)), u8::from(*way > 0.0))
            }
        };
        last = place;
    }
    d + end
}

fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The figure, with panels over it.
pub(super) fn write<'a>(page: &Page, panels: impl Iterator<Item = (DVec2, &'a Sheet)>) -> String {
    let [width, height] = page.size;
    let [wide, high] = match page.dpi {
        Some(dpi) => [width, height].map(|side| format!("{}mm", number(side * 25.4 / f64::from(dpi)))),
        None => [width, height].map(number),
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{wide}\" \
         height=\"{high}\" viewBox=\"0 0 {width} {height}\">\n<desc>halfline {}</desc>\n",
        env!("CARGO_PKG_VERSION")
    );
    // Writing to a String does not fail.
    if let Some(color) = page.background {
        let _ = writeln!(svg, "<rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>", hex(color));
    }
    if !page.gradients.is_empty() {
        svg += "<defs>\n";
        for (n, stops) in page.gradients.iter().enumerate() {
            let _ = write!(svg, "<radialGradient id=\"c{n}\">");
            for Stop { at, color } in stops {
                let _ = write!(svg, "<stop offset=\"{}\" stop-color=\"{}\"/>", number(*at), hex(*color));
            }
            svg += "</radialGradient>\n";
        }
        for path in page.groups.iter().flat_map(|group| &group.paths) {
            if let Paint::Radial { stops, matrix, focus } = &path.paint {
                // A hundredth of a pixel is not seen in a gradient. Programs take the colours from another gradient, and not its circle.
                let matrix = matrix.map(|x| format!("{x:.2}")).join(" ");
                let circle = "gradientUnits=\"userSpaceOnUse\" cx=\"0\" cy=\"0\" r=\"1\"";
                let _ = write!(svg, "<radialGradient id=\"g{}\" xlink:href=\"#c{stops}\" {circle}", path.name);
                if focus.length() > 5e-4 {
                    let _ = write!(svg, " fx=\"{}\" fy=\"{}\"", number(focus.x), number(focus.y));
                }
                let _ = writeln!(svg, " gradientTransform=\"matrix({matrix})\"/>");
            }
        }
        svg += "</defs>\n";
    }
    let _ = writeln!(svg, "<g id=\"spheres\" fill-rule=\"evenodd\" stroke-width=\"{SEAM}\" stroke-linejoin=\"round\">");
    for group in &page.groups {
        if let Some(id) = &group.id {
            let _ = writeln!(svg, "<g id=\"{}\"{}>", xml::attribute(id), data(&group.data));
        }
        group.paths.iter().for_each(|path| add(&mut svg, path));
        svg += if group.id.is_some() { "</g>\n" } else { "" };
    }
    svg += "</g>\n";
    if let Some(Lines { color, width, steps }) = page.lines.as_ref().filter(|lines| !lines.steps.is_empty()) {
        let (color, width, d) = (hex(*color), number(*width), lines(steps, ""));
        let style = "fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\"";
        let _ = writeln!(svg, "<path id=\"lines\" {style} stroke=\"{color}\" stroke-width=\"{width}\" d=\"{d}\"/>");
    }
    let mut panels = panels.peekable();
    if panels.peek().is_some() {
        let _ = writeln!(
            svg,
            "<g id=\"insets\" font-family=\"{FONT}\" stroke-linecap=\"round\" stroke-linejoin=\"round\">"
        );
        panels.for_each(|(at, sheet)| add_sheet(&mut svg, at, sheet));
        svg += "</g>\n";
    }
    svg + "</svg>\n"
}

fn data(data: &[(String, String)]) -> String {
    data.iter().map(|(name, value)| format!(" data-{name}=\"{}\"", xml::attribute(value))).collect()
}

fn add(svg: &mut String, Path { name, data: values, steps, paint }: &Path) {
    let paint = match paint {
        Paint::Flat(color) => hex(*color),
        Paint::Radial { .. } => format!("url(#g{name})"),
    };
    // A thin line of its own colour closes the seams between neighbours.
    let _ =
        writeln!(svg, "<path id=\"{name}\"{} fill=\"{paint}\" stroke=\"{paint}\" d=\"{}\"/>", data(values), d(steps));
}

fn add_sheet(svg: &mut String, at: DVec2, sheet: &Sheet) {
    let _ = writeln!(svg, "<g transform=\"translate({})\">", numbers(at));
    if sheet.has_paper {
        let ([width, height], paper) = (sheet.size, paper());
        let _ =
            writeln!(svg, "<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\" fill-opacity=\"{paper:.3}\"/>");
    }
    let n = |x: f32| number(f64::from(x));
    for shape in &sheet.shapes {
        let _ = match shape {
            Shape::Rectangle { corners: [left, top, right, bottom], color } => {
                let [left, top, width, height] = [*left, *top, right - left, bottom - top].map(n);
                let color = hex(*color);
                writeln!(svg, "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"{color}\"/>")
            }
            Shape::Text { text, bold, size, at: [x, y], color, halo } => {
                let weight = if *bold { " font-weight=\"bold\"" } else { "" };
                let halo = halo.map_or(String::new(), |Halo { width, color }| {
                    format!(" stroke=\"{}\" stroke-width=\"{}\" paint-order=\"stroke\"", hex(color), n(width))
                });
                let (x, y, size, color, text) = (n(*x), n(*y), n(*size), hex(*color), xml::text(text));
                writeln!(
                    svg,
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{weight} fill=\"{color}\"{halo}>{text}</text>"
                )
            }
            Shape::Line { ends: [from, to], width, color } => {
                let [a, b, c, d] = [from[0], from[1], to[0], to[1]].map(n);
                let (color, width) = (hex(*color), n(*width));
                writeln!(svg, "<path d=\"M{a} {b}L{c} {d}\" stroke=\"{color}\" stroke-width=\"{width}\"/>")
            }
            Shape::Disc { at, radius, color } => {
                let ([x, y], radius, color) = (at.map(n), n(*radius), hex(*color));
                writeln!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{color}\"/>")
            }
        };
    }
    *svg += "</g>\n";
}
