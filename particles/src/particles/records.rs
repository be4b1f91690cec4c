//! Records in binary: rows of one length, whose numbers have places and types. The vertices of PLY, the points of PCD and the
//! records of NumPy are decoded here, on all cores.

use super::frame::Particles;
use super::layout::Layout;
use crate::blocks;
use crate::npy::header::Scalar;
use halfline_ground::error::Result;
use halfline_ground::parallel;

/// The bytes of a block of records, and of the part of it that one core decodes.
const BLOCK: usize = 1 << 20;
const PART: usize = 1 << 16;

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
    /// a particle.
    ///
    /// # Errors
    /// The first error of `add` in the order of the records, and those of [`Particles::grow`].
    pub(crate) fn append(
        &self,
        block: &[u8],
        layout: &Layout,
        particles: &mut Particles,
        add: impl Fn(usize, &mut Vec<f64>, &mut Particles) -> Result<()> + Sync,
    ) -> Result<()> {
        let size = self.size.max(1);
        let parts = parallel::blocks(0..block.len() / size, (PART / size).max(1), &|records, _| {
            let (mut part, mut numbers) = (layout.begin_part(), Vec::new());
            for n in records {
                numbers.clear();
                self.decode(&block[n * size..(n + 1) * size], &mut numbers);
                add(n, &mut numbers, &mut part)?;
            }
            Ok(part)
        });
        parts.into_iter().try_for_each(|part: Result<Particles>| particles.append(part?))
    }

    fn decode(&self, record: &[u8], numbers: &mut Vec<f64>) {
        for number in &self.numbers {
            let bytes = &record[number.at..];
            match number.is_color {
                true => numbers.extend(number.scalar.levels(bytes)),
                false => numbers.push(number.scalar.number(bytes)),
            }
        }
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

    /// Points with a number, of which each of these has no finite x, as PLY without and with lists, PCD and records of NumPy.
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
}
