//! Figures without pixels: the visible part of every sphere as closed lines of arcs, sharp at any size. The outlines of spheres, the
//! circles in which two cross and the circles in which planes cut them are ellipses where all spheres lie in front of the camera. So every line
//! is an arc of an ellipse, or straight.

mod cells;
mod circle;
mod curves;
mod paint;
mod path;
mod pdf;
mod regions;
mod solids;
mod svg;
mod wave;
mod xml;

use super::inset::Panels;
use cells::Extent;
use circle::{Ball, Plane, Projection};
use glam::{DVec2, DVec3};
use halfline::camera::Lens;
use halfline::error::{Error, Result};
use halfline::frame::outline::Outline;
use halfline::frame::report::FigureCounts;
use halfline::frame::srgb::level;
use halfline::frame::tone::Toning;
use halfline::scene::{CUT, DEFAULT_COLOR, REMOVED, SPARED, Scene, Spheres};
use halfline::shade::Shade;
use paint::{Group, Lines, Page, Paint, Path};
use regions::{Region, Regions};
use solids::{Cut, Solids};
use std::collections::{BTreeMap, HashMap, HashSet};

pub use solids::Surface;

#[cfg(test)]
mod tests;

/// The look of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureStyle {
    /// The shading: `Headlight` paints spheres with gradients, `Flat` with their colours.
    pub shade: Shade,
    /// Tone and exposure of the colours.
    pub toning: Toning,
    /// The lines where the depth jumps, and around faces; `None` for none.
    pub outline: Option<Outline>,
    /// Whether the figure has no background.
    pub transparent: bool,
    /// Spheres and parts of them that are smaller than this are left out, pixels.
    pub detail: f64,
    /// The pixels in an inch of paper.
    pub dpi: Option<u32>,
}

impl FigureStyle {
    /// The usual detail, pixels.
    pub const DETAIL: f64 = 0.1;
}

impl Default for FigureStyle {
    fn default() -> Self {
        let (shade, toning, detail) = (Shade::default(), Toning::default(), Self::DETAIL);
        Self { shade, toning, outline: None, transparent: false, detail, dpi: None }
    }
}

/// The names of the spheres of a figure: values of columns.
pub struct FigureNames<'a> {
    /// The names of the columns; the first `groups` columns have groups of paths.
    pub columns: Vec<String>,
    /// The number of columns whose values together are a group of paths.
    pub groups: usize,
    /// The value of a column, by its number, for a sphere.
    pub value: &'a dyn Fn(usize, u32) -> String,
}

/// The figure of a scene.
///
/// ```
/// use halfline::{Camera, ImagePlane, Lighting, Scene, Spheres};
/// use halfline_drawing::figure::{Figure, FigureStyle};
///
/// let mut spheres = Spheres::default();
/// spheres.push([-0.4, 0.0, -4.0], 1.0, Some([0.8, 0.1, 0.1]));
/// spheres.push([0.8, 0.0, -4.5], 1.0, Some([0.1, 0.3, 0.8]));
/// let image = ImagePlane { width: 400, height: 300, ..ImagePlane::default() };
/// let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Lighting::default() };
/// let figure = Figure::new(&scene, FigureStyle::default(), None)?;
/// assert_eq!(figure.counts().paths, 2);
/// assert!(figure.svg(None).contains("<path id=\"s1\""));
/// # Ok::<(), halfline::Error>(())
/// ```
pub struct Figure {
    page: Page,
    counts: FigureCounts,
    surfaces: Vec<Surface>,
}

/// The gap in depth, pixels, from which a line is drawn: at the middle of those from which lines of pictures appear to those where they are
/// full.
const JUMP: f64 = 16.0;

/// The window of the image in which lines are drawn is wider on each side by so many pixels, and by the width of outlines.
const MARGIN: f64 = 8.0;

