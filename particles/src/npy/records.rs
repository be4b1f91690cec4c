//! A NumPy array as a scene: rows of numbers, or records with named fields.

use super::header::MAGIC;
use super::{MEND, Npy, shown as shape_shown};
use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::npy::{DType, Field, Header, Scalar};
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::layout::Layout;
use crate::particles::left_out::LeftOut;
use crate::particles::meaning::{FieldKind, NamedField, meanings};
use crate::particles::records::Record;
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::source::Source;
use crate::spheres::SphereRows;
use halfline_ground::error::{Error, Place, Result, relocate};
use halfline_ground::quote::list;
use std::io::{self, ErrorKind, Read};

pub(crate) const NPY: FormatRow = FormatRow {
    name: "npy",
    about: "a NumPy array",
    signs: &[Sign::Bytes(|bytes| bytes.starts_with(MAGIC))],
    has: &[Has::Blocks, Has::AnyColumns],
    open: Open::Frames(|source, request, _| Ok(Box::new(Array::new(source, request)))),
    ..FormatRow::PLAIN
};

/// The reader.
pub(crate) struct Array {
    source: Option<Source>,
    request: Request,
    /// An array of numbers whose frames are not all read.
    frames: Option<Frames>,
}

/// The frames of an array of three dimensions, or the only one of another.
struct Frames {
    npy: Npy<Input>,
    /// The header of a frame, and of the array.
    frame: Header,
    whole: Header,
    /// The next frame.
    next: u64,
    /// All numbers of an array in Fortran order.
    numbers: Vec<f64>,
}

impl Array {
    pub(crate) fn new(source: Source, request: Request) -> Self {
        Self { source: Some(source), request, frames: None }
    }
}

impl Frames {
    fn new(npy: Npy<Input>, whole: Header) -> Self {
        let frame = match &whole.shape[..] {
            [_, n, width] => Header { shape: vec![*n, *width], ..whole.clone() },
            _ => whole.clone(),
        };
        Self { npy, frame, whole, next: 0, numbers: Vec::new() }
    }

    /// The number of frames.
    fn count(&self) -> u64 {
        if self.whole.shape.len() == 3 { self.whole.shape[0] } else { 1 }
    }

    /// Checks the shape and the type of an array of numbers; the error names the array's shape and type.
    fn check(&self) -> Result<()> {
        let is_film = self.whole.shape.len() == 3 && WIDTHS.contains(&self.whole.shape[2]);
        self.npy.matrix(if is_film { &self.frame } else { &self.whole }, &WIDTHS).map(drop)
    }

    fn next(&mut self, request: &Request) -> Result<Option<Particles>> {
        if self.next >= self.count() {
            return Ok(None);
        }
        let frame = self.next;
        self.next += 1;
        if let DType::Record(fields) = &self.whole.dtype {
            return self.npy.records(&self.whole, fields, request).map(Some);
        }
        self.check()?;
        let (mut spheres, survey) = (SphereRows::default(), request.survey.as_ref());
        self.npy.left_out = request.skip_invalid.then(LeftOut::default);
        let width = if self.is_interleaved() {
            if self.numbers.is_empty() {
                self.numbers = self.npy.numbers(&self.whole)?;
            }
            self.npy.of_numbers(&self.numbers, frame, &self.frame, &mut spheres)?
        } else {
            self.npy.spheres(&self.frame, &WIDTHS, &mut spheres, survey)?
        };
        if self.next == self.count() {
            self.npy.end(self.whole.shape.iter().rev().skip(1).product())?;
        }
        let SphereRows { centers, radii, colors } = spheres;
        let radii = if width == 3 { Vec::new() } else { radii };
        let mut frame = Particles { positions: centers, radii, colors, checked: true, ..Particles::default() };
        frame.skipped.assumed.extend(self.npy.left_out.take().unwrap_or_default().sentence());
        Ok(Some(frame))
    }

