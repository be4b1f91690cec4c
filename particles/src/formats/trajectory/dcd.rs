//! DCD, of CHARMM, NAMD, X-PLOR and LAMMPS: records of Fortran, each between two markers with its length, in either byte
//! order; positions in ångström, coordinate by coordinate. The format is described by its readers and writers
//! (www.ks.uiuc.edu/Research/vmd/plugins/molfile/dcdplugin.html, academiccharmm.org/documentation).

use super::moment::{Moment, Moments};
use crate::npy::header::Scalar;
use crate::particles::bytes::BinaryFile;
use crate::particles::frame_time::FrameTime;
use crate::particles::molecule;
use halfline_ground::Cell;
use halfline_ground::error::Result;
use halfline_ground::memory::{check, check_ids, reserve};

/// The reader.
pub(super) struct Dcd {
    file: BinaryFile,
    header: Option<DcdHeader>,
    /// The fixed atoms, where there are any.
    fixed: Option<Fixed>,
    /// The bytes of a record.
    record: Vec<u8>,
    /// The number of frames so far.
    passed: i64,
}

/// The header, from the first records: byte order, number of atoms, records of a frame, and times.
#[derive(Debug, Clone, Copy)]
struct DcdHeader {
    big: bool,
    /// Bytes of a marker: 4, or 8 of some compilers.
    marker: usize,
    atoms: u64,
    has_cell: bool,
    has_fourth: bool,
    /// The step of the first frame, the steps between frames, and the time of a step in AKMA units.
    first: i32,
    between: i32,
    delta: f64,
}

/// Atoms that do not move: frames after the first have the others only.
struct Fixed {
    /// The others, from 0.
    free: Vec<usize>,
    /// The first frame, once it was read.
    first: Option<Vec<[f64; 3]>>,
}

const DAMAGED: &str = "the file is damaged, or is no DCD file; copy or write it again";

/// Picoseconds per AKMA unit of time, in which CHARMM and NAMD write the time of a step
/// (academiccharmm.org/documentation, usage: 1 AKMA unit is 4.888821e-14 s).
const AKMA: f64 = 0.048_888_21;

/// The title of LAMMPS, which writes the time of a step in the unit of its input (`dump_dcd.cpp`).
const LAMMPS: &[u8] = b"Written by LAMMPS";

/// Bytes of a cell: six doubles.
const CELL: u64 = 48;

const AXES: [&str; 3] = ["x", "y", "z"];

impl DcdHeader {
    fn int(self, bytes: [u8; 4]) -> i32 {
        if self.big { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) }
    }

    /// The numbers of a record.
    fn ints(self, record: &[u8]) -> Vec<i32> {
        record.as_chunks().0.iter().map(|bytes| self.int(*bytes)).collect()
    }

    /// The time of a frame, from 0, where the file has the time of a step, and its step, where it has the steps between
    /// frames.
    fn when(self, frame: i64) -> FrameTime {
        let step = (self.between > 0).then(|| i64::from(self.first) + frame * i64::from(self.between));
        let time = step.filter(|_| self.delta > 0.0).map(|step| step as f64 * self.delta * AKMA);
        FrameTime::of(time, step)
    }
}

impl Dcd {
    pub(super) fn new(file: BinaryFile) -> Self {
        Self { file, header: None, fixed: None, record: Vec::new(), passed: 0 }
    }

    /// The header, which is read once.
    fn header(&mut self) -> Result<DcdHeader> {
        if let Some(header) = self.header {
            return Ok(header);
        }
        let (big, marker) = self.encoding()?;
        let unread =
            DcdHeader { big, marker, atoms: 0, has_cell: false, has_fourth: false, first: 0, between: 0, delta: 0.0 };
        let mut header = unread;
        self.file.block(80, &mut self.record, "control numbers")?;
        self.marker(header, 84, "control numbers")?;
        let control = header.ints(&self.record);
        // X-PLOR has no version, and the second half of a double where CHARMM says whether there is a cell.
        let is_charmm = control[19] != 0;
        (header.has_cell, header.has_fourth) = (is_charmm && control[10] != 0, is_charmm && control[11] != 0);
        (header.first, header.between) = (control[1], control[2]);
        header.delta = Scalar::float(if is_charmm { 4 } else { 8 }, big).number(&self.record[36..]);
        let fixed = control[8];
        if self.titles(header)? {
            header.delta = 0.0;
        }
        self.marker(header, 4, "number of atoms")?;
        let at = self.file.at();
        let atoms = header.int(self.file.bytes("number of atoms")?);
        self.marker(header, 4, "number of atoms")?;
        let (all, still) = (u64::try_from(atoms), u64::try_from(fixed));
        let (Ok(all), Ok(still)) = (all, still) else {
            let problem = format!("{atoms} atoms, {fixed} of them fixed");
            return Err(self.file.fail(at, "number of atoms", problem, DAMAGED));
        };
        check_ids(all)?;
        if still > all {
            let problem = format!("{all} atoms, {still} of them fixed");
            return Err(self.file.fail(at, "number of atoms", problem, DAMAGED));
        }
        header.atoms = all;
        if still > 0 {
            let free = self.free(header, all - still)?;
            self.fixed = Some(Fixed { free, first: None });
        }
        self.header = Some(header);
        Ok(header)
    }