impl Figure {
    /// The visible parts of the spheres of a scene, with names for groups and attributes. Equal spheres count as the first of
    /// them, or as the first that no plane may cut.
    ///
    /// # Errors
    /// [`Error::Settings`] for what has no outlines that are ellipses, or no colours that are gradients: a curved lens, spheres around the eye
    /// and across its plane, translucent, mirroring and glass spheres, lights, a sky, the shading by normals; errors of the camera.
    pub fn new(scene: &Scene, style: FigureStyle, names: Option<&FigureNames<'_>>) -> Result<Self> {
        refuse(scene, style)?;
        let projection = projection(scene)?;
        let (solids, ids, mut small) = solids(scene, projection, style.detail)?;
        let size = DVec2::new(scene.image.width.into(), scene.image.height.into());
        let margin = DVec2::splat(MARGIN + style.outline.map_or(0.0, |outline| outline.width));
        let groups: Option<Vec<Vec<String>>> = names.filter(|names| names.groups > 0).map(|names| {
            ids.iter().map(|id| (0..names.groups).map(|column| (names.value)(column, *id)).collect()).collect()
        });
        // Parts of one colour in one group are one path; a gradient belongs to one sphere.
        let is_merged = groups.is_some() && style.shade == Shade::Flat;
        let mut known: HashMap<(&[String], [u8; 3]), Surface> = HashMap::new();
        let mut keys: HashMap<Surface, Surface> = HashMap::new();
        let colors = Colors { scene, style };
        if let Some(groups) = groups.as_ref().filter(|_| is_merged) {
            for (n, group) in (0..).zip(groups) {
                for surface in [Surface::of(n), Surface { sphere: n, face: Some(u32::MAX) }] {
                    let color = colors.flat(ids[n as usize], surface.face.is_some(), 1.0);
                    keys.insert(surface, *known.entry((group, color)).or_insert(surface));
                }
            }
        }
        let key = |surface: Surface| {
            let of = Surface { face: surface.face.map(|_| u32::MAX), ..surface };
            keys.get(&of).copied().unwrap_or(surface)
        };
        let jump = style.outline.map(|_| JUMP);
        let Regions { curves, mut regions, jumps, joined } = Regions::of(&solids, [-margin, size + margin], jump, key);
        let parts = regions.len();
        regions.retain(|region| {
            let [low, high] = region.bounds(&curves, &projection);
            (high - low).max_element() >= style.detail
        });
        small += parts - regions.len();
        // Far ones first, so that lines of near ones lie over them.
        regions.sort_by(|a, b| {
            let depth = |region: &Region| solids.balls[region.surface.sphere as usize].center.z;
            depth(a).total_cmp(&depth(b)).then(a.surface.cmp(&b.surface))
        });
        let regions = Regions { curves, regions, jumps, joined };
        let mut by_group: BTreeMap<&[String], Vec<Path>> = BTreeMap::new();
        let (mut gradients, mut known, mut surfaces) = (Vec::new(), HashMap::new(), Vec::new());
        for region in &regions.regions {
            let n = region.surface.sphere as usize;
            let face = region.surface.face;
            let id = ids[n];
            let paint = match (style.shade, face) {
                (Shade::Headlight, None) => {
                    let color = colors.own(id, false);
                    let stops = *known.entry(color.map(f32::to_bits)).or_insert_with(|| {
                        gradients.push(paint::gradient(color, style.toning));
                        gradients.len() - 1
                    });
                    paint::outline(&solids.balls[n], &projection).map_or(
                        Paint::Flat(colors.flat(id, false, 1.0)),
                        |(matrix, focus)| Paint::Radial { stops, matrix, focus },
                    )
                }
                (Shade::Headlight, Some(plane)) => {
                    Paint::Flat(colors.flat(id, true, solids.cosine(region.surface.sphere, plane)))
                }
                _ => Paint::Flat(colors.flat(id, face.is_some(), 1.0)),
            };
            let group: &[String] = groups.as_ref().map_or(&[], |groups| &groups[n]);
            let name = match face {
                None => format!("s{id}"),
                Some(u32::MAX) => format!("s{id}-cut"),
                Some(plane) => format!("s{id}-cut{plane}"),
            };
            let values = names.filter(|_| !is_merged);
            let values = values.map(|names| {
                let value = |column: usize| (xml::name(&names.columns[column]), (names.value)(column, id));
                (names.groups..names.columns.len()).map(value).collect()
            });
            let steps = regions.path(region, &projection);
            surfaces.push(Surface { sphere: id, face });
            by_group.entry(group).or_default().push(Path { name, data: values.unwrap_or_default(), steps, paint });
        }
        let named = |values: &[String]| {
            let names = names?;
            (names.groups > 0)
                .then(|| (0..names.groups).map(|k| (xml::name(&names.columns[k]), values[k].clone())).collect())
        };
        let mut taken = HashSet::new();
        let groups = by_group.into_iter().map(|(values, paths)| {
            let data: Option<Vec<(String, String)>> = named(values);
            let id = data.as_ref().map(|data| {
                let words: Vec<String> =
                    data.iter().map(|(name, value)| format!("{name}-{}", xml::name(value))).collect();
                let id = words.join("-");
                let free = (1..).map(|n| if n == 1 { id.clone() } else { format!("{id}-{n}") });
                free.into_iter().find(|id| taken.insert(id.clone())).unwrap_or(id)
            });
            Group { id, data: data.unwrap_or_default(), paths }
        });
        let groups: Vec<Group> = groups.collect();
        let page = Page {
            size: [size.x, size.y],
            dpi: style.dpi,
            background: (!style.transparent).then(|| style.toning.of(scene.image.background).map(level)),
            gradients,
            lines: style.outline.map(|outline| Lines {
                color: style.toning.of(outline.color).map(level),
                width: outline.width,
                steps: regions.path_of_jumps(&projection),
            }),
            groups,
        };
        let joined = regions.joined;
        let counts =
            FigureCounts { paths: surfaces.len() as u64, small: small as u64, joined: joined as u64, bytes: 0 };
        Ok(Self { page, counts, surfaces })
    }

