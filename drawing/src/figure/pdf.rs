//! Figures as PDF 1.7, whose curves are cubic: each arc is divided until it is within [`NEAR`] of its ellipse. The letters of texts come
//! from the font of labels; a part of the font is in the file.

use super::paint::{Lines, Page, Paint, Path, SEAM, Stop, paper};
use super::path::{Step, number, numbers};
use crate::inset::sheet::{Halo, Shape, Sheet};
use crate::raster::{Glyph, bytes, glyphs, metrics};
use glam::{DAffine2, DMat2, DVec2};
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, FunctionShadingType, SystemInfo, UnicodeCmap};
use pdf_writer::{Filter, Finish, Name, Pdf, Rect, Ref, Str};
use std::collections::BTreeMap;
use std::fmt::Write;
use subsetter::GlyphRemapper;

/// The largest distance of a curve from its ellipse, units of the picture; numbers are rounded to 1e-4 besides.
const NEAR: f64 = 5e-5;

/// Units in an inch where a figure has no resolution, as in CSS; points in an inch.
const UNITS: u32 = 96;
const POINTS: f64 = 72.0;

/// The effort of compression, of 10.
const EFFORT: u8 = 6;

/// The cubic curves of a part of an ellipse: two points that lead to a third.
pub(super) fn cubics(axes: [f64; 2], from: f64, way: f64) -> Vec<[DVec2; 3]> {
    // A cubic of an angle a is within 2/27 sin^6(a/4) / cos^2(a/4) of the circle of radius 1 (M. Goldapp, Computer Aided Geometric Design 8,
    // 1991), and an ellipse is a circle that is shortened along one axis.
    let distance = |count: f64| {
        let quarter = 0.25 * way.abs() / count;
        axes[0] * 2.0 / 27.0 * quarter.sin().powi(6) / quarter.cos().powi(2)
    };
    let count =
        (1..=1000).map(f64::from).find(|count| way.abs() / count < 1.6 && distance(*count) < NEAR).unwrap_or(1000.0);
    let part = way / count;
    let length = 4.0 / 3.0 * (0.25 * part).tan();
    let [a, b] = axes;
    let at = |angle: f64| DVec2::new(a * angle.cos(), b * angle.sin());
    let on = |angle: f64| DVec2::new(-a * angle.sin(), b * angle.cos()) * length;
    let cubic = |n: u32| {
        let (start, end) = (from + f64::from(n) * part, from + f64::from(n + 1) * part);
        [at(start) + on(start), at(end) - on(end), at(end)]
    };
    (0..count as u32).map(cubic).collect()
}

/// The figure, with panels over it.
pub(super) fn write<'a>(page: &Page, panels: impl Iterator<Item = (DVec2, &'a Sheet)>) -> Vec<u8> {
    let mut out = Document::new(page);
    out.add_paths(page);
    panels.for_each(|(at, sheet)| out.add_sheet(at, sheet));
    out.finish(page)
}

/// The letters of a font that texts use.
#[derive(Default)]
struct Letters {
    glyphs: GlyphRemapper,
    /// The letter and the width of each glyph, by its new number.
    of: BTreeMap<u16, (char, f32)>,
}

struct Document {
    pdf: Pdf,
    next: i32,
    /// The operators of the page.
    content: String,
    /// From units of the picture to points of the page.
    to_points: DAffine2,
    gradients: Vec<Ref>,
    patterns: Vec<Ref>,
    /// The letters of the regular and of the bold font.
    letters: [Letters; 2],
}

impl Document {
    fn new(page: &Page) -> Self {
        let scale = POINTS / f64::from(page.dpi.unwrap_or(UNITS));
        let to_points = DAffine2 {
            matrix2: DMat2::from_diagonal(DVec2::new(scale, -scale)),
            translation: DVec2::new(0.0, scale * page.size[1]),
        };
        let (gradients, patterns, letters) = (Vec::new(), Vec::new(), Default::default());
        let mut all =
            Self { pdf: Pdf::new(), next: 1, content: String::new(), to_points, gradients, patterns, letters };
        // Writing to a String does not fail.
        let _ = writeln!(all.content, "q {scale} 0 0 {} 0 {} cm", -scale, scale * page.size[1]);
        if let Some(color) = page.background {
            let [width, height] = page.size;
            let _ = writeln!(all.content, "{} rg 0 0 {width} {height} re f", rgb(color));
        }
        all.gradients = page.gradients.iter().map(|stops| all.gradient(stops)).collect();
        all
    }

    fn take(&mut self) -> Ref {
        self.next += 1;
        Ref::new(self.next - 1)
    }