    /// Skips the titles, of 80 bytes each after their number. Versions of MDAnalysis write a marker for two titles and
    /// three titles (package 2.11, coordinates/test.dcd), so their number counts. Returns whether the first is by LAMMPS.
    fn titles(&mut self, header: DcdHeader) -> Result<bool> {
        let (field, at) = ("titles", self.file.at());
        let length = self.length(header, field)?;
        let count = header.int(self.file.bytes(field)?);
        let wrong = |what: String| self.file.fail(at, field, what, DAMAGED);
        let text = length.checked_sub(4).ok_or_else(|| wrong(format!("a record of {length} bytes")))?;
        let count = u64::try_from(count).map_err(|_| wrong(format!("{count} titles")))?;
        let bytes = if text.is_multiple_of(80) { 80 * count } else { text };
        let first = bytes.min(80);
        self.file.block(first, &mut self.record, field)?;
        let by_lammps = self.record.starts_with(LAMMPS);
        self.file.pass(bytes - first, field)?;
        self.marker(header, length, field)?;
        Ok(by_lammps)
    }

    /// The byte order and the size of a marker, from the first record, which has 84 bytes and begins with its kind.
    fn encoding(&mut self) -> Result<(bool, usize)> {
        let first: [u8; 8] = self.file.bytes("first record")?;
        let [a, b, c, d, kind @ ..] = first;
        let four = [(false, [84, 0, 0, 0]), (true, [0, 0, 0, 84])];
        let eight = [(false, [84, 0, 0, 0, 0, 0, 0, 0]), (true, [0, 0, 0, 0, 0, 0, 0, 84])];
        let (big, marker, kind) = if let Some((big, _)) = eight.into_iter().find(|(_, sign)| *sign == first) {
            (big, 8, self.file.bytes("first record")?)
        } else if let Some((big, _)) = four.into_iter().find(|(_, sign)| *sign == [a, b, c, d]) {
            (big, 4, kind)
        } else {
            let problem = "the file does not begin with a record of 84 bytes";
            return Err(self.file.fail(0, "first record", problem, DAMAGED));
        };
        match &kind {
            b"CORD" => Ok((big, marker)),
            b"VELD" => {
                let mend = "use the trajectory with the positions";
                Err(self.file.fail(marker as u64, "first record", "the file has velocities, not positions", mend))
            }
            _ => {
                let problem = "the first record does not begin with CORD";
                Err(self.file.fail(marker as u64, "first record", problem, DAMAGED))
            }
        }
    }

    /// The indices of the atoms that move.
    fn free(&mut self, header: DcdHeader, count: u64) -> Result<Vec<usize>> {
        let field = "free atoms";
        let at = self.file.at();
        self.read(header, 4 * count, field)?;
        check(8 * count, || format!("{count} indices of free atoms"))?;
        let index = |number: i32| usize::try_from(i64::from(number) - 1).ok().filter(|n| (*n as u64) < header.atoms);
        let free: Option<Vec<usize>> = header.ints(&self.record).into_iter().map(index).collect();
        free.ok_or_else(|| {
            let problem = format!("an index of an atom is not in 1 to {}", header.atoms);
            self.file.fail(at, field, problem, DAMAGED)
        })
    }

    /// The length in the marker at the current byte.
    fn length(&mut self, header: DcdHeader, field: &str) -> Result<u64> {
        let at = self.file.at();
        let length = match (header.marker, header.big) {
            (8, true) => i64::from_be_bytes(self.file.bytes(field)?),
            (8, false) => i64::from_le_bytes(self.file.bytes(field)?),
            _ => i64::from(header.int(self.file.bytes(field)?)),
        };
        u64::try_from(length).map_err(|_| self.file.fail(at, field, format!("a record of {length} bytes"), DAMAGED))
    }

