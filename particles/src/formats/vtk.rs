//! Points of VTK: XML files of polygons and unstructured grids (`.vtp`, `.vtu`), those in parts (`.pvtp`, `.pvtu`), collections of
//! times (`.pvd`) and the legacy format (`.vtk`), as docs.vtk.org/en/latest/vtk_file_formats describes them. The points are the
//! particles and the arrays of points their columns; cells and their arrays are passed over. The crate vtkio (0.7.0-rc2) binds lz4
//! and xz of C.

#[cfg(feature = "formats")]
mod encoded;
#[cfg(feature = "formats")]
mod frames;
#[cfg(feature = "formats")]
mod legacy;
#[cfg(feature = "formats")]
mod points;
#[cfg(feature = "formats")]
mod xml;

use crate::format::{FormatRow, Has, Open, Sign};

pub(crate) const VTK: FormatRow = FormatRow {
    name: "vtk",
    about: "points of VTK, XML and legacy",
    endings: &["vtp", "vtu", "pvtp", "pvtu", "pvd"],
    signs: &[Sign::Signature(is_vtk)],
    has: &[Has::AnyColumns],
    open: OPEN,
    ..FormatRow::PLAIN
};

#[cfg(feature = "formats")]
const OPEN: Open = Open::Frames(|source, request, _| frames::open(source, request));
#[cfg(not(feature = "formats"))]
const OPEN: Open = Open::Lacking;

/// The first line of the legacy format, or XML with an element `VTKFile` in its first lines.
fn is_vtk(lines: &[&str]) -> bool {
    let first = lines.iter().map(|line| line.trim()).find(|line| !line.is_empty()).unwrap_or_default();
    let is_xml = ["<?xml", "<!--", "<VTKFile"].iter().any(|start| first.starts_with(start));
    first.starts_with("# vtk DataFile") || is_xml && lines.iter().take(16).any(|line| line.contains("<VTKFile"))
}

#[cfg(all(test, feature = "formats"))]
mod tests;
