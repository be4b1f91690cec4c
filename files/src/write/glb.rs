//! The spheres of a scene as a binary glTF 2.0 for other programs (Khronos, ISO/IEC 12113): a mesh of points with radii and colours,
//! and the camera. Coordinates are float32 from the middle of the scene, which the node's translation holds in double precision.

use super::file::write_atomically;
use halfline::camera::{CameraRecord, Viewport};
use halfline::error::{Error, Place, Result};
use halfline::quote::setting::SELECT;
use halfline::scene::{DEFAULT_COLOR, Scene, Spheres};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::Path;

/// The most bytes of a file: readers count in 31 bits.
const MOST: u64 = i32::MAX as u64;

/// Spheres that are encoded together.
const BLOCK: usize = 1 << 16;

/// Codes of glTF: a point for each vertex, a 32-bit float, a buffer of vertices.
const POINTS: u32 = 0;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;

/// Whether a file name has the extension of a binary glTF.
#[must_use]
pub fn is_glb(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("glb"))
}

/// Writes the spheres and the camera of a scene, completely or not at all. Returns a warning about what glTF does not have: some cameras,
/// and planes that cut spheres.
///
/// # Errors
/// [`Error::Limits`] for more spheres than the format holds; [`Error::Scene`] for lengths beyond float32; [`Error::Io`].
pub fn write(path: &Path, scene: &Scene) -> Result<Option<String>> {
    let cloud = Cloud::of(&scene.spheres)?;
    let camera = camera(scene)?;
    let json = serde_json::to_vec(&cloud.document(&camera)).map_err(|error| Error::write(path, error.into()))?;
    let json = padded(json);
    let size = size(path, json.len() as u64, cloud.count() as u64, cloud.pixel())?;
    write_atomically(path, |out| {
        out.write_all(b"glTF")?;
        [2, size, json.len() as u32].iter().try_for_each(|n| out.write_all(&n.to_le_bytes()))?;
        out.write_all(b"JSON")?;
        out.write_all(&json)?;
        cloud.write(out)
    })?;
    let name = path.display();
    let lacks = [
        (camera.is_none(), "no camera: glTF has none with distortion or a principal point beside the middle"),
        (scene.spheres.cuts.is_some(), "whole spheres: points of glTF are not cut"),
    ];
    let lacks: Vec<&str> = lacks.into_iter().filter(|(lacks, _)| *lacks).map(|(_, words)| words).collect();
    Ok((!lacks.is_empty()).then(|| format!("{name} has {}", lacks.join("; and "))))
}

/// Bytes of a file with so many bytes of JSON and so many spheres of so many bytes.
///
/// # Errors
/// [`Error::Limits`] for more than [`MOST`].
fn size(path: &Path, json: u64, spheres: u64, sphere: u64) -> Result<u32> {
    let size = 12 + 8 + json + if spheres > 0 { 8 + spheres * sphere } else { 0 };
    if size <= MOST {
        return Ok(size as u32);
    }
    let problem = format!("{spheres} spheres are more than {} can hold: a GLB has 2^31 bytes", path.display());
    Err(Error::Limits { problem, mend: format!("write at most {} with {SELECT}", MOST / sphere - 1000) })
}

/// The JSON with the blanks that end its chunk at a multiple of four bytes.
fn padded(mut json: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    json
}

/// The spheres about the middle of the box around their centres.
struct Cloud<'a> {
    spheres: &'a Spheres,
    middle: [f64; 3],
    /// The least and the largest coordinates about the middle.
    ends: [[f32; 3]; 2],
}

impl<'a> Cloud<'a> {
    /// # Errors
    /// [`Error::Scene`] for lengths that float32 does not hold.
    fn of(spheres: &'a Spheres) -> Result<Self> {
        let [low, high] = ends(spheres.centers.iter().copied());
        let middle = [0, 1, 2].map(|k| if spheres.is_empty() { 0.0 } else { low[k] / 2.0 + high[k] / 2.0 });
        let mut cloud = Self { spheres, middle, ends: [[0.0; 3]; 2] };
        cloud.ends =
            ends((0..spheres.len()).map(|n| cloud.position(n).map(f64::from))).map(|end| end.map(|x| x as f32));
        let sound = |n: &usize| cloud.position(*n).iter().all(|x| x.is_finite()) && cloud.radius(*n).is_normal();
        match (0..spheres.len()).find(|n| !sound(n)) {
            None => Ok(cloud),
            Some(n) => {
                let problem = format!("the centre or the radius of sphere {n} is beyond the range of float32");
                Err(Error::scene(Place::field("spheres"), problem, "give the scene in another unit of length"))
            }
        }
    }

