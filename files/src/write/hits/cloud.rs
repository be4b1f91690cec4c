//! Hits as a point cloud: a point for each hit or echo, in the order of the rays; misses are left out. The number of points and
//! their bounds are in the header, so until the last row the points are in an anonymous file.

use super::las::{LasGrid, RETURNS};
use super::point::{Fields, Point};
use super::rows::{Query, Rows};
use super::{pcd, ply};
use crate::write::atomic::scratch;
use halfline::error::{Error, Result};
use halfline::progress::Watch;
use halfline::scene::{DEFAULT_COLOR, Spheres};
use halfline_particles::blocks;
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// The formats of point clouds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CloudFormat {
    Ply,
    Pcd,
    Las,
}

/// The summary of a written point cloud: its size, its rounding and the farthest hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudSummary {
    /// The number of points, one for each ray that hits, or for each echo.
    pub points: u64,
    /// The number of rays without a hit, or of beams without an echo, which are left out.
    pub left_out: u64,
    /// The largest difference between a coordinate of the file and the hit's coordinate in f64; 0 in PLY.
    pub rounding: f64,
    /// The largest distance of a hit from the origin of its ray; 0 without hits.
    pub farthest: f64,
}

/// A point cloud whose points are in a temporary file until all rows are known.
pub(super) struct Cloud {
    path: PathBuf,
    format: CloudFormat,
    fields: Fields,
    scan: Option<[u32; 2]>,
    file: File,
    rows: u64,
    summary: CloudSummary,
    /// The number of points by their number of the return, less 1.
    returns: [u64; RETURNS],
    /// The least and the largest coordinates.
    bounds: [[f64; 3]; 2],
}

/// The header of a cloud, and what adds a point of a colour to the bytes and returns the coordinates that it has there.
type Encoding = (Vec<u8>, Box<dyn Fn(&Point, [f32; 3], &mut Vec<u8>) -> [f64; 3]>);

/// Points that are encoded between two checks for cancellation.
const BLOCK: usize = 1 << 16;

impl Cloud {
    /// No points yet, of a cloud at `path`; the rays of a scan come in rings of columns.
    pub(super) fn new(path: &Path, format: CloudFormat, query: Query, scan: Option<[u32; 2]>) -> io::Result<Self> {
        let fields = match scan {
            _ if query == Query::Echoes => Fields::Echo,
            Some(_) => Fields::Scan,
            None => Fields::Ray,
        };
        let summary = CloudSummary { points: 0, left_out: 0, rounding: 0.0, farthest: 0.0 };
        let (file, bounds) = (scratch(path)?, [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]);
        let (path, returns) = (path.to_path_buf(), [0; RETURNS]);
        Ok(Self { path, format, fields, scan, file, rows: 0, summary, returns, bounds })
    }

    /// Adds the hits of a block.
    ///
    /// # Errors
    /// [`Error::Limits`] for a hit whose coordinates are beyond f64, and for rays that 32 bits cannot number;
    /// [`Error::Io`].
    pub(super) fn add(&mut self, rows: &Rows<'_>) -> Result<()> {
        let (points, rays) = self.points(rows)?;
        for point in &points {
            if !point.position.iter().all(|x| x.is_finite()) {
                let place = self.fields.names().iter().zip(point.numbers).map(|(name, n)| format!("{name} {n}"));
                let problem = format!("the hit of {} is beyond the range of f64", place.collect::<Vec<_>>().join(", "));
                return Err(Error::Limits { problem, mend: "use .npz, whose distances are finite".into() });
            }
            for (axis, x) in point.position.into_iter().enumerate() {
                self.bounds[0][axis] = self.bounds[0][axis].min(x);
                self.bounds[1][axis] = self.bounds[1][axis].max(x);
            }
            self.summary.farthest = self.summary.farthest.max(point.distance);
            self.returns[point.numbers[2] as usize - 1] += 1;
        }
        self.rows += rays;
        self.summary.points += points.len() as u64;
        // The first returns are as many as the rays with one.
        self.summary.left_out = self.rows - self.returns[0];
        self.file.write_all(bytemuck::cast_slice(&points)).map_err(|error| Error::write(&self.path, error))
    }

