//! Composes WGSL from whole files and from parts generated from tables: binding numbers, sizes and outputs. A line map
//! translates the line of an error to a file and line. naga reports a missing or doubled part as an error.

use crate::gpu::layout::buffers;
use crate::gpu::sizes::{declarations, of_lines, of_smoothing};
use crate::intersect::Method;
use crate::kernel::{Certificate, Generals, Kernel, KernelOutput, RaySource, Task, Unproved};
use crate::scene::DEFAULT_COLOR;
use crate::shade::Shade;
use std::borrow::Cow;

/// A part of a shader.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// The file under shaders/, or a description if the part is generated.
    pub(crate) name: &'static str,
    pub(crate) text: Cow<'static, str>,
}

/// Prefix of the names of generated parts.
const EMITTED: &str = "emitted: ";

macro_rules! files {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name)))),*]
    };
}

/// Every file of shaders/, embedded in the program.
const FILES: [(&str, &str); 90] = files![
    "view.wgsl" "math.wgsl" "hash.wgsl" "ray.wgsl"
    "number/f32.wgsl" "number/f64.wgsl" "number/double_float.wgsl"
    "form/textbook.wgsl" "form/unit.wgsl" "form/geometric.wgsl" "form/roots.wgsl" "form/stable.wgsl" "form/perpendicular.wgsl"
    "search/closer_hit.wgsl" "search/residuals.wgsl" "search/no_residuals.wgsl" "search/fixed_origin.wgsl"
    "search/moved_origin.wgsl" "search/all.wgsl" "search/tree.wgsl" "search/placed.wgsl"
    "place/float64.wgsl" "place/placing.wgsl" "place/low.wgsl" "place/rectangle.wgsl" "place/place.wgsl" "place/cut.wgsl" "place/guests.wgsl"
    "splat/order.wgsl" "splat/frame.wgsl" "splat/list.wgsl" "splat/splat.wgsl" "splat/small.wgsl" "splat/large.wgsl"
    "certify/constants.wgsl" "certify/projection.wgsl" "certify/projected.wgsl" "certify/general.wgsl"
    "certify/nearest_general.wgsl" "certify/general_few.wgsl" "certify/general_lists.wgsl" "certify/no_general.wgsl"
    "certify/roots.wgsl" "certify/planes.wgsl" "certify/detail.wgsl" "certify/whole.wgsl" "certify/cut.wgsl"
    "certify/whole_general.wgsl" "certify/cut_general.wgsl" "splat/whole.wgsl" "splat/cut.wgsl" "shade/face_color.wgsl"
    "certify/nearest_two.wgsl" "certify/certify_winner.wgsl" "certify/take_proved.wgsl" "certify/take_nearest.wgsl"
    "certify/given_constants.wgsl" "certify/given.wgsl" "certify/given_any.wgsl"
    "main/viewing_rays.wgsl" "main/given_rays.wgsl" "main/certified.wgsl" "main/window.wgsl" "main/pixel_center.wgsl"
    "main/sample.wgsl" "main/start.wgsl" "main/no_start.wgsl" "main/sky_rays.wgsl" "main/sky.wgsl"
    "picture/record.wgsl" "picture/means.wgsl" "picture/sky_sums.wgsl" "picture/smooth.wgsl" "picture/unsure.wgsl"
    "picture/scatter.wgsl" "picture/line.wgsl" "picture/picture.wgsl"
    "shade/world.wgsl" "shade/world_normal.wgsl" "shade/color.wgsl" "shade/sphere_color.wgsl" "shade/flat.wgsl" "shade/normal.wgsl"
    "shade/headlight.wgsl"
    "selftest/main.wgsl" "selftest/operations.wgsl" "selftest/transforms.wgsl" "selftest/double_float.wgsl"
    "selftest/solve.wgsl" "selftest/f64.wgsl"
];

/// The parts for these files. A test checks that every file named in this crate exists.
pub(crate) fn files<const N: usize>(names: [&'static str; N]) -> impl Iterator<Item = Part> {
    let text = |name| FILES.iter().find(|(file, _)| *file == name).map_or("", |(_, text)| *text);
    names.into_iter().map(move |name| Part { name, text: text(name).into() })
}

/// A composed shader.
#[derive(Debug)]
pub(crate) struct Source {
    /// All parts, concatenated.
    pub(crate) text: String,
    pub(super) parts: Vec<Part>,
}

impl Source {
    pub(crate) fn new(parts: Vec<Part>) -> Self {
        Self { text: parts.iter().map(|part| &*part.text).collect(), parts }
    }

    /// The files among the parts and their numbers of lines.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let files = self.parts.iter().filter(|part| !part.name.starts_with(EMITTED));
        files.map(|part| (part.name, part.text.lines().count()))
    }

    /// The complete text with the name of its file above each part; still valid WGSL.
    pub(crate) fn with_banners(&self) -> String {
        let banner = |part: &Part| format!("// ======== {} ========\n\n{}\n", shown(part.name), part.text);
        self.parts.iter().map(banner).collect()
    }

    /// `shaders/FILE:LINE` of a line of the complete text, both counted from 1.
    pub(crate) fn place(&self, line: usize) -> String {
        let mut first = 1;
        for part in &self.parts {
            let next = first + part.text.lines().count();
            if line < next {
                return format!("{}:{}", shown(part.name), line - first + 1);
            }
            first = next;
        }
        format!("line {line}")
    }

    /// A naga error with the location in its file.
    pub(crate) fn explain(&self, location: Option<naga::SourceLocation>, message: &str) -> String {
        match location {
            Some(at) => format!("{}:{}: {message}", self.place(at.line_number as usize), at.line_position),
            None => message.to_owned(),
        }
    }
}

