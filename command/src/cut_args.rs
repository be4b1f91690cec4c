//! The options for planes that cut spheres.

use super::read_args::{LOOK, Rule, plane};
use super::values::{color, numbers};
use clap::Args;
use halfline::scene::CutPlane;
use halfline_files::read::Selection;
use halfline_files::read::cut::{CutAt, CutRules};

/// The options for planes that cut spheres.
#[derive(Debug, Args)]
#[command(next_help_heading = LOOK)]
pub(super) struct PlaneArgs {
    /// Cuts spheres by a plane: what has X,Y,Z . p > D is removed, and spheres that the plane passes through show their inside. May be
    /// repeated: what one plane removes is removed.
    #[arg(long, value_name = "X,Y,Z,D", value_parser = plane, allow_hyphen_values = true)]
    cut: Vec<[f64; 4]>,
    /// Keeps a slab, A <= X,Y,Z . p <= B, between two planes that cut spheres.
    #[arg(long, value_name = "X,Y,Z,A,B", value_parser = slab, allow_hyphen_values = true)]
    cut_slab: Vec<[f64; 5]>,
    /// Cuts spheres by the plane through the mean of the centres that EXPR selects. X,Y,Z points to what is removed [default: back along
    /// the view, so that the camera looks at the cut].
    #[arg(long, value_name = "EXPR[:X,Y,Z]", value_parser = at)]
    cut_at: Vec<CutAt>,
    /// Planes cut only the spheres that EXPR selects; the others stay whole.
    #[arg(long, value_name = "EXPR")]
    cut_only: Option<Selection>,
}

/// The options for planes that cut spheres, and for their faces.
#[derive(Debug, Args)]
#[command(next_help_heading = LOOK)]
pub(super) struct CutArgs {
    #[command(flatten)]
    planes: PlaneArgs,
    /// Colour of the faces that planes cut, or with EXPR=C of the faces of selected spheres, as --color takes it
    /// [default: the colour of each sphere]. Repeated, later ones win.
    #[arg(long, value_name = "[EXPR=]C", value_parser = face_color)]
    cut_color: Vec<Rule<[f32; 3]>>,
}

impl PlaneArgs {
    /// Whether spheres are selected by their columns.
    pub(super) fn selects(&self) -> bool {
        !self.cut_at.is_empty() || self.cut_only.is_some()
    }

    pub(super) fn rules(&self) -> CutRules {
        let plane = |[x, y, z, distance]: [f64; 4]| CutPlane { normal: [x, y, z], distance };
        let slabs = self.cut_slab.iter().flat_map(|[x, y, z, a, b]| [[*x, *y, *z, *b], [-x, -y, -z, -a]]);
        let planes = self.cut.iter().copied().chain(slabs).map(plane).collect();
        CutRules { planes, at: self.cut_at.clone(), only: self.cut_only.clone(), ..CutRules::default() }
    }
}

impl CutArgs {
    /// Whether some option of cuts is given.
    pub(super) fn is_given(&self) -> bool {
        let PlaneArgs { cut, cut_slab, .. } = &self.planes;
        !(cut.is_empty() && cut_slab.is_empty()) || self.need_all()
    }

    /// Whether cuts need the columns or the colours of all spheres.
    pub(super) fn need_all(&self) -> bool {
        self.selects() || !self.cut_color.is_empty()
    }

    /// Whether spheres are selected by their columns.
    pub(super) fn selects(&self) -> bool {
        self.planes.selects() || !Rule::selected(&self.cut_color).is_empty()
    }

    pub(super) fn rules(&self) -> CutRules {
        let (color, colors) = (Rule::for_all(&self.cut_color), Rule::selected(&self.cut_color));
        CutRules { color, colors, ..self.planes.rules() }
    }
}

fn face_color(text: &str) -> Result<Rule<[f32; 3]>, String> {
    Rule::parse(text, color)
}

fn slab(text: &str) -> Result<[f64; 5], String> {
    let slab = numbers(text).filter(|p: &[f64; 5]| p[..3] != [0.0; 3]);
    let slab = slab.ok_or("expected a direction and two numbers, such as 0,0,1,-2.5,2.5")?;
    if slab[3] < slab[4] { Ok(slab) } else { Err(format!("nothing lies from {} to {}", slab[3], slab[4])) }
}

/// An expression, and a direction behind its last colon.
fn at(text: &str) -> Result<CutAt, String> {
    let (selection, direction) = match text.rsplit_once(':') {
        Some((selection, last)) if last.contains(',') => (selection, Some(last)),
        _ => (text, None),
    };
    let direction = direction.map(|direction| {
        let some = numbers(direction).filter(|direction| *direction != [0.0; 3]);
        some.ok_or_else(|| "expected a direction behind the colon, such as resname HEM:0,0,1".to_owned())
    });
    let selection = selection.parse::<Selection>().map_err(|error| error.to_string())?;
    Ok(CutAt { selection, direction: direction.transpose()? })
}