    /// A function from the share of the way to a colour.
    fn gradient(&mut self, stops: &[Stop]) -> Ref {
        let color = |stop: &Stop| stop.color.map(|level| f32::from(level) / 255.0);
        let parts: Vec<Ref> = stops
            .windows(2)
            .map(|two| {
                let part = self.take();
                let mut function = self.pdf.exponential_function(part);
                function.domain([0.0, 1.0]).c0(color(&two[0])).c1(color(&two[1])).n(1.0);
                part
            })
            .collect();
        let all = self.take();
        let mut function = self.pdf.stitching_function(all);
        function.domain([0.0, 1.0]).functions(parts.iter().copied());
        function.bounds(stops[1..stops.len() - 1].iter().map(|stop| stop.at as f32));
        function.encode(parts.iter().flat_map(|_| [0.0, 1.0]));
        all
    }

    fn add_paths(&mut self, page: &Page) {
        let _ = writeln!(self.content, "1 j 1 J {SEAM} w");
        for path in page.groups.iter().flat_map(|group| &group.paths) {
            self.paint(path);
            self.add_steps(&path.steps, "h ");
            self.content += "h B*\n";
        }
        if let Some(Lines { color, width, steps }) = page.lines.as_ref().filter(|lines| !lines.steps.is_empty()) {
            let _ = writeln!(self.content, "{} RG {} w", rgb(*color), number(*width));
            self.add_steps(steps, "");
            self.content += "S\n";
        }
    }

    /// Adds lines that each end so before the next begins.
    fn add_steps(&mut self, steps: &[Step], end: &str) {
        for (n, step) in steps.iter().enumerate() {
            let _ = match step {
                Step::Start(at) => writeln!(self.content, "{}{} m", if n > 0 { end } else { "" }, numbers(*at)),
                Step::Line(to) => writeln!(self.content, "{} l", numbers(*to)),
                Step::Arc { ellipse, from, way, to } => {
                    let (turned, cubics) = (DVec2::from_angle(ellipse.turn), cubics(ellipse.axes, *from, *way));
                    let last = cubics.len() - 1;
                    for (k, points) in cubics.iter().enumerate() {
                        let [a, b, c] = points.map(|point| ellipse.center + turned.rotate(point));
                        let c = if k == last { *to } else { c };
                        let _ = writeln!(self.content, "{} {} {} c", numbers(a), numbers(b), numbers(c));
                    }
                    Ok(())
                }
            };
        }
    }

    /// Sets the paint of a path, and of a line of its colour around it.
    fn paint(&mut self, path: &Path) {
        let operators = match path.paint {
            Paint::Flat(color) => format!("{0} rg {0} RG ", rgb(color)),
            Paint::Radial { stops, matrix: [a, b, c, d, e, f], focus } => {
                let pattern = self.take();
                let matrix = DAffine2::from_cols(DVec2::new(a, b), DVec2::new(c, d), DVec2::new(e, f));
                let gradient = self.gradients[stops];
                let mut shading = self.pdf.shading_pattern(pattern);
                shading.matrix((self.to_points * matrix).to_cols_array().map(|x| x as f32));
                let mut function = shading.function_shading();
                function.shading_type(FunctionShadingType::Radial).color_space().device_rgb();
                function.coords([focus.x as f32, focus.y as f32, 0.0, 0.0, 0.0, 1.0]).function(gradient);
                function.extend([false, true]);
                self.patterns.push(pattern);
                format!("/Pattern cs /P{0} scn /Pattern CS /P{0} SCN ", self.patterns.len() - 1)
            }
        };
        self.content += &operators;
    }

    fn add_sheet(&mut self, at: DVec2, sheet: &Sheet) {
        let _ = writeln!(self.content, "q 1 0 0 1 {} cm 1 J 1 j", numbers(at));
        if sheet.has_paper {
            let [width, height] = sheet.size;
            let _ = writeln!(self.content, "q /Paper gs 1 1 1 rg 0 0 {width} {height} re f Q");
        }
        let n = |x: f32| number(f64::from(x));
        for shape in &sheet.shapes {
            let _ = match shape {
                Shape::Rectangle { corners: [left, top, right, bottom], color } => {
                    let [left, top, width, height] = [*left, *top, right - left, bottom - top].map(n);
                    writeln!(self.content, "{} rg {left} {top} {width} {height} re f", rgb(*color))
                }
                Shape::Line { ends: [from, to], width, color } => {
                    let [a, b, c, d] = [from[0], from[1], to[0], to[1]].map(n);
                    writeln!(self.content, "{} RG {} w {a} {b} m {c} {d} l S", rgb(*color), n(*width))
                }
                // A line without length, whose ends are round.
                Shape::Disc { at: [x, y], radius, color } => {
                    let (x, y, width) = (n(*x), n(*y), n(2.0 * radius));
                    writeln!(self.content, "{} RG {width} w {x} {y} m {x} {y} l S", rgb(*color))
                }
                Shape::Text { text, bold, size, at, color, halo } => {
                    let shown = self.shown(text, *bold);
                    let [x, y, size] = [at[0], at[1], *size].map(n);
                    let text = format!("BT /F{} {size} Tf 1 0 0 -1 {x} {y} Tm", u8::from(*bold));
                    if let Some(Halo { width, color }) = halo {
                        let _ = writeln!(self.content, "{} RG {} w {text} 1 Tr {shown} TJ ET", rgb(*color), n(*width));
                    }
                    writeln!(self.content, "{} rg {text} 0 Tr {shown} TJ ET", rgb(*color))
                }
            };
        }
        self.content += "Q\n";
    }