/// A part's name as shown in messages.
fn shown(name: &str) -> String {
    if name.starts_with(EMITTED) { name.to_owned() } else { format!("shaders/{name}") }
}

/// The shaders of a frame, in the order in which they run: before a certified kernel the steps of a resident frame. The shaders of
/// large spheres run only where there are some.
pub(crate) fn shaders(kernel: &Kernel) -> Vec<(&'static str, Source)> {
    let (samples, planes) = (kernel.samples, kernel.has_planes());
    let steps = [
        ("place the spheres", Step::Place),
        ("cut large spheres that the host placed", Step::Guests),
        ("spheres of few pixels", Step::Small { samples, planes }),
        ("pieces of large spheres", Step::Large { samples, planes }),
    ];
    if !kernel.is_certified() {
        return vec![("test every sphere", compose(kernel))];
    }
    let steps = steps.map(|(purpose, step)| (purpose, compose_step(step)));
    steps.into_iter().chain([("certify the pixels", compose(kernel))]).collect()
}

/// The shader of a kernel.
pub(crate) fn compose(kernel: &Kernel) -> Source {
    Source::new(parts(kernel))
}

/// The parts of a kernel, in order.
pub(crate) fn parts(kernel: &Kernel) -> Vec<Part> {
    let mut parts = vec![binding_numbers()];
    let number = match kernel.method() {
        Some(Method::Native64) => "number/f64.wgsl",
        Some(Method::DoubleFloat) => "number/double_float.wgsl",
        _ => "number/f32.wgsl",
    };
    parts.extend(files(["view.wgsl", "math.wgsl", number, "ray.wgsl"]));
    if kernel.has_pixels() {
        parts.extend(files(["main/window.wgsl"]));
        parts.extend(position(kernel.samples));
    }
    match kernel.task {
        Task::Method { method, rays } => search(method, rays, &mut parts),
        Task::Certified(certificate) => certify(certificate, &mut parts),
        // The host traces them.
        Task::Given => {}
    }
    shade(kernel, &mut parts);
    parts.push(outputs(kernel));
    parts
}

/// The search for the closest hit among all spheres by one form of the quadratic.
fn search(method: Method, rays: RaySource, parts: &mut Vec<Part>) {
    let form = match method {
        Method::Textbook => "form/textbook.wgsl",
        Method::Unit => "form/unit.wgsl",
        Method::Geometric => "form/geometric.wgsl",
        Method::Stable => "form/stable.wgsl",
        Method::Native64 | Method::DoubleFloat => "form/perpendicular.wgsl",
    };
    if matches!(method, Method::Textbook | Method::Unit | Method::Geometric) {
        parts.extend(files(["form/roots.wgsl"]));
    }
    let spread = rays == RaySource::Spread;
    let residuals = if spread || method.is_wide() { "search/residuals.wgsl" } else { "search/no_residuals.wgsl" };
    let origin = if spread { "search/moved_origin.wgsl" } else { "search/fixed_origin.wgsl" };
    let main = if rays == RaySource::Camera { "main/viewing_rays.wgsl" } else { "main/given_rays.wgsl" };
    parts.extend(files([form, "search/closer_hit.wgsl", residuals, origin, "search/all.wgsl", main]));
}

