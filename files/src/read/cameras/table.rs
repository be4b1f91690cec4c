//! Cameras in a table: a header that names `eye_x, eye_y, eye_z`, `view_x..` or `at_x..`, `up_x..`, and optionally `vfov`
//! or `fx, fy, cx, cy`; a row for each camera.

use super::lens::PixelLens;
use super::listed::ListedCamera;
use crate::read::lines::{Lines, has_content};
use crate::read::particles::table::fields::{delimiter, fields};
use halfline::error::{Error, Place, Result};
use halfline::quote::quote;
use halfline::scene::camera::{Intrinsics, Lens, Look};
use std::path::Path;

const MEND: &str = "use the columns eye_x,eye_y,eye_z, view_x,view_y,view_z or at_x,at_y,at_z, up_x,up_y,up_z, and \
                    optionally vfov or fx,fy,cx,cy";

/// All columns.
const COLUMNS: [&str; 17] = [
    "eye_x", "eye_y", "eye_z", "view_x", "view_y", "view_z", "at_x", "at_y", "at_z", "up_x", "up_y", "up_z", "vfov",
    "fx", "fy", "cx", "cy",
];

pub(super) fn read(bytes: &[u8], file: &Place) -> Result<Vec<ListedCamera>> {
    let mut lines = Lines::new(bytes, Path::new(file.file.as_deref().unwrap_or_default()));
    let (mut header, mut cameras): (Option<(u8, Vec<usize>)>, Vec<ListedCamera>) = (None, Vec::new());
    while lines.advance()? {
        if !has_content(lines.text()) {
            continue;
        }
        let Some((delimiter, columns)) = &header else {
            let delimiter = delimiter(lines.text());
            let column = |word: crate::read::lines::Word<'_, &[u8]>| {
                let known = COLUMNS.iter().position(|name| word.text.eq_ignore_ascii_case(name));
                known.ok_or_else(|| {
                    let problem = format!("{} is not a column of cameras", quote(word.text));
                    Error::scene(lines.place(word.at).named("header"), problem, MEND)
                })
            };
            let columns: Vec<usize> = fields(&lines, 0, delimiter).map(column).collect::<Result<_>>()?;
            header = Some((delimiter, columns));
            continue;
        };
        let mut values = [None; COLUMNS.len()];
        let mut words = fields(&lines, 0, *delimiter);
        for column in columns {
            let Some(word) = words.next() else {
                let problem = format!("expected {} fields", columns.len());
                let place = lines.place(lines.text().len()).named(COLUMNS[*column]);
                return Err(Error::scene(place, problem, "use one field per column"));
            };
            values[*column] = Some(word.finite(COLUMNS[*column])?);
        }
        drop(words);
        cameras.push(camera(&values).map_err(|field| {
            Error::scene(lines.place(0).named(format!("camera {} {field}", cameras.len())), "missing", MEND)
        })?);
    }
    Ok(cameras)
}

/// The camera of a row, or the column that is missing.
fn camera(values: &[Option<f64>; COLUMNS.len()]) -> Result<ListedCamera, &'static str> {
    let three = |from: usize| -> Result<[f64; 3], &'static str> {
        let mut found = [0.0; 3];
        for (k, value) in found.iter_mut().enumerate() {
            *value = values[from + k].ok_or(COLUMNS[from + k])?;
        }
        Ok(found)
    };
    let eye = three(0)?;
    let look = if values[6].is_some() { Look::At(three(6)?.into()) } else { Look::View(three(3)?.into()) };
    let camera = ListedCamera::new(eye, look, three(9)?);
    if let Some(degrees) = values[12] {
        return Ok(camera.with_lens(Lens::Vfov { degrees, distance: 1.0 }));
    }
    let Some(fx) = values[13] else { return Ok(camera) };
    let [fy, cx, cy] = [values[14].unwrap_or(fx), values[15].ok_or("cx")?, values[16].ok_or("cy")?];
    Ok(ListedCamera { intrinsics: Some(PixelLens::of(Intrinsics { fx, fy, cx, cy })), ..camera })
}
