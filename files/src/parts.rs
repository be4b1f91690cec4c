//! Parts of a scene in files: an .npz of plain NumPy arrays. `centers` (n, 3) and `radii` (n) in float64, `id` (n) in int64, in
//! increasing order, `colors` (n, 3) and `opacities` (n) in float32 where the spheres have any, and `about`. `about` is the bytes of a
//! JSON text: the rays and the spheres that the part is made for. Equal parts have equal bytes.

use crate::write::atomic::write_atomically;
use crate::write::npz::{self, write_archive};
use halfline::error::{Error, Place, Result};
use halfline::frame::array::{Array, Values};
use halfline::memory::check;
use halfline::render::stream::{Part, PartView};
use halfline::scene::Spheres;
use halfline::settings::Tolerance;
use halfline_particles::npy::header::Header;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::Path;

/// The remedy for files that hold no part.
const MEND: &str = "use a file of halfline sift, or of Part.save in Python";

/// The tolerance of a frame of a part for which none is asked: that which the part was made for. The default is none, since with one
/// that is asked for accuracy `auto` may take a method.
///
/// # Errors
/// [`Error::Settings`] for a number that no part has.
pub fn tolerance(view: &PartView) -> Result<Option<Tolerance>> {
    Ok(Some(Tolerance::new(view.tolerance)?).filter(|tolerance| *tolerance != Tolerance::default()))
}

/// Reads the part in a file.
///
/// # Errors
/// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] for one that is no part, or a damaged one, [`Error::Limits`]
/// where memory is short.
pub fn read(path: &Path) -> Result<Part> {
    let fail = |error| Error::read(path, error);
    let size = fs::metadata(path).map_err(fail)?.len();
    check(3 * size, || path.display().to_string())?;
    let mut bytes = Vec::new();
    File::open(path).and_then(|mut file| file.read_to_end(&mut bytes)).map_err(fail)?;
    of_bytes(&bytes, &path.display().to_string())
}

/// The part in the bytes of a file, which errors call `name`.
///
/// # Errors
/// As [`read`], without [`Error::Io`]: no file is opened.
pub fn of_bytes(bytes: &[u8], name: &str) -> Result<Part> {
    let mut arrays = npz::read(bytes, name).map_err(|error| match error {
        // It may never have been one of halfline's pictures.
        Error::Scene { place, problem, source, .. } => Error::Scene { place, problem, mend: MEND.into(), source },
        other => other,
    })?;
    let mut found = |field: &str| {
        let at = arrays.iter().position(|(found, _)| found.as_deref() == Some(field))?;
        Some(arrays.swap_remove(at).1)
    };
    let fail = |field: &str, problem: &str| Error::scene(Place::file(name).named(field), problem, MEND);
    let missing = |field: &str| fail(field, "the file has no such array");
    let mut get = |field: &str| found(field).ok_or_else(|| missing(field));
    let (about, ids, radii, centers) = (get("about")?, get("id")?, get("radii")?, get("centers")?);
    let (colors, opacities) = (get("colors").ok(), get("opacities").ok());
    let n = radii.values().len();
    let shape = |array: &Array, field: &str, rows: &[usize]| match array.shape() == rows {
        true => Ok(()),
        false => Err(fail(field, &format!("found the shape {:?}, and not {rows:?}", array.shape()))),
    };
    shape(&radii, "radii", &[n])?;
    shape(&ids, "id", &[n])?;
    shape(&centers, "centers", &[n, 3])?;
    let dtype = |array: &Array, field: &str| {
        fail(field, &format!("numbers of type {} are not expected", array.values().dtype()))
    };
    let Values::F64(xyz) = centers.values() else { return Err(dtype(&centers, "centers")) };
    let Values::F64(r) = radii.values() else { return Err(dtype(&radii, "radii")) };
    let Values::I64(id) = ids.values() else { return Err(dtype(&ids, "id")) };
    let Values::U8(about) = about.values() else { return Err(dtype(&about, "about")) };
    let ids = id.iter().map(|id| u64::try_from(*id)).collect::<Result<Vec<_>, _>>();
    let ids = ids.map_err(|_| fail("id", "an id is negative"))?;
    let colors = match colors.as_ref().map(|colors| (colors, colors.values())) {
        None => None,
        Some((colors, Values::F32(values))) => {
            shape(colors, "colors", &[n, 3])?;
            Some(values.as_chunks().0.to_vec().into())
        }
        Some((colors, _)) => return Err(dtype(colors, "colors")),
    };
    let opacities = match opacities.as_ref().map(|opacities| (opacities, opacities.values())) {
        None => None,
        Some((opacities, Values::F32(values))) => {
            shape(opacities, "opacities", &[n])?;
            Some(values.clone().into())
        }
        Some((opacities, _)) => return Err(dtype(opacities, "opacities")),
    };
    let (centers, radii) = (xyz.as_chunks().0.to_vec().into(), r.clone().into());
    Part::new(name.into(), about, ids, Spheres { centers, radii, colors, materials: None, opacities, cuts: None })
}

/// Writes a part, completely or not at all.
///
/// # Errors
/// [`Error::Io`] naming the file.
pub fn write(part: &Part, path: &Path) -> Result<()> {
    write_atomically(path, |out| write_to(part, out))
}

/// The bytes of the file of a part.
///
/// # Errors
/// [`Error::Io`] where memory is short.
pub fn bytes(part: &Part) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_to(part, &mut bytes).map_err(|error| Error::write("the part", error))?;
    Ok(bytes)
}

fn write_to(part: &Part, out: &mut dyn Write) -> io::Result<()> {
    let (about, spheres) = (part.about(), part.spheres());
    let n = part.ids().len() as u64;
    let mut members: Vec<(&str, &str, Vec<u64>, &[u8])> = vec![
        ("about", "|u1", vec![about.len() as u64], about.as_bytes()),
        ("centers", "<f8", vec![n, 3], bytemuck::cast_slice(&spheres.centers)),
        ("radii", "<f8", vec![n], bytemuck::cast_slice(&spheres.radii)),
        ("id", "<i8", vec![n], bytemuck::cast_slice(part.ids())),
    ];
    if let Some(colors) = &spheres.colors {
        members.push(("colors", "<f4", vec![n, 3], bytemuck::cast_slice(colors)));
    }
    if let Some(opacities) = &spheres.opacities {
        members.push(("opacities", "<f4", vec![n], bytemuck::cast_slice(opacities)));
    }
    write_archive(out, |archive| {
        members.iter().try_for_each(|(name, dtype, shape, bytes)| {
            let header = Header::bytes(dtype, shape);
            let file = archive.member(&format!("{name}.npy"), (header.len() + bytes.len()) as u64)?;
            file.write_all(&header)?;
            file.write_all(bytes)
        })
    })
}
