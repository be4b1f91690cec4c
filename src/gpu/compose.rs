//! WGSL from whole files: explicit part lists, numbers as `override` constants, and a line map so that an error names
//! the file and the line. A missing or doubled part is an error of naga's.

use crate::plan::{Kernel, Rays, Sharing};
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
    let wide = kernel.method.is_wide();
    let mut parts = vec![part!("view.wgsl"), part!("vector.wgsl"), kernel.method.wgsl()];
    parts.extend(match wide {
        false => vec![part!("ray.wgsl"), part!("intersect/roots.wgsl"), part!("nearest/consider.wgsl")],
        true => vec![
            part!("opaque.wgsl"),
            part!("wide/ray.wgsl"),
            part!("wide/intersect.wgsl"),
            part!("wide/consider.wgsl"),
            if kernel.rays == Rays::Spread { part!("wide/spread.wgsl") } else { part!("wide/shared.wgsl") },
        ],
    });
    if wide || kernel.rays == Rays::Spread {
        parts.push(part!("lows.wgsl"));
    }
    parts.extend(match kernel.rays {
        // What is loaded is moved in better arithmetic afterwards.
        Rays::Spread if wide => [part!("origin/shared.wgsl"), part!("trace.wgsl")],
        Rays::Camera => [part!("origin/shared.wgsl"), part!("render.wgsl")],
        Rays::SharedOrigin => [part!("origin/shared.wgsl"), part!("trace.wgsl")],
        Rays::Spread => [part!("origin/spread.wgsl"), part!("trace.wgsl")],
    });
    parts.extend(match kernel.sharing {
        Sharing::None if wide => [part!("wide/plain.wgsl"), part!("entry/plain.wgsl")],
        // A broadcast wants its lanes unrolled: a fifth faster, and eight times the text to compile.
        _ if wide => [part!("wide/shuffle.wgsl"), part!("entry/subgroup.wgsl")],
        Sharing::None => [part!("nearest/plain.wgsl"), part!("entry/plain.wgsl")],
        Sharing::Subgroup4 => [part!("nearest/subgroup4.wgsl"), part!("entry/subgroup.wgsl")],
        Sharing::Subgroup8 => [part!("nearest/subgroup8.wgsl"), part!("entry/subgroup.wgsl")],
        Sharing::Shuffle => [part!("nearest/shuffle.wgsl"), part!("entry/subgroup.wgsl")],
    });
    parts.push(part!("frame/id.wgsl"));
    parts.push(match kernel.t {
        true if wide => part!("wide/t.wgsl"),
        true => part!("frame/t.wgsl"),
        false => part!("frame/no_t.wgsl"),
    });
    parts.push(if kernel.normal { part!("frame/normal.wgsl") } else { part!("frame/no_normal.wgsl") });
    if kernel.normal || kernel.shade.is_some_and(|shade| shade != Shade::Flat) {
        parts.push(if wide { part!("wide/surface.wgsl") } else { part!("shade.wgsl") });
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
    Source::new(parts)
}

/// The values of the `override` constants that the kernel's parts declare.
pub(crate) fn constants(kernel: &Kernel) -> Vec<(&'static str, f64)> {
    if kernel.colors || !kernel.shade.is_some_and(Shade::needs_colors) {
        return Vec::new();
    }
    ["DEFAULT_RED", "DEFAULT_GREEN", "DEFAULT_BLUE"].into_iter().zip(DEFAULT_COLOR.map(f64::from)).collect()
}