/// The parts that certify each pixel's nearest sphere, from the minima that the spheres left in the pixels.
fn certify(Certificate { generals, unproved, starts, planes, .. }: Certificate, parts: &mut Vec<Part>) {
    parts.extend(files(["certify/constants.wgsl", "certify/projection.wgsl", "certify/projected.wgsl"]));
    let test = if planes { "certify/cut_general.wgsl" } else { "certify/whole_general.wgsl" };
    let some = |of: &'static str| files(["certify/general.wgsl", "certify/nearest_general.wgsl", test, of]);
    match generals {
        Generals::None => parts.extend(files(["certify/no_general.wgsl"])),
        Generals::Few => parts.extend(some("certify/general_few.wgsl")),
        Generals::Lists => parts.extend(some("certify/general_lists.wgsl")),
    }
    parts.push(sizes());
    let start = if starts { "main/start.wgsl" } else { "main/no_start.wgsl" };
    let take = match unproved {
        Unproved::Unsure => "certify/take_proved.wgsl",
        Unproved::Nearest => "certify/take_nearest.wgsl",
    };
    parts.extend(files(["place/placing.wgsl", "splat/order.wgsl", "splat/frame.wgsl", "certify/nearest_two.wgsl"]));
    parts.extend(files(["certify/detail.wgsl", "certify/certify_winner.wgsl", take, start, "main/certified.wgsl"]));
    match planes {
        true => parts.extend(files(["certify/roots.wgsl", "certify/planes.wgsl", "certify/cut.wgsl"])),
        false => parts.extend(files(["certify/whole.wgsl"])),
    }
}

/// A step of a certified frame whose spheres a device holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Step {
    /// The device places spheres: each becomes a record.
    Place,
    /// The large spheres among those that the host placed are cut into pieces.
    Guests,
    /// Each sphere of few pixels visits its pixels.
    Small {
        /// Whether rays go through samples of the pixels, not through their centres.
        samples: bool,
        /// Whether planes cut some.
        planes: bool,
    },
    /// Each piece of a large sphere visits its pixels.
    Large {
        /// Whether rays go through samples of the pixels, not through their centres.
        samples: bool,
        /// Whether planes cut some.
        planes: bool,
    },
    /// Rays leave from the hits toward the sky and lights.
    Sky,
    /// The rays toward the sky are added up at each hit.
    SkySums,
    /// The rays of neighbours are put together.
    Smooth,
    /// The pixels that are not proved are listed.
    Unsure,
    /// Words that the host decided are written to a buffer.
    Scatter,
    /// The colours of a sample are added to a picture.
    Picture {
        /// The spheres have individual colours.
        colors: bool,
    },
}

/// The parts that give the place of a pixel's ray: its centre, or a sample.
fn position(samples: bool) -> Vec<Part> {
    match samples {
        true => files(["hash.wgsl", "main/sample.wgsl"]).collect(),
        false => files(["main/pixel_center.wgsl"]).collect(),
    }
}

/// The shader of a step.
pub(crate) fn compose_step(step: Step) -> Source {
    let mut parts = vec![binding_numbers(), sizes()];
    parts.extend(files(["view.wgsl", "math.wgsl", "place/placing.wgsl", "place/rectangle.wgsl"]));
    let (samples, planes, main) = match step {
        Step::Place => {
            parts.extend(files(["place/float64.wgsl", "place/low.wgsl", "place/cut.wgsl", "place/place.wgsl"]));
            return Source::new(parts);
        }
        Step::Guests => {
            parts.extend(files(["place/cut.wgsl", "place/guests.wgsl"]));
            return Source::new(parts);
        }
        Step::Sky => {
            let given = [
                "certify/constants.wgsl",
                "certify/given_constants.wgsl",
                "search/placed.wgsl",
                "certify/given.wgsl",
                "certify/given_any.wgsl",
            ];
            let mut parts = vec![binding_numbers()];
            parts.extend(files(["view.wgsl", "math.wgsl", "hash.wgsl"]));
            parts.extend(files(given));
            parts.extend(files(["search/tree.wgsl", "main/sky_rays.wgsl", "main/sky.wgsl"]));
            return Source::new(parts);
        }
        Step::SkySums | Step::Smooth | Step::Unsure | Step::Scatter | Step::Picture { .. } => {
            return Source::new(picture(step));
        }
        Step::Small { samples, planes } => (samples, planes, "splat/small.wgsl"),
        Step::Large { samples, planes } => (samples, planes, "splat/large.wgsl"),
    };
    parts.extend(files(["main/window.wgsl"]));
    parts.extend(position(samples));
    parts.extend(files(["certify/constants.wgsl", "certify/projection.wgsl"]));
    parts.extend(files([
        "certify/projected.wgsl",
        "splat/order.wgsl",
        "splat/frame.wgsl",
        "splat/list.wgsl",
        "splat/splat.wgsl",
        main,
    ]));
    match planes {
        true => {
            parts.extend(files(["certify/detail.wgsl", "certify/roots.wgsl", "certify/planes.wgsl", "splat/cut.wgsl"]))
        }
        false => parts.extend(files(["splat/whole.wgsl"])),
    }
    Source::new(parts)
}

