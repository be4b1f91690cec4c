//! The legacy format: a header of three lines, and sections of keywords and numbers in text or in binary, the most significant byte
//! first.

use super::encoded::{Fault, number};
use super::points::{Array, MOST_COMPONENTS, Piece, Pieces, is_needed, total};
use crate::npy::header::Scalar;
use crate::particles::frame_time::FrameTime;
use crate::particles::request::Request;
use halfline_ground::error::{Place, Result};
use halfline_ground::memory::reserve;
use halfline_ground::quote::quote;

/// The data sets whose points are listed.
const LISTED: [&str; 3] = ["POLYDATA", "UNSTRUCTURED_GRID", "STRUCTURED_GRID"];

/// The most arrays of a field, and the most keywords.
const MOST: u64 = 1 << 20;

/// The types of colours and of cells.
const BYTE: Scalar = Scalar::unsigned(1, true);
const CELL: Kind = Kind::Number(Scalar::unsigned(4, true));

/// The kind of an array's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Number(Scalar),
    Bits,
    Texts,
}

/// Values that follow a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    DataSet,
    Points,
    Cells,
}

/// A file while it is read.
struct File<'a> {
    bytes: &'a [u8],
    at: usize,
    is_binary: bool,
    /// The major version.
    version: u32,
    request: &'a Request,
    piece: Piece,
    /// The number of cells whose data follow.
    cells: u64,
    when: FrameTime,
}

/// Reads the points of a file.
///
/// # Errors
/// [`Error::Scene`] with the byte, [`Error::Limits`].
pub(super) fn read(bytes: &[u8], place: &Place, request: &Request) -> Result<Pieces> {
    let mut file = File {
        bytes,
        at: 0,
        is_binary: false,
        version: 0,
        request,
        piece: Piece::default(),
        cells: 0,
        when: FrameTime::default(),
    };
    file.sections().map_err(|fault| fault.at(place.clone().named(format!("byte {}", file.at))))?;
    Ok(Pieces { all: vec![file.piece], when: file.when })
}

/// The kind of this name.
fn kind(name: &str) -> Option<Kind> {
    let name = name.to_ascii_lowercase();
    let numpy = match name.strip_prefix("vtktype").unwrap_or(&name) {
        "bit" => return Some(Kind::Bits),
        "string" | "utf8_string" => return Some(Kind::Texts),
        "char" | "signed_char" | "int8" => "|i1",
        "unsigned_char" | "uint8" => "|u1",
        "short" | "int16" => ">i2",
        "unsigned_short" | "uint16" => ">u2",
        "int" | "int32" | "vtkidtype" => ">i4",
        "unsigned_int" | "uint32" => ">u4",
        "long" | "int64" | "long_long" => ">i8",
        "unsigned_long" | "uint64" | "unsigned_long_long" => ">u8",
        "float" | "float32" => ">f4",
        "double" | "float64" => ">f8",
        _ => return None,
    };
    Scalar::of_numpy(numpy).map(Kind::Number)
}

/// A number of components, which is limited.
fn within(components: u64) -> Result<usize, Fault> {
    match components {
        1..=MOST_COMPONENTS => Ok(components as usize),
        _ => Err(format!("{components} components").into()),
    }
}

