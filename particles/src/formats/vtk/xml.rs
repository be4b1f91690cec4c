//! XML files of VTK: elements, and the data of their arrays.

use super::encoded::{Compressor, Encoding, Fault, numbers_of_text};
use super::points::{Array, MOST_COMPONENTS, Piece, Pieces, is_needed, total};
use crate::npy::header::Scalar;
use crate::particles::bytes::DAMAGED;
use crate::particles::frame_time::FrameTime;
use crate::particles::request::Request;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::quote;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// The content of a file.
pub(super) enum Content {
    Pieces(Pieces),
    /// The files of the pieces.
    Parts(Vec<String>),
    /// Files by their time, in the order of the file.
    Collection(Vec<(Option<f64>, String)>),
}

/// The most elements within each other, and the most files that a file names.
const MOST_DEPTH: usize = 64;
const MOST_FILES: usize = 1 << 20;

/// An array of the file that is needed, and the place of its data.
struct Needed {
    array: Array,
    /// Points or tuples.
    count: u64,
    data: Data,
    /// The piece that it belongs to, and whether it has the coordinates; `None` for the time.
    of: Option<(usize, bool)>,
}

/// The place of data.
enum Data {
    Text(usize),
    Base64(usize),
    /// Behind the elements, by its number of bytes or of characters.
    Appended(u64),
}

/// A file while it is read.
struct File<'a> {
    bytes: &'a [u8],
    place: &'a Place,
    request: &'a Request,
    kind: String,
    encoding: Encoding,
    pieces: Vec<Piece>,
    needed: Vec<Needed>,
    /// The first appended byte, and whether it is base64.
    appended: Option<(usize, bool)>,
    parts: Vec<String>,
    files: Vec<(Option<f64>, String)>,
}

/// Reads the content of a file.
///
/// # Errors
/// [`Error::Scene`], [`Error::Limits`].
pub(super) fn read(bytes: &[u8], place: &Place, request: &Request) -> Result<Content> {
    let mut file = File {
        bytes,
        place,
        request,
        kind: String::new(),
        encoding: Encoding { big: false, is_long: false, compressor: None },
        pieces: Vec::new(),
        needed: Vec::new(),
        appended: None,
        parts: Vec::new(),
        files: Vec::new(),
    };
    file.elements()?;
    match &file.kind[..] {
        "PolyData" | "UnstructuredGrid" | "StructuredGrid" => file.pieces().map(Content::Pieces),
        "PPolyData" | "PUnstructuredGrid" | "PStructuredGrid" => Ok(Content::Parts(file.parts)),
        "Collection" => Ok(Content::Collection(file.files)),
        "" => Err(file.fail("VTKFile", "the file has no element VTKFile")),
        kind => {
            let problem = format!("a file of the type {} has no points of its own", quote(kind));
            Err(Error::scene(
                place.clone().named("VTKFile"),
                problem,
                "use PolyData, UnstructuredGrid or StructuredGrid",
            ))
        }
    }
}

/// An attribute of an element.
fn attribute(element: &BytesStart<'_>, name: &str) -> Result<Option<String>, String> {
    for attribute in element.attributes() {
        let attribute = attribute.map_err(|error| format!("an element is malformed: {error}"))?;
        if attribute.key.as_ref() == name {
            let value = attribute.normalized_value(quick_xml::XmlVersion::Implicit1_0);
            return value.map(|value| Some(value.trim().to_owned())).map_err(|error| error.to_string());
        }
    }
    Ok(None)
}