    /// Reads a marker, which must have this length.
    fn marker(&mut self, header: DcdHeader, expected: u64, field: &str) -> Result<()> {
        let (at, length) = (self.file.at(), self.length(header, field)?);
        if length == expected {
            return Ok(());
        }
        let problem = format!("expected a record of {expected} bytes, found {length}");
        Err(self.file.fail(at, field, problem, DAMAGED))
    }

    /// Reads a record of this length.
    fn read(&mut self, header: DcdHeader, bytes: u64, field: &str) -> Result<()> {
        self.marker(header, bytes, field)?;
        self.file.block(bytes, &mut self.record, field)?;
        self.marker(header, bytes, field)
    }

    /// Skips a record of any length.
    fn pass(&mut self, header: DcdHeader, field: &str) -> Result<()> {
        let length = self.length(header, field)?;
        self.file.pass(length, field)?;
        self.marker(header, length, field)
    }

    /// The cell of a frame: `[A, gamma, B, beta, alpha, C]`, the angles in degrees or as their cosines; or, by newer
    /// versions of CHARMM, the lower triangle of a symmetric matrix of three vectors.
    fn cell(&mut self, header: DcdHeader) -> Result<Option<Cell>> {
        let at = self.file.at();
        self.read(header, CELL, "cell")?;
        let double = Scalar::float(8, header.big);
        let numbers: Vec<f64> = self.record.chunks_exact(8).map(|bytes| double.number(bytes)).collect();
        let [a, gamma, b, beta, alpha, c] = numbers[..] else { return Ok(None) };
        if !numbers.iter().all(|x| x.is_finite()) {
            return Err(self.file.fail(at, "cell", "a number of the cell is not finite", DAMAGED));
        }
        let angles = [alpha, beta, gamma];
        if angles.iter().all(|cosine| cosine.abs() <= 1.0) {
            Ok(molecule::cell([a, b, c], angles.map(|cosine| cosine.acos().to_degrees())))
        } else if angles.iter().all(|degrees| (0.0..=180.0).contains(degrees)) {
            Ok(molecule::cell([a, b, c], angles))
        } else {
            let [xx, xy, yy, xz, yz, zz] = [a, gamma, b, beta, alpha, c];
            Ok(Some(Cell { origin: [0.0; 3], edges: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] }))
        }
    }

    /// The coordinates of a frame of `count` atoms.
    fn coordinates(&mut self, header: DcdHeader, count: u64) -> Result<Vec<[f64; 3]>> {
        let mut positions = Vec::<[f64; 3]>::new();
        for (k, axis) in AXES.into_iter().enumerate() {
            self.read(header, 4 * count, axis)?;
            if k == 0 {
                // The bytes of as many numbers exist.
                reserve(&mut positions, count as usize)?;
                positions.resize(count as usize, [0.0; 3]);
            }
            let single = Scalar::float(4, header.big);
            for (position, bytes) in positions.iter_mut().zip(self.record.chunks_exact(4)) {
                position[k] = single.number(bytes);
            }
        }
        Ok(positions)
    }
}

impl Moments for Dcd {
    fn next(&mut self) -> Result<Option<Moment>> {
        let header = self.header()?;
        if self.file.is_end()? {
            return Ok(None);
        }
        let cell = if header.has_cell { self.cell(header)? } else { None };
        let moving = match &self.fixed {
            Some(Fixed { free, first: Some(_) }) => free.len() as u64,
            _ => header.atoms,
        };
        let mut positions = self.coordinates(header, moving)?;
        if header.has_fourth {
            self.pass(header, "fourth dimension")?;
        }
        if let Some(Fixed { free, first }) = &mut self.fixed {
            check(24 * header.atoms, || "the fixed atoms".into())?;
            match first {
                None => *first = Some(positions.clone()),
                Some(first) => {
                    let moved = std::mem::replace(&mut positions, first.clone());
                    free.iter().zip(moved).for_each(|(n, position)| positions[*n] = position);
                }
            }
        }
        self.file.found();
        self.passed += 1;
        Ok(Some(Moment { positions, cell, when: header.when(self.passed - 1), ..Moment::default() }))
    }

    fn skip(&mut self) -> Result<bool> {
        let header = self.header()?;
        // The first frame has the positions of the fixed atoms.
        if matches!(self.fixed, Some(Fixed { first: None, .. })) {
            return Ok(self.next()?.is_some());
        }
        if self.file.is_end()? {
            return Ok(false);
        }
        let records = 3 + usize::from(header.has_cell) + usize::from(header.has_fourth);
        for _ in 0..records {
            self.pass(header, "skipped frame")?;
        }
        self.file.found();
        self.passed += 1;
        Ok(true)
    }
}