/// A name with its escapes, `%20`, replaced.
fn decoded(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name.as_bytes();
    while let [first, others @ ..] = rest {
        let code = others.get(..2).and_then(|code| u8::from_str_radix(std::str::from_utf8(code).ok()?, 16).ok());
        match code.filter(|_| *first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                rest = &others[2..];
            }
            None => {
                bytes.push(*first);
                rest = others;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

impl File<'_> {
    /// The next word; `None` at the end of the file.
    fn next(&mut self) -> Option<&str> {
        let is_blank = |byte: &u8| byte.is_ascii_whitespace();
        let begin = self.at + self.bytes[self.at..].iter().position(|byte| !is_blank(byte))?;
        let rest = &self.bytes[begin..];
        let end = begin + rest.iter().position(is_blank).unwrap_or(rest.len());
        self.at = end;
        // A longer word is no keyword.
        Some(std::str::from_utf8(&self.bytes[begin..end]).unwrap_or_default())
    }

    fn word(&mut self, what: &str) -> Result<String, Fault> {
        self.next().map(str::to_owned).ok_or_else(|| format!("the file ends before {what}").into())
    }

    fn count(&mut self, what: &str) -> Result<u64, Fault> {
        let word = self.word(what)?;
        word.parse().map_err(|_| format!("expected {what}, found {}", quote(&word)).into())
    }

    fn kind(&mut self) -> Result<Kind, Fault> {
        let word = self.word("a type")?;
        kind(&word).ok_or_else(|| format!("the type {} is not known", quote(&word)).into())
    }

    /// The rest of the line.
    fn line(&mut self) -> &str {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        let begin = self.at;
        self.at = (begin + end + 1).min(self.bytes.len());
        std::str::from_utf8(&self.bytes[begin..begin + end]).unwrap_or_default().trim()
    }

    /// Passes the end of the line before binary data.
    fn begin_data(&mut self) {
        if self.is_binary {
            self.line();
        }
    }

    fn sections(&mut self) -> Result<(), Fault> {
        let first = self.line().to_owned();
        let version = first.rsplit(' ').next().and_then(|version| version.split('.').next());
        self.version = version.and_then(|version| version.parse().ok()).unwrap_or(0);
        self.line();
        let mode = self.word("ASCII or BINARY")?.to_ascii_uppercase();
        self.is_binary = match &mode[..] {
            "ASCII" => false,
            "BINARY" => true,
            _ => return Err(format!("expected ASCII or BINARY, found {}", quote(&mode)).into()),
        };
        let mut of = Of::DataSet;
        while let Some(keyword) = self.next().map(str::to_ascii_uppercase) {
            self.request.watch.check().map_err(Fault::Limits)?;
            self.section(&keyword, &mut of)?;
        }
        if self.piece.points.is_none() {
            return Err("the file has no points".to_owned().into());
        }
        Ok(())
    }

    fn section(&mut self, keyword: &str, of: &mut Of) -> Result<(), Fault> {
        match keyword {
            "DATASET" => {
                let kind = self.word("a data set")?.to_ascii_uppercase();
                if !LISTED.contains(&&kind[..]) {
                    return Err(format!("a data set {} has no points of its own", quote(&kind)).into());
                }
            }
            "DIMENSIONS" => (0..3).try_for_each(|_| self.count("a dimension").map(drop))?,
            "POINTS" => {
                let count = self.count("the number of points")?;
                let kind = self.kind()?;
                self.piece.count = total(count, 3).map_err(Fault::Limits)? / 3;
                let points = self.values("points", 3, count, kind, true)?;
                self.piece.points = points;
            }
            "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS" => self.pass_cells()?,
            "CELL_TYPES" => {
                let count = self.count("the number of cells")?;
                self.pass(CELL, count)?;
            }
            "OFFSETS" | "CONNECTIVITY" => return Err(format!("{keyword} without cells").into()),
            "POINT_DATA" => {
                let count = self.count("the number of points")?;
                if count != self.piece.count as u64 {
                    return Err(format!("data of {count} points for {}", self.piece.count).into());
                }
                *of = Of::Points;
            }
            "CELL_DATA" => {
                self.cells = self.count("the number of cells")?;
                *of = Of::Cells;
            }
            "METADATA" => self.metadata(),
            "FIELD" => self.field(*of)?,
            "LOOKUP_TABLE" => {
                self.word("a name")?;
                let count = self.count("the number of colours")?;
                self.pass(self.color(), count.saturating_mul(4))?;
            }
            "COLOR_SCALARS" => {
                let name = decoded(&self.word("a name")?);
                let components = self.components()?;
                let mut array = self.array(*of, name, components, self.color())?;
                if let (Some(array), false) = (&mut array, self.is_binary) {
                    array.scalar = BYTE;
                    array.numbers.iter_mut().for_each(|x| *x = (*x * 255.0).round().clamp(0.0, 255.0));
                }
                self.piece.arrays.extend(array);
            }
            "SCALARS"
            | "VECTORS"
            | "NORMALS"
            | "TENSORS"
            | "TENSORS6"
            | "TEXTURE_COORDINATES"
            | "GLOBAL_IDS"
            | "PEDIGREE_IDS"
            | "EDGE_FLAGS" => {
                let name = decoded(&self.word("a name")?);
                let listed = if keyword == "TEXTURE_COORDINATES" { Some(self.components()?) } else { None };
                let kind = self.kind()?;
                let components = match (keyword, listed) {
                    ("VECTORS" | "NORMALS", _) => 3,
                    ("TENSORS", _) => 9,
                    ("TENSORS6", _) => 6,
                    ("SCALARS", _) => self.scalars()?,
                    (_, listed) => listed.unwrap_or(1),
                };
                let array = self.array(*of, name, components, kind)?;
                self.piece.arrays.extend(array);
            }
            _ => return Err(format!("{} is not a section", quote(keyword)).into()),
        }
        Ok(())
    }

    /// The kind of the components of colours: bytes in binary, numbers up to 1 in text.
    fn color(&self) -> Kind {
        Kind::Number(if self.is_binary { BYTE } else { Scalar::float(4, true) })
    }

    fn is_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// Passes over metadata, which a blank line ends.
    fn metadata(&mut self) {
        self.line();
        while !self.is_end() && !self.line().is_empty() {}
    }

    fn components(&mut self) -> Result<usize, Fault> {
        within(self.count("the number of components")?)
    }

    /// The number of components behind the type of scalars, and the name of their table of colours, which is passed over.
    fn scalars(&mut self) -> Result<usize, Fault> {
        let begin = self.at;
        let line = self.line().to_owned();
        let mut words = line.split_whitespace();
        let components = words.next().and_then(|word| word.parse().ok());
        if components.is_none() || words.next().is_some() {
            // The next words may follow on the same line.
            self.at = begin;
        }
        let before = self.at;
        if self.next().is_some_and(|word| word.eq_ignore_ascii_case("LOOKUP_TABLE")) {
            self.word("the name of a table")?;
        } else {
            // Some writers leave the table out.
            self.at = if components.is_some() { before - 1 } else { before };
        }
        within(components.unwrap_or(1))
    }

    /// The cells: in version 5 two lists, before that one list of int32.
    fn pass_cells(&mut self) -> Result<(), Fault> {
        let (first, second) = (self.count("the number of cells")?, self.count("the size of the cells")?);
        let before = self.at;
        if self.version >= 5 && self.next().is_some_and(|word| word.eq_ignore_ascii_case("OFFSETS")) {
            let kind = self.kind()?;
            self.pass(kind, first)?;
            let word = self.word("CONNECTIVITY")?;
            if !word.eq_ignore_ascii_case("CONNECTIVITY") {
                return Err(format!("expected CONNECTIVITY, found {}", quote(&word)).into());
            }
            let kind = self.kind()?;
            return self.pass(kind, second);
        }
        self.at = before;
        self.pass(CELL, second)
    }

    /// The arrays of a field. One of the data set may have its time.
    fn field(&mut self, of: Of) -> Result<(), Fault> {
        self.word("a name")?;
        let arrays = self.count("the number of arrays")?;
        if arrays > MOST {
            return Err(format!("{arrays} arrays").into());
        }
        for _ in 0..arrays {
            let mut name = self.word("a name")?;
            while name == "METADATA" {
                self.metadata();
                name = self.word("a name")?;
            }
            let name = decoded(&name);
            let (components, tuples) = (self.count("the number of components")?, self.count("the number of tuples")?);
            let kind = self.kind()?;
            let is_whole = tuples == self.piece.count as u64 && within(components).is_ok();
            let is_time = of == Of::DataSet && tuples == 1 && components == 1;
            match (of, &name[..]) {
                (Of::Points, _) if is_whole => {
                    let array = self.values(&name, components as usize, tuples, kind, false)?;
                    self.piece.arrays.extend(array);
                }
                (Of::DataSet, "TimeValue" | "TIME" | "CYCLE") if is_time => {
                    let value = self.values(&name, 1, 1, kind, true)?.and_then(|array| array.numbers.first().copied());
                    match &name[..] {
                        "CYCLE" => self.when.step = value.map(|step| step as i64),
                        _ => self.when.time = FrameTime::of(value, None).time,
                    }
                }
                _ => self.pass(kind, components.saturating_mul(tuples))?,
            }
        }
        Ok(())
    }

    /// The array of a section, where it is one of points and is needed.
    fn array(&mut self, of: Of, name: String, components: usize, kind: Kind) -> Result<Option<Array>, Fault> {
        let tuples = if of == Of::Cells { self.cells } else { self.piece.count as u64 };
        match of {
            Of::Points => self.values(&name, components, tuples, kind, false),
            _ => self.pass(kind, tuples.saturating_mul(components as u64)).map(|()| None),
        }
    }

    /// An array of numbers, if it is needed; else its values are passed over.
    fn values(
        &mut self,
        name: &str,
        components: usize,
        tuples: u64,
        kind: Kind,
        is_sure: bool,
    ) -> Result<Option<Array>, Fault> {
        let scalar = match kind {
            Kind::Number(scalar) if is_sure || is_needed(self.request, name, components) => scalar,
            _ => {
                self.piece.others.push(name.to_owned());
                return self.pass(kind, tuples.saturating_mul(components as u64)).map(|()| None);
            }
        };
        let count = total(tuples, components).map_err(Fault::Limits)?;
        let mut numbers = Vec::new();
        if self.is_binary {
            let bytes = self.data(count as u64, scalar.size())?;
            reserve(&mut numbers, count).map_err(Fault::Limits)?;
            numbers.extend(bytes.chunks_exact(scalar.size()).map(|bytes| scalar.number(bytes)));
        } else {
            for _ in 0..count {
                reserve(&mut numbers, 1).map_err(Fault::Limits)?;
                let word =
                    self.next().ok_or_else(|| format!("the file ends after {} of {count} numbers", numbers.len()))?;
                numbers.push(number(word.as_bytes(), scalar)?);
            }
        }
        Ok(Some(Array { name: name.to_owned(), components, scalar, numbers }))
    }

    /// The bytes of so many binary values.
    fn data(&mut self, count: u64, size: usize) -> Result<&[u8], Fault> {
        self.begin_data();
        let begin = self.at;
        let end = usize::try_from(count).ok().and_then(|n| n.checked_mul(size)).and_then(|n| begin.checked_add(n));
        let end = end.filter(|end| *end <= self.bytes.len());
        let end = end.ok_or_else(|| format!("the file ends within {count} values of {size} bytes"))?;
        self.at = end;
        Ok(&self.bytes[begin..end])
    }

    /// Passes over values.
    fn pass(&mut self, kind: Kind, count: u64) -> Result<(), Fault> {
        let ends = || Fault::from("the file ends within an array".to_owned());
        match (kind, self.is_binary) {
            (Kind::Number(scalar), true) => self.data(count, scalar.size()).map(drop),
            (Kind::Bits, true) => self.data(count.div_ceil(8), 1).map(drop),
            (Kind::Texts, true) => {
                self.begin_data();
                (0..count).try_for_each(|_| self.pass_text())
            }
            // A text is a line, which may be empty.
            (Kind::Texts, false) => {
                self.line();
                (0..count).try_for_each(|_| {
                    let ended = self.is_end();
                    self.line();
                    if ended { Err(ends()) } else { Ok(()) }
                })
            }
            (_, false) => (0..count).try_for_each(|_| self.next().map(drop).ok_or_else(ends)),
        }
    }

    /// Passes over a text of binary data. The two highest bits of its first byte give the number of bytes of its length.
    fn pass_text(&mut self) -> Result<(), Fault> {
        let ends = || Fault::from("the file ends within a text".to_owned());
        let first = *self.bytes.get(self.at).ok_or_else(ends)?;
        let size = [8, 4, 2, 1][usize::from(first >> 6)];
        let head = self.bytes.get(self.at..self.at + size).ok_or_else(ends)?;
        let length = head[1..].iter().fold(u64::from(head[0] & 0x3f), |length, byte| length << 8 | u64::from(*byte));
        let end = usize::try_from(length).ok().and_then(|length| (self.at + size).checked_add(length));
        self.at = end.filter(|end| *end <= self.bytes.len()).ok_or_else(ends)?;
        Ok(())
    }
}