    /// Whether the frames of an array of three dimensions in Fortran order lie between each other.
    fn is_interleaved(&self) -> bool {
        self.whole.shape.len() == 3 && self.whole.fortran
    }

    fn skip(&mut self) -> Result<bool> {
        if self.next >= self.count() {
            return Ok(false);
        }
        self.next += 1;
        if matches!(self.whole.dtype, DType::Record(_)) || self.is_interleaved() {
            return Ok(true);
        }
        self.check()?;
        let bytes = self.frame.data_bytes().unwrap_or_default();
        let passed = io::copy(&mut (&mut self.npy.reader).take(bytes), &mut io::sink());
        let passed = passed.map_err(|error| Error::read(&self.npy.path, error))?;
        self.npy.counts.found();
        if passed < bytes {
            let rows = self.frame.shape[0];
            return Err(self.npy.cut(ErrorKind::UnexpectedEof.into(), (self.next - 1) * rows, self.count() * rows));
        }
        Ok(true)
    }
}

/// The widths of an array of numbers: coordinates, with radii, with colours.
const WIDTHS: [u64; 3] = [3, 4, 7];

impl Array {
    /// The frames; the first call reads the header.
    fn frames(&mut self) -> Result<Option<&mut Frames>> {
        if let Some(Source { reader, path, .. }) = self.source.take() {
            let mut npy = Npy::new(reader, &path, MEND);
            let header = npy.header()?;
            self.frames = Some(Frames::new(npy, header));
        }
        Ok(self.frames.as_mut())
    }
}

impl ParticleFrames for Array {
    fn next(&mut self) -> Result<Option<Particles>> {
        let request = self.request.clone();
        self.frames()?.map_or(Ok(None), |frames| frames.next(&request))
    }

    fn skip(&mut self) -> Result<bool> {
        self.frames()?.map_or(Ok(false), Frames::skip)
    }
}

/// The longest record in bytes.
const MOST: usize = 1 << 16;

impl Npy<Input> {
    fn records(&mut self, header: &Header, fields: &[Field], request: &Request) -> Result<Particles> {
        let rows = match header.shape[..] {
            [n] => n,
            ref other => {
                return Err(self.fail("shape", format!("found records in {}, expected (n,)", shape_shown(other))));
            }
        };
        let size = fields.iter().try_fold(0, |size, field| {
            let bytes = field.dtype.bytes().filter(|bytes| *bytes <= MOST - size);
            let mend = || self.fail("dtype", format!("records have more than {MOST} bytes or hold objects"));
            bytes.map(|bytes| size + bytes).ok_or_else(mend)
        })?;
        let meanings = meanings(&fields.iter().map(named).collect::<Vec<_>>());
        let mut record = Record::default();
        for (k, (columns, field)) in meanings.fields.iter().zip(fields).enumerate() {
            let ends = record.size() + field.dtype.bytes().unwrap_or_default();
            match scalar(&field.dtype) {
                Some(scalar) if meanings.packed == Some(k) => record.add_color(scalar),
                Some(scalar) => record.add_numbers(columns.len(), scalar),
                None => {}
            }
            record.add_padding(ends - record.size());
        }
        let mut layout = Layout::new(request);
        layout.add_fields(meanings).map_err(|problem| self.fail("dtype", problem))?;
        if (0..3).any(|axis| !layout.contains(Role::Position(axis))) {
            return Err(self.fail("dtype", format!("no fields of numbers x, y and z among {}", shown(fields))));
        }
        let mut particles = layout.begin();
        let (file, mut block, mut row) = (Place::file(self.path.display().to_string()), Vec::new(), 0);
        while row < rows {
            let found = self.block(rows - row, size, &mut block).map_err(|error| self.cut(error, row, rows))?;
            if found == 0 {
                return Err(self.cut(ErrorKind::UnexpectedEof.into(), row, rows));
            }
            record.append(&block, &layout, &mut particles, true, |n, numbers, particles| {
                let row = row + n as u64;
                layout.checked_numbers(numbers, particles, |error| {
                    relocate(error, |field| file.clone().named(format!("row {row} {field}")))
                })
            })?;
            row += found;
        }
        self.end(rows)?;
        particles.tell_left_out();
        Ok(particles)
    }
}

