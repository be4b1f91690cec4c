//! Figures without pixels: the visible part of every sphere as closed lines of arcs, sharp at any size. The outlines of spheres and the
//! circles in which two cross are ellipses under a camera in front of which all spheres lie, so every line is an arc of an ellipse.

mod cells;
mod circle;
mod path;
mod regions;

use circle::{Ball, Projection};
use glam::{DVec2, DVec3};
use halfline::camera::Lens;
use halfline::error::{Error, Result};
use halfline::frame::srgb::level;
use halfline::scene::{DEFAULT_COLOR, Scene};
use regions::Regions;
use std::collections::HashSet;
use std::fmt::Write;

pub use regions::Region;

#[cfg(test)]
mod tests;

/// The figure of a scene.
///
/// ```
/// use halfline::{Camera, ImagePlane, Lighting, Scene, Spheres};
/// use halfline_drawing::figure::Figure;
///
/// let mut spheres = Spheres::default();
/// spheres.push([-0.4, 0.0, -4.0], 1.0, Some([0.8, 0.1, 0.1]));
/// spheres.push([0.8, 0.0, -4.5], 1.0, Some([0.1, 0.3, 0.8]));
/// let image = ImagePlane { width: 400, height: 300, ..ImagePlane::default() };
/// let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Lighting::default() };
/// let figure = Figure::new(&scene)?;
/// assert_eq!(figure.regions().len(), 2);
/// assert!(figure.svg(&scene).contains("<path id=\"s1\""));
/// # Ok::<(), halfline::Error>(())
/// ```
pub struct Figure {
    projection: Projection,
    size: [u32; 2],
    regions: Regions,
}

impl Figure {
    /// The visible parts of the spheres of a scene. Equal spheres count as the first of them.
    ///
    /// # Errors
    /// [`Error::Settings`] for a curved lens, for spheres around the eye and across its plane, for translucent spheres, and for planes that
    /// cut spheres; errors of the camera.
    pub fn new(scene: &Scene) -> Result<Self> {
        let refused =
            |problem: &str, mend: &str| Err(Error::settings(format!("a figure without pixels: {problem}"), mend));
        if scene.spheres.is_translucent() {
            return refused("spheres are translucent", "remove the opacity, or write a PNG");
        }
        if scene.spheres.cuts.is_some() {
            return refused("planes cut spheres", "remove the planes, or write a PNG");
        }
        let projection = projection(scene)?;
        let basis = scene.camera.basis()?;
        let ball = |(center, radius): (&[f64; 3], &f64)| {
            let away = DVec3::from_array(*center) - basis.e;
            Ball { center: DVec3::new(away.dot(basis.u), away.dot(basis.v), away.dot(basis.w)), radius: *radius }
        };
        let (mut ids, mut balls, mut known) = (Vec::new(), Vec::new(), HashSet::new());
        for (id, sphere) in (0..).zip(scene.spheres.centers.iter().zip(&scene.spheres.radii)) {
            let Ball { center, radius } = ball(sphere);
            if center.z.abs() <= radius {
                return refused("a sphere lies across the plane of the eye", "move the eye away, or write a PNG");
            }
            if center.z < 0.0 && known.insert((sphere.0.map(f64::to_bits), radius.to_bits())) {
                ids.push(id);
                balls.push(Ball { center, radius });
            }
        }
        let size = [scene.image.width, scene.image.height];
        let mut regions = Regions::of(&balls, &projection, DVec2::new(size[0].into(), size[1].into()));
        regions.regions.iter_mut().for_each(|region| region.sphere = ids[region.sphere as usize]);
        Ok(Self { projection, size, regions })
    }

    /// The visible parts, by the ids of their spheres.
    #[must_use]
    pub fn regions(&self) -> &[Region] {
        &self.regions.regions
    }

    /// The number of lines that were closed by a straight one, because arithmetic in f64 did not tell where they go on.
    #[must_use]
    pub fn joined(&self) -> usize {
        self.regions.joined
    }

    /// The `d` of the path of a region in SVG, in pixels of the image, to 1e-4.
    #[must_use]
    pub fn path(&self, region: &Region) -> String {
        self.regions.path(region, &self.projection)
    }

    /// The figure as SVG: a path for each sphere, with its id, in its colour, over the background of the scene.
    #[must_use]
    pub fn svg(&self, scene: &Scene) -> String {
        let [width, height] = self.size;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" fill-rule=\"evenodd\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
            hex(scene.image.background)
        );
        for region in self.regions() {
            let color = scene.spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[region.sphere as usize]);
            let (id, path) = (region.sphere, self.path(region));
            let _ = writeln!(svg, "<path id=\"s{id}\" fill=\"{}\" d=\"{path}\"/>", hex(color));
        }
        svg + "</svg>\n"
    }
}

/// Linear RGB as a colour of SVG.
fn hex(color: [f32; 3]) -> String {
    let [red, green, blue] = color.map(level);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The camera, from its coordinates to pixels.
fn projection(scene: &Scene) -> Result<Projection> {
    let [width, height] = [scene.image.width, scene.image.height];
    let size = DVec2::new(width.into(), height.into());
    match scene.camera.lens {
        Lens::Curved { .. } => {
            let problem = "a figure without pixels: a curved lens does not show spheres as ellipses";
            Err(Error::settings(problem, "use a perspective or parallel camera, or write a PNG"))
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
