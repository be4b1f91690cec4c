//! WGSL from whole files: explicit part lists, numbers as `override` constants, and a line map so that an error names
//! the file and the line. A missing or doubled part is an error of naga's.

use crate::intersect::Method;
use crate::kernel::{Kernel, Rays, Sharing};
use crate::scene::DEFAULT_COLOR;
use crate::shade::Shade;

/// A part of a shader: its name under shaders/ and its text.
pub(crate) type Part = (&'static str, &'static str);

/// The part of that name, built into the program.
macro_rules! part {
    ($path:expr) => {
        ($path, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $path)))
    };
}
pub(crate) use part;

/// A composed shader.
#[derive(Debug)]
pub(crate) struct Source {
    /// All parts, one after the other.
    pub(crate) text: String,
    /// Where each part begins: its first line, from 1, and its name.
    starts: Vec<(usize, &'static str)>,
}

impl Source {
    pub(crate) fn new(parts: impl IntoIterator<Item = Part>) -> Self {
        let mut source = Self { text: String::new(), starts: Vec::new() };
        let mut line = 1;
        for (name, text) in parts {
            source.starts.push((line, name));
            source.text.push_str(text);
            line += text.lines().count();
        }
        source
    }

    /// Each part's name and how many lines it has.
    pub(crate) fn parts(&self) -> Vec<(&'static str, usize)> {
        let ends = self.starts.iter().skip(1).map(|(first, _)| *first).chain([self.text.lines().count() + 1]);
        self.starts.iter().zip(ends).map(|((first, name), end)| (*name, end - first)).collect()
    }

    /// The whole, with the name of its file above each part; still WGSL.
    pub(crate) fn with_banners(&self) -> String {
        let mut lines = self.text.lines();
        let mut text = String::new();
        for (name, count) in self.parts() {
            text.push_str(&format!("// ======== shaders/{name} ========\n\n"));
            lines.by_ref().take(count).for_each(|line| text.extend([line, "\n"]));
            text.push('\n');
        }
        text
    }

    /// `shaders/FILE:LINE` of a line of the whole, both from 1.
    pub(crate) fn place(&self, line: usize) -> String {
        let (first, name) = self.starts.iter().rfind(|(first, _)| *first <= line).copied().unwrap_or((1, "?"));
        format!("shaders/{name}:{}", line - first + 1)
    }

