//! Constants that the host and the shaders share; compose.rs writes them into the shaders.

use crate::answers::{open_sky, silhouette};
use crate::kernel::Generals;

/// A value that WGSL has as a constant.
trait Constant {
    /// Its type and its value in WGSL.
    fn words(&self) -> [String; 2];
}

impl Constant for u32 {
    fn words(&self) -> [String; 2] {
        ["u32".into(), format!("{self}u")]
    }
}

impl Constant for f32 {
    /// The fewest digits that read back as the same f32.
    fn words(&self) -> [String; 2] {
        ["f32".into(), format!("{self:?}f")]
    }
}

/// A number of the host that f32 holds.
impl Constant for f64 {
    fn words(&self) -> [String; 2] {
        (*self as f32).words()
    }
}

impl Constant for [f64; 2] {
    fn words(&self) -> [String; 2] {
        let [x, y] = self.map(|x| x.words()[1].clone());
        ["vec2<f32>".into(), format!("vec2<f32>({x}, {y})")]
    }
}

fn declared(constants: &[(&str, &dyn Constant)]) -> String {
    let line = |(name, constant): &(&str, &dyn Constant)| {
        let [of, value] = constant.words();
        format!("const {name}: {of} = {value};\n")
    };
    constants.iter().map(line).collect()
}

/// The declarations of the limits and widths of lines.
pub(crate) fn of_lines() -> String {
    declared(&LINES)
}

/// The declarations of the limits between pixels whose rays toward the sky are put together.
pub(crate) fn of_smoothing() -> String {
    declared(&SMOOTHING)
}

/// The constants of shaders/picture/line.wgsl.
const LINES: [(&str, &dyn Constant); 8] = [
    ("GAP", &silhouette::GAP),
    ("CLOSE", &silhouette::CLOSE),
    ("DESCENT", &silhouette::DESCENT),
    ("SUM_LENGTH", &silhouette::SUM_LENGTH),
    ("STRAIGHT", &silhouette::STRAIGHT),
    ("NEIGHBOURS", &silhouette::NEIGHBOURS),
    ("DIAMETER", &silhouette::DIAMETER),
    ("COMPANY", &silhouette::COMPANY),
];

/// The constants of shaders/picture/smooth.wgsl.
const SMOOTHING: [(&str, &dyn Constant); 2] = [("ALIKE", &open_sky::ALIKE), ("WIDE", &open_sky::WIDE)];

macro_rules! sizes {
    ($($(#[$doc:meta])* $name:ident $value:expr;)*) => {
        $($(#[$doc])* pub(crate) const $name: u32 = $value;)*

        /// Their declarations in WGSL.
        pub(crate) fn declarations() -> String {
            declared(&[$((stringify!($name), &$name)),*])
        }
    };
}

sizes! {
    /// The most spheres of a frame that the host places.
    HOST_SPHERES 1 << 16;
    /// The most pieces of large spheres.
    PIECES 1 << 20;
    /// The most pairs of an unsure pixel and a sphere.
    PAIRS 1 << 20;
    /// First word of the summary: bounds of the depths of spheres that certainly appear.
    SUMMARY_DEPTHS 0;
    /// Bounds of the depths of spheres that may appear.
    SUMMARY_PERHAPS 2;
    /// The number of spheres for the host.
    SUMMARY_HOST 4;
    /// The number of pieces.
    SUMMARY_PIECES 5;
    /// The number of pairs.
    SUMMARY_PAIRS 6;
    /// Above 0 where pieces are too many to be counted.
    SUMMARY_MORE 7;
    /// The least slot of the spheres aside that may be general; more than any slot where there is none.
    SUMMARY_MISSED 8;
    /// First word of the list of spheres for the host.
    SUMMARY_LIST 9;
    /// Pixels along a side of a piece.
    PIECE 32;
    /// The most pieces of this size of a sphere; beyond, its pieces are wider.
    CUT 1 << 14;
    /// The widest pieces are 2^COARSEST times as wide.
    COARSEST 3;
    /// The most pixels of a sphere that one invocation visits.
    MAX_PIXELS_PER_INVOCATION 256;
    /// The most general spheres in a uniform.
    MAX_GENERALS_WITHOUT_LISTS Generals::MAX_WITHOUT_LISTS as u32;
    /// Steps through a tree of an invocation before it is left to the host. Each is at most three iterations of loops, and
    /// llvmpipe ends the loops of a vector of up to 16 invocations after 65,536 iterations together.
    STEPS 1300;
    /// Pass of shaders/splat: the least depth of each pixel.
    LEAST 0;
    /// Pass of shaders/splat: the slot of that sphere, and the second least depth.
    SLOTS 1;
    /// Pass of shaders/splat: the pairs of unsure pixels.
    PAIRS_OF_UNSURE 2;
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::{Expression, Literal};

    /// The bits of a constant that naga read.
    fn bits(module: &naga::Module, name: &str) -> Vec<u32> {
        let constant = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name));
        let all = |init| match &module.global_expressions[init] {
            Expression::Literal(literal) => vec![literal],
            Expression::Compose { components, .. } => components
                .iter()
                .map(|part| match &module.global_expressions[*part] {
                    Expression::Literal(literal) => literal,
                    other => panic!("{name}: {other:?}"),
                })
                .collect(),
            other => panic!("{name}: {other:?}"),
        };
        let number = |literal: &Literal| match literal {
            Literal::F32(x) => x.to_bits(),
            Literal::U32(n) => *n,
            other => panic!("{name}: {other:?}"),
        };
        all(constant.expect(name).1.init).into_iter().map(number).collect()
    }

    #[test]
    fn shaders_have_the_bits_of_the_host() {
        let module = naga::front::wgsl::parse_str(&[declarations(), of_lines(), of_smoothing()].concat());
        let module = module.expect("declarations");
        assert_eq!(bits(&module, "STEPS"), [STEPS]);
        assert_eq!(bits(&module, "WIDE"), [open_sky::WIDE]);
        assert_eq!(bits(&module, "ALIKE"), [open_sky::ALIKE.to_bits()]);
        let single = |x: f64| {
            assert_eq!(f64::from(x as f32), x, "f32 holds it");
            (x as f32).to_bits()
        };
        use silhouette::{CLOSE, COMPANY, DESCENT, DIAMETER, GAP, NEIGHBOURS, STRAIGHT, SUM_LENGTH};
        for (name, x) in [("CLOSE", CLOSE), ("DESCENT", DESCENT), ("STRAIGHT", STRAIGHT), ("NEIGHBOURS", NEIGHBOURS)] {
            assert_eq!(bits(&module, name), [single(x)], "{name}");
        }
        for (name, limits) in [("GAP", GAP), ("SUM_LENGTH", SUM_LENGTH), ("DIAMETER", DIAMETER), ("COMPANY", COMPANY)] {
            assert_eq!(bits(&module, name), limits.map(single), "{name}");
        }
        // Of numbers with many digits, least and largest ones.
        for x in [0.1, 1.0 / 3.0, f32::MIN_POSITIVE, f32::MAX, 1e-7, 16_777_217.0] {
            let module = naga::front::wgsl::parse_str(&declared(&[("X", &x)])).expect("a declaration");
            assert_eq!(bits(&module, "X"), [x.to_bits()], "{x:?}");
        }
    }
}