    /// The counts of the figure.
    #[must_use]
    pub fn counts(&self) -> FigureCounts {
        self.counts
    }

    /// The surface of each path, with the `d` of the path in SVG: in pixels of the image, to 1e-4; without groups in the order of the paths.
    pub fn paths(&self) -> impl Iterator<Item = (Surface, String)> {
        let paths = self.page.groups.iter().flat_map(|group| &group.paths);
        self.surfaces.iter().copied().zip(paths).map(|(surface, path)| (surface, svg::d(&path.steps)))
    }

    /// The figure as SVG: a path for each sphere, with its id, over the background of the scene, and below panels.
    #[must_use]
    pub fn svg(&self, panels: Option<&Panels>) -> String {
        svg::write(&self.page, panels.into_iter().flat_map(Panels::sheets))
    }

    /// The figure as PDF, of one page; arcs are cubic curves within 1e-4 pixels.
    #[must_use]
    pub fn pdf(&self, panels: Option<&Panels>) -> Vec<u8> {
        pdf::write(&self.page, panels.into_iter().flat_map(Panels::sheets))
    }
}

/// The colours of a scene.
struct Colors<'a> {
    scene: &'a Scene,
    style: FigureStyle,
}

impl Colors<'_> {
    /// Linear RGB of a sphere, or of its faces.
    fn own(&self, id: u32, is_face: bool) -> [f32; 3] {
        let Spheres { colors, cuts, .. } = &self.scene.spheres;
        let faces = cuts.as_ref().and_then(|cuts| cuts.colors.as_ref()).filter(|_| is_face);
        faces.or(colors.as_ref()).map_or(DEFAULT_COLOR, |colors| colors[id as usize])
    }

    /// sRGB of a sphere, or of its faces, under light of a cosine.
    fn flat(&self, id: u32, is_face: bool, cosine: f64) -> [u8; 3] {
        paint::lighted(self.own(id, is_face), cosine, self.style.toning)
    }
}

impl Solids {
    /// The cosine between the normal of a face and the way back to the eye, at the middle of the face.
    fn cosine(&self, ball: u32, plane: u32) -> f64 {
        let plane = &self.cuts[plane as usize].plane;
        let center = self.balls[ball as usize].center;
        let middle = center - plane.height(center) * plane.normal;
        -plane.normal.dot(self.projection.way(middle).normalize())
    }
}

/// Returns an error for what a figure cannot show.
fn refuse(scene: &Scene, style: FigureStyle) -> Result<()> {
    let spheres = &scene.spheres;
    let no_gradients = style.shade == Shade::Normal;
    let [has_lights, has_sky] = [!scene.lighting.lights.is_empty(), scene.lighting.sky.is_some()];
    let cases = [
        (spheres.is_translucent(), "spheres are translucent", "remove the opacity"),
        (spheres.materials.is_some(), "spheres are mirrors, of glass or shine", "remove the materials"),
        (has_lights, "the scene has lights", "remove the suns, the shadows and the lights of the scene file"),
        (has_sky, "the scene has a sky", "remove the occlusion and the sky of the scene file"),
        (no_gradients, "normals as colours are no gradients", "use the shading flat or headlight"),
    ];
    match cases.into_iter().find(|(is_there, ..)| *is_there) {
        Some((_, problem, mend)) => Err(refused(problem, mend)),
        None => Ok(()),
    }
}

