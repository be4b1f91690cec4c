//! The points of all scans of a file.

use crate::npy::header::Scalar;
use crate::particles::bytes::{BinaryFile, DAMAGED};
use crate::particles::frame::Particles;
use crate::particles::layout::Layout;
use crate::particles::meaning::{FieldKind, NamedField, meanings};
use crate::particles::request::Request;
use crate::source::Source;
use e57::{E57Reader, PointCloud, Record, RecordDataType, RecordName, RecordValue, Transform};
use glam::{DQuat, DVec3};
use halfline_ground::error::{Error, Place, Result, relocate};
use halfline_ground::memory::{check, check_ids};
use halfline_ground::quote::quote;
use std::io::Cursor;

/// The bytes of a page, with its checksum; the standard has no others.
const PAGE: u64 = 1024;

/// The most fields of a point, and the most bytes of the description in XML.
const MOST_FIELDS: usize = 1024;
const MOST_XML: u64 = 1 << 26;

/// Reads the points.
///
/// # Errors
/// [`Error::Scene`] with the scan and the point, [`Error::Io`], [`Error::Limits`].
pub(super) fn read(source: Source, request: &Request) -> Result<Particles> {
    let file = Place::file(source.path.display().to_string());
    let mut binary = BinaryFile::new(source);
    let mut bytes = Vec::new();
    binary.all(&mut bytes)?;
    binary.found();
    let fail = |field: &str, problem: String| Error::scene(file.clone().named(field), problem, DAMAGED);
    // The crate allocates what these numbers say.
    let number =
        |at: usize| bytes.get(at..at + 8).and_then(|bytes| bytes.first_chunk()).map(|bytes| u64::from_le_bytes(*bytes));
    match (number(32), number(40)) {
        (Some(xml), Some(PAGE)) if xml <= MOST_XML.min(bytes.len() as u64) => {}
        (Some(xml), Some(page)) => {
            return Err(fail(
                "header",
                format!("pages of {page} bytes and a description of {xml} do not fit the file"),
            ));
        }
        _ => return Err(fail("header", "the file ends within its header".into())),
    }
    let mut reader = E57Reader::new(Cursor::new(bytes)).map_err(|error| fail("header", words(&error)))?;
    let scans: Vec<PointCloud> = reader.pointclouds().into_iter().filter(|scan| scan.records > 0).collect();
    let total = scans.iter().fold(0, |total: u64, scan| total.saturating_add(scan.records));
    check_ids(total)?;
    check(total.saturating_mul(32), || format!("{total} points"))?;
    let Some(first) = scans.first() else { return Ok(Particles::default()) };
    let mut layout = Layout::whole(request);
    let fields = fields(first, &scans[1..]);
    let axes = ["x", "y", "z"].map(|name| NamedField { name, count: 1, kind: FieldKind::Binary(REAL) });
    let named =
        fields.iter().map(|(name, field)| NamedField { name, count: 1, kind: FieldKind::Binary(scalar(field)) });
    let named: Vec<NamedField<'_>> = axes.into_iter().chain(named).collect();
    layout.add_fields(meanings(&named)).map_err(|problem| fail("prototype", problem))?;
    let mut particles = layout.begin();
    for (k, scan) in scans.iter().enumerate() {
        let named = format!("scan {k}");
        let columns = Columns::of(scan, &fields).map_err(|problem| fail(&named, problem))?;
        let points = reader.pointcloud_raw(scan).map_err(|error| fail(&named, words(&error)))?;
        let mut row = Vec::with_capacity(fields.len() + 3);
        for (n, point) in points.enumerate() {
            if n % 4096 == 0 {
                request.watch.check()?;
            }
            let point = point.map_err(|error| fail(&format!("{named} point {n}"), words(&error)))?;
            if columns.row(&point, &mut row) {
                layout.checked_numbers(&row, &mut particles, |error| {
                    relocate(error, |field| file.clone().named(format!("{named} point {n} {field}")))
                })?;
            } else {
                let place = || file.clone().named(format!("{named} point {n}"));
                particles.skipped.skip("point without coordinates", request.strict, place)?;
            }
        }
    }
    particles.tell_left_out();
    Ok(particles)
}

