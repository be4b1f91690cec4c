//! Named NumPy arrays: an archive as written by numpy.savez, read sequentially, so that it may come from a pipe; the
//! directory at its end is not used. The format is PKWARE's APPNOTE.TXT 6.3.10.

mod archive;

use super::frame::{Column, ParticleFrames, Particles};
use super::layout::is_wanted;
use super::request::Request;
use crate::npy::{DType, Header};
use crate::read::npy::Npy;
use crate::read::source::SceneSource;
use archive::{Archive, MEND};
use halfline::error::{Error, Place, Result};
use halfline::memory::check;
use halfline::quote::{list, quote};
use halfline::scene::check_color;
use std::io::BufRead;
use std::sync::Arc;

/// The reader.
pub(in crate::read) struct Npz {
    source: Option<SceneSource>,
    request: Request,
}

/// The arrays read so far, in any order.
#[derive(Default)]
struct Arrays {
    positions: Option<Vec<f64>>,
    axes: [Option<Vec<f64>>; 3],
    radii: Option<Vec<f64>>,
    colors: Option<Vec<f64>>,
    columns: Vec<Column>,
    /// Names and lengths of one-dimensional numeric arrays.
    one: Vec<(String, u64)>,
}

/// The most arrays, and the most bytes in the name of an array.
const MOST: usize = 4096;
const LONGEST_NAME: usize = 256;

impl Npz {
    pub(in crate::read) fn new(source: SceneSource, request: Request) -> Self {
        Self { source: Some(source), request }
    }

    fn read(&self, source: SceneSource) -> Result<Particles> {
        let counts = source.reader.counts();
        let mut archive = Archive { reader: source.reader, path: source.path };
        let mut found = Arrays::default();
        while let Some(member) = archive.member()? {
            archive.open(&member, |path, reader| {
                let (path, counts) = (path.to_path_buf(), Arc::clone(&counts));
                let mut npy = Npy { path, reader, bytes: 0, counts, mend: MEND };
                let header = npy.header()?;
                found.take(member.name.trim_end_matches(".npy"), &header, &mut npy, &self.request.columns)
            })?;
        }
        found.particles(&Place::file(archive.path.display().to_string()))
    }
}

impl Arrays {
    fn take<R: BufRead>(&mut self, name: &str, header: &Header, npy: &mut Npy<R>, wanted: &[String]) -> Result<()> {
        let name = name.to_lowercase();
        let shape = header.shape.clone();
        if self.one.len() < MOST
            && name.len() <= LONGEST_NAME
            && shape.len() == 1
            && matches!(header.dtype, DType::Plain(_))
        {
            self.one.push((name.clone(), shape[0]));
        }
        let slot = match (name.as_str(), &shape[..]) {
            ("positions" | "position" | "pos" | "coords" | "coordinates" | "points" | "xyz", [_, 3]) => {
                &mut self.positions
            }
            ("x" | "y" | "z", [_]) => &mut self.axes[usize::from(name.as_bytes()[0] - b'x')],
            ("radii" | "radius", [_]) => &mut self.radii,
            ("colors" | "color" | "rgb", [_, 3]) => &mut self.colors,
            (_, [_] | [_, 2..=3]) if is_wanted(wanted, &name) => {
                let numbers = npy.numbers(header)?;
                // For vectors their length.
                let width = shape.get(1).map_or(1, |width| *width as usize);
                check(8 * numbers.len() as u64, || format!("the column {}", quote(&name)))?;
                let length = |vector: &[f64]| vector.iter().fold(0.0f64, |length, x| length.hypot(*x));
                let values = if width == 1 { numbers } else { numbers.chunks_exact(width).map(length).collect() };
                self.columns.push(Column { name, values });
                return Ok(());
            }
            _ => return Ok(()),
        };
        let numbers = npy.numbers(header)?;
        let requested = shape.len() == 1 && is_wanted(wanted, &name);
        if requested {
            check(8 * numbers.len() as u64, || format!("the column {}", quote(&name)))?;
            self.columns.push(Column { name, values: numbers.clone() });
        }
        *slot = Some(numbers);
        Ok(())
    }

    fn particles(self, file: &Place) -> Result<Particles> {
        let fail = |field: &str, problem: String| Err(Error::scene(file.clone().named(field), problem, MEND));
        let found = [&self.positions, &self.colors, &self.axes[0], &self.axes[1], &self.axes[2]];
        let numbers: usize = found.into_iter().flatten().map(Vec::len).sum();
        check(8 * numbers as u64, || "the particles besides the file's arrays".into())?;
        let threes =
            |numbers: &[f64]| -> Vec<[f64; 3]> { numbers.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect() };
        let positions = match (self.positions, self.axes) {
            (Some(positions), _) => threes(&positions),
            (None, [Some(x), Some(y), Some(z)]) => {
                if x.len() != y.len() || x.len() != z.len() {
                    return fail(
                        "x, y, z",
                        format!("x, y and z have {}, {} and {} numbers", x.len(), y.len(), z.len()),
                    );
                }
                x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect()
            }
            _ => {
                let names = list(self.one.iter().map(|(name, _)| name));
                let found = if names.is_empty() { "none" } else { &names };
                return fail("positions", format!("no array (n, 3) has that name; found {found}"));
            }
        };
        let n = positions.len();
        let radii = self.radii.unwrap_or_default();
        if !radii.is_empty() && radii.len() != n {
            return fail("radii", format!("found {} radii for {n} positions", radii.len()));
        }
        let colors: Vec<[f32; 3]> =
            threes(&self.colors.unwrap_or_default()).into_iter().map(|color| color.map(|c| c as f32)).collect();
        if !colors.is_empty() && colors.len() != n {
            return fail("colors", format!("found {} colours for {n} positions", colors.len()));
        }
        for (row, color) in colors.iter().enumerate() {
            check_color(*color, || file.clone().named(format!("colors row {row}")))?;
        }
        let columns = self.columns.into_iter().filter(|column| column.values.len() == n).collect();
        let has = self.one.into_iter().filter(|(_, rows)| *rows == n as u64).map(|(name, _)| name).collect();
        Ok(Particles { positions, radii, colors, columns, has, ..Particles::default() })
    }
}