    /// A naga error in terms of the files.
    pub(crate) fn explain(&self, location: Option<naga::SourceLocation>, message: &str) -> String {
        match location {
            Some(at) => format!("{}:{}: {message}", self.place(at.line_number as usize), at.line_position),
            None => message.to_owned(),
        }
    }
}

/// The shader of a kernel.
pub(crate) fn compose(kernel: &Kernel) -> Source {
    let mut parts = vec![part!("view.wgsl"), part!("vector.wgsl")];
    match kernel.certify {
        true => certify(kernel, &mut parts),
        false if kernel.is_wide() && kernel.tiles => wide_tiles(kernel, &mut parts),
        false if kernel.is_wide() => wide(kernel, &mut parts),
        false if kernel.tiles => tiles(kernel, &mut parts),
        false => search(kernel, &mut parts),
    }
    if kernel.rays == Rays::Camera {
        parts.push(part!("window.wgsl"));
        parts.push(if kernel.samples { part!("pixel/sample.wgsl") } else { part!("pixel/plain.wgsl") });
    }
    frame(kernel, &mut parts);
    Source::new(parts)
}

/// The form of the quadratic, of the same name as its CPU twin.
fn form(method: Method) -> Part {
    match method {
        Method::Textbook => part!("intersect/textbook.wgsl"),
        Method::Unit => part!("intersect/unit.wgsl"),
        Method::Geometric => part!("intersect/geometric.wgsl"),
        Method::Stable => part!("intersect/stable.wgsl"),
        Method::Native64 => part!("intersect/native64.wgsl"),
        Method::DoubleFloat => part!("intersect/double_float.wgsl"),
    }
}

/// The nearest hit by one form of the quadratic.
fn search(kernel: &Kernel, parts: &mut Vec<Part>) {
    parts.extend([part!("ray.wgsl"), part!("intersect/roots.wgsl"), form(kernel.method)]);
    parts.extend(match kernel.rays {
        Rays::Camera => vec![part!("origin/shared.wgsl"), part!("render.wgsl")],
        Rays::SharedOrigin => vec![part!("origin/shared.wgsl"), part!("trace.wgsl")],
        Rays::Spread => vec![part!("lows.wgsl"), part!("origin/spread.wgsl"), part!("trace.wgsl")],
    });
    if kernel.tree {
        parts.extend([part!("tree.wgsl"), part!("nearest/tree.wgsl"), part!("nearest/meet.wgsl")]);
    } else {
        parts.push(part!("nearest/consider.wgsl"));
    }
    parts.extend(match kernel.sharing {
        _ if kernel.tree => vec![part!("entry/plain.wgsl")],
        Sharing::None => vec![part!("nearest/plain.wgsl"), part!("entry/plain.wgsl")],
        Sharing::Subgroup4 => vec![part!("nearest/subgroup4.wgsl"), part!("entry/subgroup.wgsl")],
        Sharing::Subgroup8 => vec![part!("nearest/subgroup8.wgsl"), part!("entry/subgroup.wgsl")],
        Sharing::Shuffle => vec![part!("nearest/shuffle.wgsl"), part!("entry/subgroup.wgsl")],
    });
    if kernel.has_normals() {
        parts.push(part!("surface.wgsl"));
    }
}

/// The nearest hit by one form among the candidates of a tile.
fn tiles(kernel: &Kernel, parts: &mut Vec<Part>) {
    parts.extend([part!("ray.wgsl"), part!("intersect/roots.wgsl"), form(kernel.method)]);
    parts.extend([part!("tiles/candidates.wgsl"), part!("tiles/consider.wgsl"), part!("tiles/render.wgsl")]);
    parts.extend(match kernel.sharing {
        Sharing::None | Sharing::Shuffle => [part!("tiles/plain.wgsl"), part!("entry/plain.wgsl")],
        Sharing::Subgroup4 => [part!("tiles/subgroup4.wgsl"), part!("entry/subgroup.wgsl")],
        Sharing::Subgroup8 => [part!("tiles/subgroup8.wgsl"), part!("entry/subgroup.wgsl")],
    });
    if kernel.has_normals() {
        parts.push(part!("surface.wgsl"));
    }
}

/// The same in arithmetic beyond f32.
fn wide_tiles(kernel: &Kernel, parts: &mut Vec<Part>) {
    parts.extend([part!("opaque.wgsl"), form(kernel.method), part!("lows.wgsl"), part!("wide/shared.wgsl")]);
    parts.extend([part!("wide/ray.wgsl"), part!("wide/intersect.wgsl"), part!("tiles/wide/consider.wgsl")]);
    parts.extend([part!("tiles/candidates.wgsl"), part!("tiles/render.wgsl")]);
    parts.extend(match kernel.shares() {
        false => [part!("tiles/wide/plain.wgsl"), part!("entry/plain.wgsl")],
        true => [part!("tiles/wide/shuffle.wgsl"), part!("entry/subgroup.wgsl")],
    });
    if kernel.has_normals() {
        parts.push(part!("tiles/wide/surface.wgsl"));
    }
}

/// The nearest hit in arithmetic beyond f32.
fn wide(kernel: &Kernel, parts: &mut Vec<Part>) {
    parts.extend([part!("opaque.wgsl"), form(kernel.method), part!("lows.wgsl")]);
    parts.extend([part!("wide/ray.wgsl"), part!("wide/intersect.wgsl")]);
    if kernel.tree {
        parts.extend([part!("tree.wgsl"), part!("nearest/tree.wgsl"), part!("wide/meet.wgsl")]);
    } else {
        parts.push(part!("wide/consider.wgsl"));
    }
    parts.extend(match kernel.rays {
        Rays::Camera => [part!("wide/shared.wgsl"), part!("render.wgsl")],
        Rays::SharedOrigin => [part!("wide/shared.wgsl"), part!("trace.wgsl")],
        Rays::Spread => [part!("wide/spread.wgsl"), part!("trace.wgsl")],
    });
    parts.extend(match kernel.sharing {
        _ if kernel.tree => vec![part!("entry/plain.wgsl")],
        Sharing::None => vec![part!("wide/plain.wgsl"), part!("entry/plain.wgsl")],
        // A broadcast wants its lanes unrolled: a fifth faster, and eight times the text to compile.
        _ => vec![part!("wide/shuffle.wgsl"), part!("entry/subgroup.wgsl")],
    });
    if kernel.has_normals() {
        parts.push(part!("wide/surface.wgsl"));
    }
}

/// The nearest hit with its proof.
fn certify(kernel: &Kernel, parts: &mut Vec<Part>) {
    parts.push(part!("ray.wgsl"));
    parts.extend([part!("certify/lens.wgsl"), part!("certify/front.wgsl")]);
    parts.extend(match kernel.sharing {
        Sharing::None | Sharing::Shuffle => vec![part!("certify/plain.wgsl"), part!("entry/plain.wgsl")],
        Sharing::Subgroup4 => {
            vec![part!("certify/share.wgsl"), part!("certify/subgroup4.wgsl"), part!("entry/subgroup.wgsl")]
        }
        Sharing::Subgroup8 => {
            vec![part!("certify/share.wgsl"), part!("certify/subgroup8.wgsl"), part!("entry/subgroup.wgsl")]
        }
    });
    parts.extend([part!("certify/keep.wgsl"), part!("certify/candidates.wgsl")]);
    parts.push(if kernel.nears { part!("certify/near.wgsl") } else { part!("certify/no_near.wgsl") });
    parts.extend([part!("certify/judge.wgsl"), part!("certify/render.wgsl")]);
    parts.push(if kernel.width { part!("frame/width.wgsl") } else { part!("frame/no_width.wgsl") });
}

/// What is written, and how colour is made.
fn frame(kernel: &Kernel, parts: &mut Vec<Part>) {
    parts.push(part!("frame/id.wgsl"));
    parts.push(match kernel.t {
        true if kernel.is_wide() => part!("wide/t.wgsl"),
        true => part!("frame/t.wgsl"),
        false => part!("frame/no_t.wgsl"),
    });
    parts.push(if kernel.normal { part!("frame/normal.wgsl") } else { part!("frame/no_normal.wgsl") });
    if kernel.has_normals() {
        parts.push(part!("shade.wgsl"));
    }
    match kernel.shade {
        None => parts.push(part!("frame/no_color.wgsl")),
        Some(shade) => {
            parts.push(part!("frame/color.wgsl"));
            parts.push(match shade {
                Shade::Flat => part!("shade/flat.wgsl"),
                Shade::Normal => part!("shade/normal.wgsl"),
                Shade::Headlight => part!("shade/headlight.wgsl"),
            });
            if shade.needs_colors() {
                parts.push(if kernel.colors { part!("color/each.wgsl") } else { part!("color/one.wgsl") });
            }
        }
    }
}

/// The values of the `override` constants that the kernel's parts declare.
pub(crate) fn constants(kernel: &Kernel) -> Vec<(&'static str, f64)> {
    if kernel.colors || !kernel.shade.is_some_and(Shade::needs_colors) {
        return Vec::new();
    }
    ["DEFAULT_RED", "DEFAULT_GREEN", "DEFAULT_BLUE"].into_iter().zip(DEFAULT_COLOR.map(f64::from)).collect()
}