/// The words of an error of the crate.
fn words(error: &e57::Error) -> String {
    error.to_string().trim_end_matches('.').to_owned()
}

/// The column of a field; `None` for the coordinates and for what says that a value is not valid.
fn name(record: &RecordName) -> Option<String> {
    Some(match record {
        RecordName::Intensity => "intensity".into(),
        RecordName::ColorRed => "red".into(),
        RecordName::ColorGreen => "green".into(),
        RecordName::ColorBlue => "blue".into(),
        RecordName::RowIndex => "row".into(),
        RecordName::ColumnIndex => "column".into(),
        RecordName::ReturnCount => "return_count".into(),
        RecordName::ReturnIndex => "return_index".into(),
        RecordName::TimeStamp => "time_stamp".into(),
        RecordName::Unknown { name, .. } => name.to_lowercase(),
        _ => return None,
    })
}

/// The names and records of the fields that all scans have besides coordinates, in the order of the first.
fn fields<'a>(first: &'a PointCloud, others: &[PointCloud]) -> Vec<(String, &'a Record)> {
    let has = |scan: &PointCloud, field: &Record| scan.prototype.iter().any(|record| record.name == field.name);
    let named = first.prototype.iter().filter_map(|record| Some((name(&record.name)?, record)));
    named.filter(|(_, field)| others.iter().all(|scan| has(scan, field))).take(MOST_FIELDS).collect()
}

const REAL: Scalar = Scalar::float(8, false);

/// The type of a field's numbers, by which numbers of colours are levels.
fn scalar(field: &Record) -> Scalar {
    match field.data_type {
        RecordDataType::Integer { min: 0.., max: ..=0xff } => Scalar::unsigned(1, false),
        RecordDataType::Integer { min: 0.., max: ..=0xffff } => Scalar::unsigned(2, false),
        RecordDataType::Integer { .. } => Scalar::unsigned(8, false),
        _ => REAL,
    }
}

/// The places of the fields in the points of a scan, and its pose.
struct Columns<'a> {
    scan: &'a PointCloud,
    /// Three coordinates, whether they are a range and two angles, and the field that says whether they are valid.
    axes: [usize; 3],
    is_spherical: bool,
    axes_invalid: Option<usize>,
    /// Each field, and the one that says whether it is valid.
    fields: Vec<(usize, Option<usize>)>,
    pose: Option<(DQuat, DVec3)>,
}

impl<'a> Columns<'a> {
    fn of(scan: &'a PointCloud, fields: &[(String, &Record)]) -> Result<Self, String> {
        use RecordName::{
            CartesianInvalidState, CartesianX, CartesianY, CartesianZ, Intensity, IsIntensityInvalid,
            IsTimeStampInvalid, SphericalAzimuth, SphericalElevation, SphericalInvalidState, SphericalRange, TimeStamp,
        };
        let has_bits = |record: &Record| {
            !matches!(
                record.data_type,
                RecordDataType::Integer { min, max } | RecordDataType::ScaledInteger { min, max, .. } if min >= max
            )
        };
        // The crate would make points without end.
        if !scan.prototype.iter().any(has_bits) {
            return Err("its points have no data".into());
        }
        let at = |name: &RecordName| scan.prototype.iter().position(|record| record.name == *name);
        let all = |[a, b, c]: [RecordName; 3]| Some([at(&a)?, at(&b)?, at(&c)?]);
        let cartesian = all([CartesianX, CartesianY, CartesianZ]);
        let spherical = || all([SphericalRange, SphericalAzimuth, SphericalElevation]);
        let axes = cartesian.or_else(spherical).ok_or("its points have no coordinates")?;
        let invalid = |name: &RecordName| match name {
            Intensity => at(&IsIntensityInvalid),
            TimeStamp => at(&IsTimeStampInvalid),
            _ => None,
        };
        let place = |(name, field): &(String, &Record)| {
            let at = at(&field.name).ok_or_else(|| format!("it has no field {}", quote(name)))?;
            Ok((at, invalid(&field.name)))
        };
        let pose = |Transform { rotation, translation }: &Transform| {
            let rotation = DQuat::from_xyzw(rotation.x, rotation.y, rotation.z, rotation.w);
            (rotation, DVec3::new(translation.x, translation.y, translation.z))
        };
        Ok(Self {
            scan,
            axes,
            is_spherical: cartesian.is_none(),
            axes_invalid: at(if cartesian.is_some() { &CartesianInvalidState } else { &SphericalInvalidState }),
            fields: fields.iter().map(place).collect::<Result<_, String>>()?,
            pose: scan.transform.as_ref().map(pose),
        })
    }

