//! Records in binary: rows of one length, whose numbers have places and types. The vertices of PLY, the points of PCD and the
//! records of NumPy are decoded here, on all cores: column by column, and row by row where a row is not valid.

use super::frame::Particles;
use super::layout::Layout;
use crate::blocks;
use crate::npy::header::Scalar;
use halfline_ground::error::Result;
use halfline_ground::parallel;

/// The bytes of a block of records, and of the part of it that one core decodes.
const BLOCK: usize = 1 << 20;
const PART: usize = 1 << 15;

/// The numbers of a record, in the order of the columns.
#[derive(Default)]
pub(crate) struct Record {
    numbers: Vec<RecordNumber>,
    size: usize,
}

struct RecordNumber {
    at: usize,
    scalar: Scalar,
    /// A packed colour, 0xRRGGBB, which is three numbers.
    is_color: bool,
}

impl Record {
    /// Adds `count` numbers behind the last field.
    pub(crate) fn add_numbers(&mut self, count: usize, scalar: Scalar) {
        for _ in 0..count {
            self.numbers.push(RecordNumber { at: self.size, scalar, is_color: false });
            self.size += scalar.size();
        }
    }

    /// Adds a packed colour behind the last field.
    pub(crate) fn add_color(&mut self, scalar: Scalar) {
        self.numbers.push(RecordNumber { at: self.size, scalar, is_color: true });
        self.size += scalar.size();
    }

    /// Adds a field of this many bytes that is not read.
    pub(crate) fn add_padding(&mut self, bytes: usize) {
        self.size += bytes;
    }

    /// Bytes per record.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// The records of a block, at least 1.
    pub(crate) fn per_block(&self) -> u64 {
        (blocks::at_most(BLOCK) / self.size.max(1)).max(1) as u64
    }

    /// Appends the particles of the records of a block. `add` takes the number of a record in the block and its numbers, and adds
    /// a particle; where `is_plain`, it is [`Layout::checked_numbers`] for records whose numbers are all valid.
    ///
    /// # Errors
    /// The first error of `add` in the order of the records, and errors of [`Particles::grow`].
    pub(crate) fn append(
        &self,
        block: &[u8],
        layout: &Layout,
        particles: &mut Particles,
        is_plain: bool,
        add: impl Fn(usize, &mut Vec<f64>, &mut Particles) -> Result<()> + Sync,
    ) -> Result<()> {
        let size = self.size.max(1);
        let parts = parallel::blocks(0..block.len() / size, (PART / size).max(1), &|records, _| {
            let (mut part, count) = (layout.begin_part(), records.len());
            let columns = self.columns(&block[records.start * size..records.end * size]);
            if is_plain && layout.valid_columns(count, &columns, &mut part) {
                return Ok(part);
            }
            let mut numbers = Vec::new();
            for (row, n) in records.enumerate() {
                numbers.clear();
                numbers.extend(columns[row..].iter().step_by(count));
                add(n, &mut numbers, &mut part)?;
            }
            Ok(part)
        });
        parts.into_iter().try_for_each(|part: Result<Particles>| particles.append(part?))
    }

