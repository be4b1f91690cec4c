//! The look of plots: one colour, mark and dash per method, one font, the greys, and the colours of wrong pixels.

use halfline::error::Source;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Drawing fails only if memory is short, or by a bug.
pub(super) type Drawn<T = ()> = Result<T, Source>;

/// The PNG uses DejaVu Sans; a browser without it uses the next font.
pub(super) const FONT: &str = "DejaVu Sans, Verdana, sans-serif";

pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
pub(super) const QUIET: RGBColor = RGBColor(0x66, 0x66, 0x66);
pub(super) const GRID: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);
pub(super) const FAINT: RGBColor = RGBColor(0xf0, 0xf0, 0xf0);
pub(super) const BAND: RGBColor = RGBColor(0xf3, 0xf6, 0xf4);

/// Kinds of wrong pixels: letter in a crop, name, colour. Okabe and Ito's palette, bright enough on any grey.
pub(super) const KINDS: [(char, &str, [u8; 3]); 4] = [
    ('h', "false hit", [0xd5, 0x5e, 0x00]),
    ('m', "false miss", [0x00, 0x72, 0xb2]),
    ('s', "wrong sphere", [0xcc, 0x79, 0xa7]),
    ('r', "wrong root", [0xf0, 0xe4, 0x42]),
];

/// A mark; all differ in shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mark {
    Circle,
    Square,
    Diamond,
    Up,
    Down,
    Star,
    Hexagon,
    Cross,
}

/// The look of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    pub(super) color: RGBColor,
    pub(super) mark: Mark,
    /// Lengths of dash and gap, in units of the canvas; `None` is a solid line.
    pub(super) dash: Option<(i32, i32)>,
}

/// A row of the table below: a method with its colour, mark and dash.
type Named = (&'static str, [u8; 3], Mark, Option<(i32, i32)>);

/// Okabe and Ito's palette (jfly.uni-koeln.de/color, 2008), with a darker yellow for contrast on white. Methods that
/// round identically and therefore coincide have different dashes.
const LOOKS: [Named; 8] = [
    ("textbook", [0xd5, 0x5e, 0x00], Mark::Circle, None),
    ("unit", [0xe6, 0x9f, 0x00], Mark::Square, None),
    ("geometric", [0xcc, 0x79, 0xa7], Mark::Diamond, Some((18, 14))),
    ("stable", [0x56, 0xb4, 0xe9], Mark::Up, None),
    ("f64", [0x00, 0x72, 0xb2], Mark::Down, Some((26, 10))),
    ("double-float", [0x9a, 0x8f, 0x00], Mark::Hexagon, Some((8, 8))),
    ("certified", [0x00, 0x9e, 0x73], Mark::Star, None),
    ("exact", [0x00, 0x00, 0x00], Mark::Cross, Some((14, 10))),
];

/// The look of a method by its name; grey for unknown methods.
pub(super) fn look(method: &str) -> Look {
    LOOKS.iter().find(|(name, ..)| *name == method).map_or(
        Look { color: RGBColor(0x88, 0x88, 0x88), mark: Mark::Circle, dash: Some((4, 6)) },
        |(_, [r, g, b], mark, dash)| Look { color: RGBColor(*r, *g, *b), mark: *mark, dash: *dash },
    )
}

/// The position of a method among the others, 0 to 1: its lane where many have the same value.
pub(super) fn lane(method: &str, among: &[&str]) -> f64 {
    let index = among.iter().position(|name| *name == method).unwrap_or(0);
    (index as f64 + 0.5) / among.len().max(1) as f64
}

/// Text `size` units high, left-aligned on its middle.
pub(super) fn font(size: i32) -> TextStyle<'static> {
    styled(size, FontStyle::Normal)
}

/// The same in bold.
pub(super) fn bold(size: i32) -> TextStyle<'static> {
    styled(size, FontStyle::Bold)
}

fn styled(size: i32, style: FontStyle) -> TextStyle<'static> {
    // plotters writes a size divided by 1.24 into the SVG.
    TextStyle::from(FontDesc::new(FontFamily::Name(FONT), f64::from(size) * 1.24, style))
        .color(&INK)
        .pos(Pos::new(HPos::Left, VPos::Center))
}

/// `style` aligned by its middle.
pub(super) fn centered<'a>(style: &TextStyle<'a>) -> TextStyle<'a> {
    style.pos(Pos::new(HPos::Center, VPos::Center))
}

/// The approximate width of `text`: 0.58 of the height per letter in DejaVu Sans.
pub(super) fn width(text: &str, size: i32) -> i32 {
    text.chars().count() as i32 * size * 58 / 100
}