    /// The points of a block, and the number of its rays or beams.
    fn points(&self, rows: &Rows<'_>) -> Result<(Vec<Point>, u64)> {
        match rows {
            Rows::Nearest { id, distance, position, .. } => {
                let point = |row: usize| {
                    Ok(Point::new(position[row], distance[row], id[row], self.place(self.rows + row as u64)?))
                };
                let points = (0..rows.len()).filter(|row| id[*row] >= 0).map(point).collect::<Result<_>>()?;
                Ok((points, rows.len() as u64))
            }
            Rows::Echoes(echoes) => Ok((echoes.all.iter().map(Point::from).collect(), echoes.beams)),
            Rows::Any { .. } => Ok((Vec::new(), 0)),
        }
    }

    /// The ring and the column of a row, or its number.
    fn place(&self, row: u64) -> Result<[u32; 2]> {
        let number = |n: u64| {
            u32::try_from(n).map_err(|_| Error::Limits {
                problem: format!("the rays of {} are more than 32 bits can number", self.path.display()),
                mend: "divide the rays among several files, or use .npz".into(),
            })
        };
        match self.scan {
            Some([_, columns]) => Ok([number(row / u64::from(columns))?, number(row % u64::from(columns))?]),
            None => Ok([number(row)?, 0]),
        }
    }

    /// Writes the cloud, coloured by the spheres.
    pub(super) fn write(mut self, spheres: &Spheres, out: &mut dyn Write, watch: &Watch) -> Result<CloudSummary> {
        let failed = |path: &Path, error| Error::write(path, error);
        let (header, add) = self.encoding()?;
        out.write_all(&header).map_err(|error| failed(&self.path, error))?;
        self.file.rewind().map_err(|error| failed(&self.path, error))?;
        let (mut points, mut bytes, mut left) =
            (vec![Point::default(); blocks::at_most(BLOCK)], Vec::new(), self.summary.points);
        while left > 0 {
            watch.check()?;
            let size = left.min(points.len() as u64) as usize;
            let read = self.file.read_exact(bytemuck::cast_slice_mut(&mut points[..size]));
            read.map_err(|error| failed(&self.path, error))?;
            bytes.clear();
            for point in &points[..size] {
                let color = spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[point.id as usize]);
                for (written, exact) in add(point, color, &mut bytes).into_iter().zip(point.position) {
                    self.summary.rounding = self.summary.rounding.max((written - exact).abs());
                }
            }
            out.write_all(&bytes).map_err(|error| failed(&self.path, error))?;
            left -= size as u64;
        }
        Ok(self.summary)
    }

    /// The encoding, if its numbers can hold these points.
    fn encoding(&self) -> Result<Encoding> {
        let beyond = |what: &str| {
            let problem = format!("{} cannot hold the hits: {what}", self.path.display());
            Error::settings(problem, "use .ply, whose coordinates are f64")
        };
        let (count, fields, returns) = (self.summary.points, self.fields, &self.returns);
        Ok(match self.format {
            CloudFormat::Ply => {
                (ply::header(count, fields), Box::new(move |point, color, out| ply::point(point, color, fields, out)))
            }
            CloudFormat::Pcd => {
                let largest = self.bounds.iter().flatten().fold(self.summary.farthest, |most, x| most.max(x.abs()));
                if count > 0 && !(largest as f32).is_finite() {
                    return Err(beyond(&format!("{largest:e} is beyond the range of its f32")));
                }
                (pcd::header(count, fields), Box::new(move |point, color, out| pcd::point(point, color, fields, out)))
            }
            CloudFormat::Las => {
                let grid = LasGrid::of(self.bounds);
                let grid = grid.ok_or_else(|| beyond("they are farther apart than f64 can number"))?;
                (grid.header(returns, fields), Box::new(move |point, color, out| grid.point(point, color, fields, out)))
            }
        })
    }
}