    fn count(&self) -> usize {
        self.spheres.len()
    }

    fn position(&self, n: usize) -> [f32; 3] {
        let center = self.spheres.centers[n];
        [0, 1, 2].map(|k| (center[k] - self.middle[k]) as f32)
    }

    fn radius(&self, n: usize) -> f32 {
        self.spheres.radii[n] as f32
    }

    /// Linear red, green and blue, and the opacity where some sphere has one.
    fn color(&self, n: usize) -> impl Iterator<Item = f32> {
        let color = self.spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[n]);
        color.into_iter().chain(self.spheres.opacities.as_ref().map(|opacities| opacities[n]))
    }

    /// Numbers of a colour.
    fn channels(&self) -> usize {
        if self.spheres.opacities.is_some() { 4 } else { 3 }
    }

    /// Bytes of a sphere.
    fn pixel(&self) -> u64 {
        4 * (3 + 1 + self.channels() as u64)
    }

    /// Bytes of all spheres.
    fn bytes(&self) -> u64 {
        self.pixel() * self.count() as u64
    }

    /// The JSON chunk, with this camera and the matrix of its node.
    fn document(&self, camera: &Option<(Value, [f64; 16])>) -> Value {
        let about = "spheres in the order of their ids: the radius of each is _RADIUS, and lengths are in the unit of the scene";
        let mut document = json!({
            "asset": {
                "version": "2.0",
                "generator": format!("halfline {}", env!("CARGO_PKG_VERSION")),
                "extras": {"about": about},
            },
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
        });
        if let Some((camera, matrix)) = camera {
            document["cameras"] = json!([camera]);
            add_node(&mut document, json!({"name": "camera", "camera": 0, "matrix": matrix}));
        }
        if self.count() > 0 {
            let blend = if self.channels() == 4 { "BLEND" } else { "OPAQUE" };
            let attributes = json!({"POSITION": 0, "_RADIUS": 1, "COLOR_0": 2});
            let mesh =
                json!({"name": "spheres", "primitives": [{"mode": POINTS, "attributes": attributes, "material": 0}]});
            document["meshes"] = json!([mesh]);
            document["materials"] = json!([{"name": "spheres", "alphaMode": blend}]);
            document["buffers"] = json!([{"byteLength": self.bytes()}]);
            (document["bufferViews"], document["accessors"]) = self.accessors();
            add_node(&mut document, json!({"name": "spheres", "mesh": 0, "translation": self.middle}));
        }
        document
    }

    /// The views of the buffer and the accessors of positions, radii and colours, one after the other.
    fn accessors(&self) -> (Value, Value) {
        let (mut offset, mut views, mut accessors) = (0, Vec::new(), Vec::new());
        let color = if self.channels() == 4 { "VEC4" } else { "VEC3" };
        for (view, (kind, each)) in [("VEC3", 3), ("SCALAR", 1), (color, self.channels())].into_iter().enumerate() {
            let size = 4 * each * self.count();
            views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": size, "target": ARRAY_BUFFER}));
            accessors.push(json!({"bufferView": view, "componentType": FLOAT, "count": self.count(), "type": kind}));
            offset += size;
        }
        // The digits of an f64 give the float32 again.
        let [low, high] = self.ends.map(|end| end.map(f64::from));
        (accessors[0]["min"], accessors[0]["max"]) = (json!(low), json!(high));
        (views.into(), accessors.into())
    }

    /// Writes the binary chunk, if there are spheres.
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        if self.count() == 0 {
            return Ok(());
        }
        out.write_all(&(self.bytes() as u32).to_le_bytes())?;
        out.write_all(b"BIN\0")?;
        self.each(out, |n, bytes| self.position(n).iter().for_each(|x| bytes.extend(x.to_le_bytes())))?;
        self.each(out, |n, bytes| bytes.extend(self.radius(n).to_le_bytes()))?;
        self.each(out, |n, bytes| self.color(n).for_each(|x| bytes.extend(x.to_le_bytes())))
    }

    /// Writes the numbers that `add` gives of each sphere.
    fn each(&self, out: &mut dyn Write, add: impl Fn(usize, &mut Vec<u8>)) -> io::Result<()> {
        let mut bytes = Vec::new();
        for first in (0..self.count()).step_by(BLOCK) {
            bytes.clear();
            (first..(first + BLOCK).min(self.count())).for_each(|n| add(n, &mut bytes));
            out.write_all(&bytes)?;
        }
        Ok(())
    }
}