    /// The numbers of each column of some records, one column after the other.
    fn columns(&self, records: &[u8]) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(records.len() / self.size.max(1) * self.numbers.len());
        for RecordNumber { at, scalar, is_color } in &self.numbers {
            let fields = records.chunks_exact(self.size).map(|record| &record[*at..]);
            match is_color {
                true => (0..3).for_each(|k| numbers.extend(fields.clone().map(|bytes| scalar.levels(bytes)[k]))),
                false => scalar.extend(fields, &mut numbers),
            }
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use crate::Format;
    use crate::particles::frame::Particles;
    use crate::particles::request::Request;
    use crate::source::Source;
    use halfline_ground::error::Result;

    /// Several blocks.
    const COUNT: usize = 200_000;

    /// Points with a number, at `bad` without a finite x, as PLY without and with lists, PCD and records of NumPy.
    fn files(bad: &[usize]) -> [(Format, Vec<u8>); 5] {
        let row = |n: usize| {
            let x = if bad.contains(&n) { f32::NAN } else { n as f32 };
            let [y, z] = [0.5f32, -(n as f32)].map(f32::to_le_bytes);
            [x.to_le_bytes().to_vec(), y.to_vec(), z.to_vec(), vec![(n % 7) as u8]]
        };
        let rows: Vec<u8> = (0..COUNT).flat_map(|n| row(n).concat()).collect();
        let listed: Vec<u8> = (0..COUNT).flat_map(|n| [row(n).concat(), vec![2, 8, 9]].concat()).collect();
        let columns: Vec<u8> = (0..4).flat_map(|k| (0..COUNT).flat_map(move |n| row(n)[k].clone())).collect();
        let ply = |list: &str, rows: &[u8]| {
            let xyz = "property float x\nproperty float y\nproperty float z\nproperty uchar t\n";
            let header =
                format!("ply\nformat binary_little_endian 1.0\nelement vertex {COUNT}\n{xyz}{list}end_header\n");
            [header.as_bytes(), rows].concat()
        };
        let pcd = |data: &str, rows: &[u8]| {
            let fields = "FIELDS x y z t\nSIZE 4 4 4 1\nTYPE F F F U\n";
            let header = format!("VERSION 0.7\n{fields}WIDTH {COUNT}\nHEIGHT 1\nPOINTS {COUNT}\nDATA {data}\n");
            [header.as_bytes(), rows].concat()
        };
        let sizes = [columns.len() as u32; 2].map(u32::to_le_bytes).concat();
        let fields = "[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('t', '|u1')]";
        let header = format!("{{'descr': {fields}, 'fortran_order': False, 'shape': ({COUNT},), }}\n");
        let npy = [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes(), &rows].concat();
        [
            (Format::PLY, ply("", &rows)),
            (Format::PLY, ply("property list uchar uchar more\n", &listed)),
            (Format::PCD, pcd("binary", &rows)),
            (Format::PCD, pcd("binary_compressed", &[sizes, columns].concat())),
            (Format::NPY, npy),
        ]
    }

    fn read(format: Format, bytes: &[u8], skip_invalid: bool) -> Result<Particles> {
        let request = Request { skip_invalid, ..Request::of(&["t"]) };
        let Ok(mut frames) = format.frames(Source::of_bytes(bytes), request, false)? else { panic!("a scene") };
        Ok(frames.next()?.expect("a frame"))
    }

    #[test]
    fn blocks_of_records_keep_their_order() {
        for (k, (format, bytes)) in files(&[]).iter().enumerate() {
            let found = read(*format, bytes, false).expect("points");
            let at = |n: usize| [n as f64, 0.5, -(n as f64)];
            assert!(found.positions.len() == COUNT && (0..COUNT).all(|n| found.positions[n] == at(n)), "{k}");
            assert!((0..COUNT).all(|n| found.columns[0].values[n] == (n % 7) as f64), "{k}");
        }
    }

    #[test]
    fn the_first_bad_record_is_named_and_bad_ones_are_left_out() {
        for (k, (format, bytes)) in files(&[150_000, 199_998]).iter().enumerate() {
            let error = read(*format, bytes, false).map(drop);
            // PCD has points without coordinates by its definition.
            if k == 2 || k == 3 {
                assert!(error.is_ok());
            } else {
                let error = error.expect_err("a bad point").to_string();
                assert!(error.contains(["vertex 150000 x", "vertex 150000 x", "", "", "row 150000 x"][k]), "{error}");
            }
            let found = read(*format, bytes, true).expect("the others");
            assert_eq!((found.positions.len(), found.columns[0].values.len()), (COUNT - 2, COUNT - 2), "{k}");
            assert_eq!(found.positions[150_000][0], 150_001.0);
        }
    }

    /// A bad record sends the others of its part row by row; without it they are decoded column by column.
    #[test]
    fn rows_and_columns_give_the_same_particles() {
        let fields = "[('x', '<f4'), ('y', '>f8'), ('z', '<i4'), ('diameter', '<f8'), ('rgb', '<u4'), ('v', '<f4', (3,)), \
            ('number', '|u1'), ('t', '>i2'), ('w', '<u2'), ('name', '|S3')]";
        let row = |n: usize| {
            let at = n as f64;
            let z = if n == 90 { f32::NAN } else { n as f32 }.to_le_bytes();
            let v = [at as f32, 2.0, -1.0].map(f32::to_le_bytes).concat();
            let rest =
                [vec![n as u8], (-(n as i16)).to_be_bytes().to_vec(), (n as u16).to_le_bytes().to_vec()].concat();
            [&z[..], &at.sqrt().to_be_bytes(), &(-7 * n as i32).to_le_bytes(), &(1.0 + at).to_le_bytes()]
                .into_iter()
                .chain([&(0x10203 * n as u32).to_le_bytes()[..], &v, &rest, b"abc"])
                .flatten()
                .copied()
                .collect::<Vec<u8>>()
        };
        let file = |count: usize| {
            let header = format!("{{'descr': {fields}, 'fortran_order': False, 'shape': ({count},), }}\n");
            let rows: Vec<u8> = (0..count).flat_map(row).collect();
            [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes(), &rows].concat()
        };
        let read = |count: usize| {
            let request = Request { skip_invalid: true, ..Request::of(&["t", "w", "v", "v_y", "rgb", "number"]) };
            let Ok(mut frames) = Format::NPY.frames(Source::of_bytes(&file(count)), request, false).expect("records")
            else {
                panic!("a scene")
            };
            frames.next().expect("records").expect("a frame")
        };
        let (columns, rows) = (read(90), read(91));
        assert!(columns.skipped.assumed.is_empty() && rows.skipped.assumed.len() == 1, "{:?}", rows.skipped.assumed);
        assert_eq!(columns.positions.len(), 90);
        let all = |found: Particles| (found.positions, found.radii, found.colors, found.elements, found.columns);
        let (columns, rows) = (all(columns), all(rows));
        assert_eq!(columns, rows);
        assert!(columns.1[9] == 5.0 && columns.2.len() == 90 && columns.4.len() >= 4, "{columns:?}");
    }
}