/// The parts of a step of a picture whose colours a device computes.
fn picture(step: Step) -> Vec<Part> {
    let mut parts = vec![binding_numbers(), sizes()];
    parts.extend(files(["view.wgsl", "math.wgsl", "main/window.wgsl"]));
    match step {
        Step::SkySums => {
            parts.extend(files(["hash.wgsl", "main/sky_rays.wgsl", "place/placing.wgsl", "splat/list.wgsl"]));
            parts.extend(files(["picture/record.wgsl", "picture/means.wgsl", "picture/sky_sums.wgsl"]));
        }
        Step::Smooth => {
            parts.push(emitted("emitted: limits of smoothing", of_smoothing()));
            parts.extend(files(["picture/record.wgsl", "picture/means.wgsl", "picture/smooth.wgsl"]));
        }
        Step::Unsure => parts.extend(files(["place/placing.wgsl", "splat/list.wgsl", "picture/unsure.wgsl"])),
        Step::Picture { colors } => {
            parts.extend(files(["hash.wgsl", "main/sample.wgsl", "number/f32.wgsl", "ray.wgsl", "search/placed.wgsl"]));
            parts.push(emitted("emitted: limits of lines", of_lines()));
            parts.extend(files(["shade/world.wgsl", "picture/record.wgsl", "picture/line.wgsl"]));
            parts.extend(files(["picture/picture.wgsl"]));
            parts.extend(colors_of_spheres(colors));
        }
        _ => parts.extend(files(["picture/scatter.wgsl"])),
    }
    parts
}

/// The sizes that the host and the shaders share.
fn sizes() -> Part {
    emitted("emitted: sizes", declarations())
}

/// World normals and colours, if computed.
fn shade(kernel: &Kernel, parts: &mut Vec<Part>) {
    if kernel.has_normals() || kernel.leaves_starts() {
        parts.extend(files(["shade/world.wgsl", "shade/world_normal.wgsl"]));
    }
    let Some(shade) = kernel.shade else { return };
    let by = match shade {
        Shade::Flat => "shade/flat.wgsl",
        Shade::Normal => "shade/normal.wgsl",
        Shade::Headlight => "shade/headlight.wgsl",
    };
    parts.extend(files([by, "shade/color.wgsl"]));
    if shade.needs_colors() {
        match kernel.face_colors {
            true => parts.extend(files(["shade/face_color.wgsl"])),
            false => parts.extend(colors_of_spheres(kernel.colors)),
        }
    }
}

/// `sphere_color`: from a buffer where spheres have individual colours.
fn colors_of_spheres(individual: bool) -> Vec<Part> {
    if individual { files(["shade/sphere_color.wgsl"]).collect() } else { vec![default_color()] }
}

/// The binding number of every buffer: its index in [`buffers`].
pub(crate) fn binding_numbers() -> Part {
    let number = |(number, name): (usize, &str)| format!("const BIND_{}: u32 = {number}u;\n", name.to_uppercase());
    emitted("emitted: binding numbers", buffers().enumerate().map(number).collect())
}

/// The output buffers of a kernel, and `write_outputs`, which stores a pixel's values in them, as bits.
fn outputs(kernel: &Kernel) -> Part {
    let (mut buffers, mut stores) = (String::new(), String::new());
    let pixels = if kernel.has_pixels() { "view.columns * view.rows" } else { "view.width" };
    for (buffer, _) in KernelOutput::buffers(kernel) {
        let binding = buffer.to_uppercase();
        buffers += &format!("@group(0) @binding(BIND_{binding}) var<storage, read_write> {buffer}: array<u32>;\n");
        for (KernelOutput { name, number, value, channels, .. }, before) in KernelOutput::in_buffer(kernel, buffer) {
            let bits = if *channels == 1 { "u32".into() } else { format!("vec{channels}<u32>") };
            let value = if *number == "u32" { (*value).into() } else { format!("bitcast<{bits}>({value})") };
            let first = if before == 0 { String::new() } else { format!("{before}u * {pixels} + ") };
            if *channels == 1 {
                stores += &format!("    {buffer}[{first}pixel] = {value};\n");
                continue;
            }
            stores += &format!("    let {name} = {value};\n");
            for channel in 0..*channels {
                stores += &format!("    {buffer}[{first}{channels}u * pixel + {channel}u] = {name}[{channel}];\n");
            }
        }
    }
    let text = format!("{buffers}\nfn write_outputs(pixel: u32, ray: Ray, hit: Hit) {{\n{stores}}}\n");
    emitted("emitted: outputs", text)
}

/// `sphere_color` for a scene without colours, for which no colours are uploaded.
fn default_color() -> Part {
    let [red, green, blue] = DEFAULT_COLOR;
    let color = format!("vec3<f32>({red:?}, {green:?}, {blue:?})");
    emitted("emitted: default colour", format!("fn sphere_color(id: u32) -> vec3<f32> {{\n    return {color};\n}}\n"))
}

fn emitted(name: &'static str, text: String) -> Part {
    Part { name, text: (text + "\n").into() }
}