/// The least and the largest coordinates of points.
fn ends(points: impl Iterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    points.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
        [[0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k]))]
    })
}

/// Adds a node of the scene.
fn add_node(document: &mut Value, node: Value) {
    let number = document["nodes"].as_array().map_or(0, Vec::len);
    for (list, value) in [("/nodes", node), ("/scenes/0/nodes", json!(number))] {
        if let Some(Value::Array(list)) = document.pointer_mut(list) {
            list.push(value);
        }
    }
}

/// The camera and the matrix of its node; `None` for one whose principal point is beside the middle or whose lens is curved, which glTF
/// does not have.
fn camera(scene: &Scene) -> Result<Option<(Value, [f64; 16])>> {
    let (camera, image) = (&scene.camera, &scene.image);
    let record = CameraRecord::new(camera, [image.width, image.height], None)?;
    if record.is_off_center() || record.curve.is_some() {
        return Ok(None);
    }
    let basis = camera.basis()?;
    let Viewport { vw, vh, d } = camera.viewport(image.width, image.height)?;
    // Planes around all spheres, in the depth of the view.
    let spheres = &scene.spheres;
    let depth = |n: usize| (basis.e - glam::DVec3::from_array(spheres.centers[n])).dot(basis.w);
    let [near, far] = (0..spheres.len()).fold([f64::INFINITY, 0.0_f64], |[near, far], n| {
        [near.min(depth(n) - spheres.radii[n]), far.max(depth(n) + spheres.radii[n])]
    });
    let far = if far > 0.0 { 2.0 * far } else { 1.0 };
    let near = (near / 2.0).clamp(far / 1e6, far / 2.0);
    let lens = if camera.lens.is_orthographic() {
        let lens = json!({"xmag": vw / 2.0, "ymag": vh / 2.0, "znear": 0.0, "zfar": far});
        json!({"type": "orthographic", "orthographic": lens})
    } else {
        let yfov = 2.0 * (vh / (2.0 * d)).atan();
        let lens = json!({"yfov": yfov, "aspectRatio": vw / vh, "znear": near, "zfar": far});
        json!({"type": "perspective", "perspective": lens})
    };
    let columns = [(basis.u, 0.0), (basis.v, 0.0), (basis.w, 0.0), (basis.e, 1.0)];
    let matrix: Vec<f64> = columns.iter().flat_map(|(column, last)| [column.x, column.y, column.z, *last]).collect();
    Ok(<[f64; 16]>::try_from(matrix).ok().map(|matrix| (lens, matrix)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_beyond_31_bits_is_refused_with_a_number_that_fits() {
        let size = |spheres| size(Path::new("a.glb"), 2000, spheres, 28);
        // 2^31 - 1 bytes without the JSON, the header and the chunks' headers.
        let most = ((1 << 31) - 1 - 2028) / 28;
        assert_eq!((size(0).ok(), size(1).ok()), (Some(2020), Some(2056)));
        assert_eq!(size(most).ok(), Some(2028 + 28 * most as u32));
        let error = size(most + 1).expect_err("one too many").to_string();
        let fits = error.split("at most ").nth(1).and_then(|rest| rest.split(' ').next()).and_then(|n| n.parse().ok());
        assert!(error.contains("a.glb") && size(fits.expect("a number")).is_ok(), "{error}");
    }
}