impl File<'_> {
    fn fail(&self, field: &str, problem: impl Into<String>) -> Error {
        Error::scene(self.place.clone().named(field), problem, DAMAGED)
    }

    fn elements(&mut self) -> Result<()> {
        let mut reader = Reader::from_reader(self.bytes);
        let mut open: Vec<String> = Vec::new();
        loop {
            let at = reader.buffer_position();
            let event = reader.read_event().map_err(|error| self.fail(&format!("byte {at}"), error.to_string()))?;
            let end = reader.buffer_position() as usize;
            match event {
                Event::Start(element) => {
                    if self.element(&element, &open, end).map_err(|error| self.located(error, at))? {
                        return Ok(());
                    }
                    if open.len() == MOST_DEPTH {
                        return Err(self.fail(&format!("byte {at}"), "too many elements within each other"));
                    }
                    open.push(element.name().as_ref().to_owned());
                }
                Event::Empty(element) => {
                    self.element(&element, &open, end).map_err(|error| self.located(error, at))?;
                }
                Event::End(_) => drop(open.pop()),
                Event::Eof if open.is_empty() => return Ok(()),
                Event::Eof => {
                    return Err(self.fail("VTKFile", format!("the file ends within {}", quote(&open[open.len() - 1]))));
                }
                _ => {}
            }
            self.request.watch.check()?;
        }
    }

    fn located(&self, fault: Fault, at: u64) -> Error {
        fault.at(self.place.clone().named(format!("byte {at}")))
    }

    /// Takes an element; returns whether the rest of the file is appended data.
    fn element(&mut self, element: &BytesStart<'_>, open: &[String], end: usize) -> Result<bool, Fault> {
        let of = |name: &str| attribute(element, name);
        let inside = |name: &str| open.iter().any(|outer| outer == name);
        match element.name().as_ref() {
            "VTKFile" if open.is_empty() => {
                self.kind = of("type")?.unwrap_or_default();
                self.encoding = Encoding {
                    big: of("byte_order")?.as_deref() == Some("BigEndian"),
                    is_long: of("header_type")?.as_deref() == Some("UInt64"),
                    compressor: match of("compressor")?.as_deref() {
                        None | Some("") => None,
                        Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
                        Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
                        Some("vtkLZMADataCompressor") => Some(Compressor::Xz),
                        Some(other) => return Err(format!("the compressor {} is not known", quote(other)).into()),
                    },
                };
            }
            "Piece" => {
                if let Some(source) = of("Source")? {
                    self.parts.push(source);
                } else {
                    let count = self.points(&of)?;
                    self.pieces.push(Piece { count: count as usize, ..Piece::default() });
                }
            }
            "DataSet" if inside("Collection") => {
                let time = of("timestep")?.and_then(|text| text.parse().ok());
                self.files.extend(of("file")?.map(|file| (time, file)));
            }
            "DataArray" | "Array" => self.array(element, open, end)?,
            "AppendedData" => {
                let is_base64 = of("encoding")?.as_deref() != Some("raw");
                let begin = self.bytes[end..].iter().position(|byte| *byte == b'_');
                let begin = begin.ok_or_else(|| "the appended data do not begin with _".to_owned())?;
                self.appended = Some((end + begin + 1, is_base64));
                return Ok(true);
            }
            _ => {}
        }
        if self.parts.len() + self.files.len() + self.pieces.len() > MOST_FILES {
            return Err(format!("there are more than {MOST_FILES} pieces").into());
        }
        Ok(false)
    }

    /// The number of points of a piece; for a structured grid, from its extent.
    fn points(&self, of: &dyn Fn(&str) -> Result<Option<String>, String>) -> Result<u64, String> {
        if let Some(text) = of("NumberOfPoints")? {
            return text.parse().map_err(|_| format!("{} is not a number of points", quote(&text)));
        }
        let extent = of("Extent")?.ok_or("a piece has no number of points")?;
        let ends: Vec<i64> = extent.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let side = |ends: &[i64]| u64::try_from(ends[1].checked_sub(ends[0])?.checked_add(1)?).ok();
        let sides =
            (ends.len() == 6).then(|| ends.chunks(2).map(side).try_fold(1, |all: u64, side| all.checked_mul(side?)));
        sides.flatten().ok_or_else(|| format!("{} is not an extent", quote(&extent)))
    }

    fn array(&mut self, element: &BytesStart<'_>, open: &[String], end: usize) -> Result<(), Fault> {
        let of = |name: &str| attribute(element, name);
        let Some(section) = open.last() else { return Ok(()) };
        let name = of("Name")?.unwrap_or_default();
        let is_points = section == "Points" && self.pieces.last().is_some_and(|piece| piece.points.is_none());
        let is_time = section == "FieldData" && ["TimeValue", "TIME"].contains(&&name[..]) && self.pieces.is_empty();
        if !(is_points || is_time || section == "PointData" && !self.pieces.is_empty()) {
            return Ok(());
        }
        let components: usize = match of("NumberOfComponents")? {
            None => 1,
            Some(text) if text.is_empty() => 1,
            Some(text) => text
                .parse()
                .ok()
                .filter(|n| *n as u64 <= MOST_COMPONENTS)
                .ok_or_else(|| format!("{} components", quote(&text)))?,
        };
        let components = if is_points { 3 } else { components.max(1) };
        let kind = of("type")?.unwrap_or_default();
        let scalar = scalar(&kind, self.encoding.big);
        let (last, count) =
            (self.pieces.len().wrapping_sub(1), self.pieces.last().map_or(1, |piece| piece.count as u64));
        let (Some(scalar), true) = (scalar, is_points || is_time || is_needed(self.request, &name, components)) else {
            if section == "PointData" {
                self.pieces[last].others.push(name);
            }
            return Ok(());
        };
        let data = match of("format")?.as_deref() {
            None | Some("ascii") => Data::Text(end),
            Some("binary") => Data::Base64(end),
            Some("appended") => {
                let offset = of("offset")?.unwrap_or_default();
                Data::Appended(offset.parse().map_err(|_| format!("{} is not an offset", quote(&offset)))?)
            }
            Some(other) => return Err(format!("the format {} is not known", quote(other)).into()),
        };
        let array = Array { name, components, scalar, numbers: Vec::new() };
        if is_points {
            // Marked as found; its numbers follow.
            self.pieces[last].points = Some(array.clone());
        }
        self.needed.push(Needed { array, count, data, of: (!is_time).then_some((last, is_points)) });
        Ok(())
    }

    /// The pieces with the numbers of their arrays.
    fn pieces(mut self) -> Result<Pieces> {
        let mut when = FrameTime::default();
        for Needed { mut array, count, data, of } in std::mem::take(&mut self.needed) {
            self.request.watch.check()?;
            let shown = if array.name.is_empty() { "Points" } else { &array.name }.to_owned();
            let total = total(count, array.components)?;
            let numbers = self.numbers(&data, array.scalar, total);
            array.numbers = numbers.map_err(|fault| fault.at(self.place.clone().named(shown)))?;
            match of {
                None => when = FrameTime::of(array.numbers.first().copied(), None),
                Some((piece, true)) => self.pieces[piece].points = Some(array),
                Some((piece, false)) => self.pieces[piece].arrays.push(array),
            }
        }
        if self.pieces.iter().any(|piece| piece.count > 0 && piece.points.is_none()) {
            return Err(self.fail("Points", "a piece has no points"));
        }
        Ok(Pieces { all: self.pieces, when })
    }

    fn numbers(&self, data: &Data, scalar: Scalar, count: usize) -> Result<Vec<f64>, Fault> {
        let inline = |begin: usize| {
            let rest = &self.bytes[begin.min(self.bytes.len())..];
            &rest[..rest.iter().position(|byte| *byte == b'<').unwrap_or(rest.len())]
        };
        match *data {
            Data::Text(begin) => numbers_of_text(inline(begin), scalar, count),
            Data::Base64(begin) => self.encoding.numbers(inline(begin), true, scalar, count),
            Data::Appended(offset) => {
                let (begin, is_base64) = self.appended.ok_or_else(|| "the file has no appended data".to_owned())?;
                let at = usize::try_from(offset).ok().and_then(|offset| begin.checked_add(offset));
                let rest = at.and_then(|at| self.bytes.get(at..));
                let rest = rest.ok_or_else(|| format!("the offset {offset} is behind the end of the file"))?;
                self.encoding.numbers(rest, is_base64, scalar, count)
            }
        }
    }
}

/// The type of this name; `None` for texts and bits.
fn scalar(name: &str, big: bool) -> Option<Scalar> {
    Scalar::of_ply(&name.to_ascii_lowercase(), big).or_else(|| match name {
        "Int64" => Scalar::of_numpy(if big { ">i8" } else { "<i8" }),
        "UInt64" => Scalar::of_numpy(if big { ">u8" } else { "<u8" }),
        _ => None,
    })
}