    /// The glyphs of a text, with the kerning between them, for TJ.
    fn shown(&mut self, text: &str, bold: bool) -> String {
        let letters = &mut self.letters[usize::from(bold)];
        let mut shown = String::from("[");
        for Glyph { id, letter, width, kern } in glyphs(text, bold) {
            let id = letters.glyphs.remap(id);
            letters.of.entry(id).or_insert((letter, width));
            let _ = write!(shown, "<{id:04x}>");
            if kern != 0.0 {
                let _ = write!(shown, "{}", number(f64::from(-1000.0 * kern)));
            }
        }
        shown + "]"
    }

    fn finish(mut self, page: &Page) -> Vec<u8> {
        self.content += "Q\n";
        let [catalog, pages, sheet, content, state] = [(); 5].map(|()| self.take());
        let fonts: Vec<(usize, Ref)> = (0..2)
            .filter(|n| !self.letters[*n].of.is_empty())
            .collect::<Vec<_>>()
            .into_iter()
            .map(|n| (n, self.font(n)))
            .collect();
        let Self { mut pdf, patterns, to_points, content: operators, .. } = self;
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([sheet]).count(1);
        pdf.ext_graphics(state).non_stroking_alpha(paper() as f32);
        let mut leaf = pdf.page(sheet);
        let [width, height] = [to_points.matrix2.x_axis.x * page.size[0], to_points.translation.y].map(|x| x as f32);
        leaf.media_box(Rect::new(0.0, 0.0, width, height)).parent(pages).contents(content);
        let mut resources = leaf.resources();
        let mut named = resources.patterns();
        for (n, pattern) in patterns.iter().enumerate() {
            named.pair(Name(format!("P{n}").as_bytes()), *pattern);
        }
        named.finish();
        resources.ext_g_states().pair(Name(b"Paper"), state);
        let mut named = resources.fonts();
        for (n, font) in fonts {
            named.pair(Name(format!("F{n}").as_bytes()), font);
        }
        named.finish();
        resources.finish();
        leaf.finish();
        pdf.stream(content, &compress_to_vec_zlib(operators.as_bytes(), EFFORT)).filter(Filter::FlateDecode);
        pdf.finish()
    }

    /// A font, of the glyphs that texts have.
    fn font(&mut self, n: usize) -> Ref {
        let [font, descendant, descriptor, file, map] = [(); 5].map(|()| self.take());
        let (letters, is_bold) = (&self.letters[n], n == 1);
        let name: &[u8] = if is_bold { b"HALFLN+DejaVuSans-Bold" } else { b"HALFLN+DejaVuSans" };
        let name = Name(name);
        let info = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };
        self.pdf
            .type0_font(font)
            .base_font(name)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(descendant)
            .to_unicode(map);
        let mut cid = self.pdf.cid_font(descendant);
        cid.subtype(CidFontType::Type2).base_font(name).system_info(info).font_descriptor(descriptor);
        cid.default_width(0.0).cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = cid.widths();
        letters.of.iter().for_each(|(id, (_, width))| _ = widths.consecutive(*id, [1000.0 * width]));
        widths.finish();
        cid.finish();
        let [ascent, descent] = metrics(is_bold).map(|x| 1000.0 * x);
        let mut of = self.pdf.font_descriptor(descriptor);
        of.name(name).flags(FontFlags::SYMBOLIC).bbox(Rect::new(-1500.0, descent, 2000.0, ascent)).italic_angle(0.0);
        of.ascent(ascent)
            .descent(descent)
            .cap_height(730.0)
            .stem_v(if is_bold { 140.0 } else { 80.0 })
            .font_file2(file);
        of.finish();
        // The font of the program is whole, so a part of it can be made.
        let part = subsetter::subset(bytes(is_bold), 0, &letters.glyphs).unwrap_or_else(|_| bytes(is_bold).to_vec());
        let packed = compress_to_vec_zlib(&part, EFFORT);
        self.pdf.stream(file, &packed).filter(Filter::FlateDecode).pair(Name(b"Length1"), part.len() as i32);
        let mut unicode = UnicodeCmap::new(Name(b"Letters"), info);
        letters.of.iter().for_each(|(id, (letter, _))| unicode.pair(*id, *letter));
        self.pdf.cmap(map, &unicode.finish());
        font
    }
}

fn rgb(color: [u8; 3]) -> String {
    color.map(|level| number(f64::from(level) / 255.0)).join(" ")
}