/// The most numbers of a field; a field with more is not read.
const MOST_COLUMNS: u64 = 16;

/// The type of a field's number, or of each number of an array; `None` for text, objects and other types that are not read.
fn scalar(dtype: &DType) -> Option<Scalar> {
    match dtype {
        DType::Array(_, inner) => inner.scalar(),
        dtype => dtype.scalar(),
    }
}

/// The name of a field and what it has.
fn named(field: &Field) -> NamedField<'_> {
    let count = if let DType::Array(count, _) = field.dtype { count } else { 1 };
    let kind = match scalar(&field.dtype).filter(|_| count <= MOST_COLUMNS) {
        Some(scalar) => FieldKind::Binary(scalar),
        None => FieldKind::Other(field.dtype.to_string()),
    };
    NamedField { name: &field.name, count: count as usize, kind }
}

/// The fields of a record in words.
fn shown(fields: &[Field]) -> String {
    list(fields.iter().map(|field| format!("{} ({})", field.name, field.dtype)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16 + 1).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.push(b'\n');
        bytes.extend(data);
        bytes
    }

    fn read(descr: &str, shape: &str, data: &[u8]) -> Result<Particles> {
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}");
        let source = Source::of_bytes(&npy(&header, data));
        let mut array = Array::new(source, Request::of(&["t", "v_y"]));
        Ok(array.next()?.expect("one frame"))
    }

    #[test]
    fn positions_alone_have_no_radii() {
        let data: Vec<u8> = [1.0f64, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let found = read("'<f8'", "(2, 3)", &data).expect("an array");
        assert_eq!((found.positions, found.radii.len()), (vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], 0));
    }

    #[test]
    fn records_have_named_fields() {
        let descr = "[('name', '|S3'), ('x', '<f4'), ('z', '>f8'), ('y', '<i2'), ('radius', '<f8'), ('v', '<f4', (3,)), \
            ('t', '|u1')]";
        let mut data = Vec::new();
        for k in [1u8, 2] {
            data.extend(b"abc");
            data.extend(f32::from(k).to_le_bytes());
            data.extend((f64::from(k) + 0.5).to_be_bytes());
            data.extend((-i16::from(k)).to_le_bytes());
            data.extend(3.0f64.to_le_bytes());
            [7.0f32, 8.0, 9.0].iter().for_each(|v| data.extend(v.to_le_bytes()));
            data.push(k + 200);
        }
        let found = read(descr, "(2,)", &data).expect("records");
        assert_eq!(
            (&found.positions[..], &found.radii[..]),
            (&[[1.0, -1.0, 1.5], [2.0, -2.0, 2.5]][..], &[3.0; 2][..])
        );
        let column = |name: &str| &found.columns.iter().find(|c| c.name == name).expect(name).values[..];
        assert_eq!((column("t"), column("v_y")), (&[201.0, 202.0][..], &[8.0; 2][..]));
        let cut = read(descr, "(2,)", &data[..60]).map(drop).expect_err("cut short").to_string();
        assert!(cut.contains("after 1 of 2 rows"), "{cut}");
        for (descr, message) in [
            ("[('x', '<f8')]", "no fields of numbers x, y and z among x"),
            ("[('x', '<f8', (99999999,)), ('y', '<f8'), ('z', '<f8')]", "more than 65536 bytes"),
            ("[('x', '|O'), ('y', '<f8'), ('z', '<f8')]", "hold objects"),
        ] {
            let error = read(descr, "(2,)", &data).map(drop).expect_err(descr).to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