/// The error for a picture that a figure cannot show, with a mend besides pixels.
#[must_use]
pub fn refused(problem: &str, mend: &str) -> Error {
    Error::settings(format!("a figure without pixels: {problem}"), format!("{mend}, or write a PNG"))
}

/// The spheres in the camera's coordinates, with their ids; and the number of those that are smaller than `detail`.
fn solids(scene: &Scene, projection: Projection, detail: f64) -> Result<(Solids, Vec<u32>, usize)> {
    let basis = scene.camera.basis()?;
    let moved = |x: DVec3| DVec3::new(x.dot(basis.u), x.dot(basis.v), x.dot(basis.w));
    let mut solids =
        Solids { balls: Vec::new(), is_cut: Vec::new(), is_spared: Vec::new(), cuts: Vec::new(), projection };
    let (mut ids, mut small, mut farthest) = (Vec::new(), 0, 0.0_f64);
    let of = scene.spheres.cuts.as_ref().map(|cuts| &cuts.of);
    let bits = |center: &[f64; 3], radius: f64| (center.map(f64::to_bits), radius.to_bits());
    let spared = (0..).zip(of.into_iter().flat_map(|of| of.iter())).filter(|(_, flag)| **flag == SPARED);
    let whole = spared.map(|(n, _): (usize, _)| bits(&scene.spheres.centers[n], scene.spheres.radii[n]));
    let (whole, mut known): (HashSet<_>, HashSet<_>) = (whole.collect(), HashSet::new());
    for (id, (center, radius)) in (0..).zip(scene.spheres.centers.iter().zip(&scene.spheres.radii)) {
        let flag = of.map_or(0, |of| of[id as usize]);
        let ball = Ball { center: moved(DVec3::from_array(*center) - basis.e), radius: *radius };
        if flag == REMOVED {
            continue;
        }
        if ball.center.z.abs() <= ball.radius {
            return Err(refused("a sphere lies across the plane of the eye", "move the eye away"));
        }
        let bits = bits(center, *radius);
        if ball.center.z > 0.0 || flag == CUT && whole.contains(&bits) || !known.insert(bits) {
            continue;
        }
        if Extent::of(&ball, &projection).length() < detail {
            small += 1;
            continue;
        }
        farthest = farthest.max(ball.center.length() + ball.radius);
        ids.push(id);
        solids.balls.push(ball);
        solids.is_cut.push(flag == CUT);
        solids.is_spared.push(flag == SPARED);
    }
    let planes = scene.spheres.cuts.iter().flat_map(|cuts| &cuts.planes);
    solids.cuts = planes
        .map(|plane| {
            let plane = plane.in_range();
            let normal = DVec3::from_array(plane.normal);
            let (length, distance) = (normal.length(), plane.distance - normal.dot(basis.e));
            let plane = Plane { normal: moved(normal) / length, distance: distance / length };
            let is_edge_on = match projection.is_parallel {
                true => plane.normal.z.abs() < EDGE_ON,
                false => plane.distance.abs() < EDGE_ON * farthest,
            };
            Cut { plane, is_edge_on }
        })
        .collect();
    Ok((solids, ids, small))
}

/// The sine between a plane and the rays below which it is seen from its side.
const EDGE_ON: f64 = 1e-12;

/// The camera, from its coordinates to pixels.
fn projection(scene: &Scene) -> Result<Projection> {
    let [width, height] = [scene.image.width, scene.image.height];
    let size = DVec2::new(width.into(), height.into());
    match scene.camera.lens {
        Lens::Curved { .. } => {
            Err(refused("a curved lens does not show spheres as ellipses", "use a perspective or parallel camera"))
        }
        Lens::Intrinsics { fx, fy, cx, cy } => {
            Ok(Projection { middle: DVec2::new(cx, cy), scale: DVec2::new(fx, -fy), is_parallel: false })
        }
        _ => {
            let viewport = scene.camera.viewport(width, height)?;
            let is_parallel = scene.camera.lens.is_orthographic();
            let unit = if is_parallel { 1.0 } else { viewport.d };
            let scale = DVec2::new(size.x * unit / viewport.vw, -size.y * unit / viewport.vh);
            Ok(Projection { middle: 0.5 * size, scale, is_parallel })
        }
    }
}