impl ParticleFrames for Npz {
    fn next(&mut self) -> Result<Option<Particles>> {
        self.source.take().map(|source| self.read(source)).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::DeflateEncoder;
    use std::io::Write;

    fn npy(shape: &str, numbers: &[f64]) -> Vec<u8> {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    #[derive(Clone, Copy, PartialEq)]
    enum How {
        Stored,
        Deflated,
        /// Sizes after the file, as written to a pipe.
        Piped,
    }

    fn archive(how: How, members: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (name, content) in members {
            let mut crc = flate2::Crc::new();
            crc.update(content);
            let packed = if how == How::Stored {
                content.clone()
            } else {
                let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(content).expect("in memory");
                encoder.finish().expect("in memory")
            };
            let piped = how == How::Piped;
            let sizes = [crc.sum(), packed.len() as u32, content.len() as u32];
            bytes.extend(b"PK\x03\x04\x14\x00");
            bytes.extend([if piped { 8 } else { 0 }, 0, if how == How::Stored { 0 } else { 8 }, 0, 0, 0, 0, 0]);
            sizes.iter().for_each(|n| bytes.extend(if piped { 0u32 } else { *n }.to_le_bytes()));
            bytes.extend((name.len() as u16).to_le_bytes());
            bytes.extend([0, 0]);
            bytes.extend(name.as_bytes());
            bytes.extend(packed);
            if piped {
                bytes.extend(b"PK\x07\x08");
                sizes.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
            }
        }
        bytes.extend(b"PK\x05\x06");
        bytes
    }

    fn read(bytes: &[u8], columns: &[&str]) -> Result<Particles> {
        let mut npz = Npz::new(SceneSource::of_bytes(bytes), Request::of(columns));
        Ok(npz.next()?.expect("one frame"))
    }

    fn members() -> Vec<(&'static str, Vec<u8>)> {
        vec![
            ("colors.npy", npy("(2, 3)", &[0.0, 0.5, 1.0, 1.0, 1.0, 1.0])),
            ("vel.npy", npy("(2, 3)", &[2.0, 3.0, 6.0, 0.0, 0.0, 1.0])),
            ("t.npy", npy("(2,)", &[7.0, 8.0])),
            ("other.npy", npy("(5,)", &[0.0; 5])),
            ("positions.npy", npy("(2, 3)", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
            ("radii.npy", npy("(2,)", &[0.5, 1.5])),
        ]
    }

    #[test]
    fn arrays_are_found_by_name_in_any_order() {
        for how in [How::Stored, How::Deflated, How::Piped] {
            let found = read(&archive(how, &members()), &["t", "VEL", "other"]).expect("arrays");
            assert_eq!(found.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
            assert_eq!((&found.radii[..], found.colors[0]), (&[0.5, 1.5][..], [0.0, 0.5, 1.0]));
            let columns: Vec<_> = found.columns.iter().map(|c| (c.name.as_str(), &c.values[..])).collect();
            assert_eq!(columns, [("vel", &[7.0, 1.0][..]), ("t", &[7.0, 8.0])], "the length of a vector");
            assert_eq!(found.has, ["t", "radii"]);
        }
        let axes = ["x", "y", "z"].map(|axis| (axis, npy("(1,)", &[f64::from(axis.as_bytes()[0])])));
        let found = read(&archive(How::Stored, &axes), &["y"]).expect("arrays");
        assert_eq!((found.positions[0], found.columns[0].values[0]), ([120.0, 121.0, 122.0], 121.0));
    }

    #[test]
    fn errors_are_reported() {
        let good = archive(How::Deflated, &members());
        let mut damaged = good.clone();
        damaged[14] ^= 1;
        let mut foreign = good.clone();
        foreign[8] = 12;
        let with = |name: &'static str, shape: &str, n: usize| {
            let members = [members().swap_remove(4), (name, npy(shape, &vec![1.0; n]))];
            archive(How::Stored, &members)
        };
        for (bytes, told) in [
            (damaged, "colors.npy: the content does not match its checksum"),
            (foreign, "method 12 of colors.npy"),
            (good[..good.len() / 2].to_vec(), "text"),
            (archive(How::Stored, &members()[..4]), "no array (n, 3) has that name; found t, other"),
            (with("radii.npy", "(3,)", 3), "radii: found 3 radii for 2"),
            (with("radii.npy", "(1000000000000,)", 3), "text/radii.npy: data: the file ends after 3 of"),
            (with("colors.npy", "(1, 3)", 3), "found 1 colours for 2"),
            (with("colors.npy", "(2, 3)", 5), "after 1 of 2 rows"),
        ] {
            let error = read(&bytes, &[]).map(drop).expect_err(told).to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