    /// A number of a point.
    fn number(&self, point: &[RecordValue], at: usize) -> f64 {
        point[at].to_f64(&self.scan.prototype[at].data_type).unwrap_or(f64::NAN)
    }

    /// Fills a row with the coordinates and the fields of a point; returns whether it has coordinates.
    fn row(&self, point: &[RecordValue], row: &mut Vec<f64>) -> bool {
        let is_invalid = |at: Option<usize>| at.is_some_and(|at| self.number(point, at) != 0.0);
        if is_invalid(self.axes_invalid) {
            return false;
        }
        let [a, b, c] = self.axes.map(|at| self.number(point, at));
        let place = match self.is_spherical {
            true => DVec3::new(a * c.cos() * b.cos(), a * c.cos() * b.sin(), a * c.sin()),
            false => DVec3::new(a, b, c),
        };
        let place = self.pose.map_or(place, |(rotation, translation)| rotation * place + translation);
        row.clear();
        row.extend(place.to_array());
        let value = |(at, invalid): &(usize, Option<usize>)| {
            if is_invalid(*invalid) { f64::NAN } else { self.number(point, *at) }
        };
        row.extend(self.fields.iter().map(value));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two scans of five points by pye57, the first one turned by a right angle about z and moved; two points are not valid.
    const SCANS: &[u8] = include_bytes!("two_scans.e57");

    #[test]
    fn scans_lie_at_their_poses_and_points_that_are_not_valid_are_left_out() {
        let found = super::read(Source::of_bytes(SCANS), &Request::of(&["intensity"])).expect("two scans").linearized();
        let own = [[1.0, 0.5, 0.0], [3.0, -1.0, 2.0], [4.0, 2.0, 3.0]];
        let turned = own.map(|[x, y, z]| [100.0 - y, 200.0 + x, 300.0 + z]);
        assert_eq!(found.positions.len(), 6);
        for (position, expected) in found.positions.iter().zip(turned.iter().chain(&own)) {
            // The quaternion of the file is rounded, and the coordinates are below 512.
            assert!(
                (0..3).all(|k| (position[k] - expected[k]).abs() < 512.0 * f64::EPSILON),
                "{position:?} {expected:?}"
            );
        }
        let column = found.columns.iter().find(|column| column.name == "intensity").expect("intensity");
        assert_eq!(column.values, [0.5, 0.25, 1.0, 0.5, 0.25, 1.0]);
        assert_eq!(found.colors[..2], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(found.skipped.kinds, [("point without coordinates", 4)]);
    }

    #[test]
    fn sizes_that_are_not_those_of_the_file_are_refused() {
        let of = |at: usize, number: u64| {
            let mut bytes = SCANS.to_vec();
            bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
            super::read(Source::of_bytes(&bytes), &Request::default()).map(drop).expect_err("a header").to_string()
        };
        assert!(of(32, 1 << 40).contains("a description of 1099511627776"), "{}", of(32, 1 << 40));
        assert!(of(40, 1 << 40).contains("pages of 1099511627776 bytes"), "{}", of(40, 1 << 40));
        for end in [40, 1024, SCANS.len() - 1] {
            super::read(Source::of_bytes(&SCANS[..end]), &Request::default()).map(drop).expect_err("cut short");
        }
    }
}
