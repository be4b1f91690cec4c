//! Cameras in a table: a header that names `eye_x, eye_y, eye_z`, `view_x..` or `at_x..`, `up_x..`, and optionally `vfov`
//! or `fx, fy, cx, cy`; a row for each camera.

use super::lens::PixelLens;
use super::listed::ListedCamera;
use halfline::error::{Error, Place, Result};
use halfline::scene::camera::{Intrinsics, Lens, Look};
use halfline_particles::formats::table::fields::{declared_delimiter, delimiter, each_number, named_columns};
use halfline_particles::lines::{Lines, has_content};
use std::ops::Range;
use std::path::Path;

const MEND: &str = "use the columns eye_x,eye_y,eye_z, view_x,view_y,view_z or at_x,at_y,at_z, up_x,up_y,up_z, and \
                    optionally vfov or fx,fy,cx,cy";

/// All columns.
const COLUMNS: [&str; 17] = [
    "eye_x", "eye_y", "eye_z", "view_x", "view_y", "view_z", "at_x", "at_y", "at_z", "up_x", "up_y", "up_z", "vfov",
    "fx", "fy", "cx", "cy",
];

/// The columns of the direction of view, of the point to look at, of the angle, and of the intrinsics.
const VIEW: Range<usize> = 3..6;
const AT: Range<usize> = 6..9;
const VFOV: Range<usize> = 12..13;
const PIXELS: Range<usize> = 13..17;

pub(super) fn read(bytes: &[u8], file: &Place) -> Result<Vec<ListedCamera>> {
    let mut lines = Lines::new(bytes, Path::new(file.file.as_deref().unwrap_or_default()));
    let (mut header, mut cameras): (Option<(u8, Vec<usize>)>, Vec<ListedCamera>) = (None, Vec::new());
    let mut declared = None;
    while lines.advance()? {
        if !has_content(lines.text()) {
            continue;
        }
        let Some((delimiter, columns)) = &header else {
            if let (None, Some(delimiter)) = (declared, declared_delimiter(lines.text())) {
                declared = Some(delimiter);
                continue;
            }
            let delimiter = declared.unwrap_or_else(|| delimiter(lines.text()));
            let columns = named_columns(&lines, (0, delimiter), &COLUMNS, MEND)?;
            check_header(&columns)
                .map_err(|problem| Error::scene(lines.place(0).named("header"), problem, "remove one of them"))?;
            header = Some((delimiter, columns));
            continue;
        };
        let mut values = [None; COLUMNS.len()];
        each_number(&lines, *delimiter, (columns, &COLUMNS), "use one number per column", |column, word| {
            values[column] = Some(word.finite(COLUMNS[column])?);
            Ok(())
        })?;
        cameras.push(camera(&values).map_err(|field| {
            Error::scene(lines.place(0).named(format!("camera {} {field}", cameras.len())), "missing", MEND)
        })?);
    }
    Ok(cameras)
}

/// Finds columns that give one thing in two ways.
fn check_header(columns: &[usize]) -> Result<(), String> {
    let first_of = |group: Range<usize>| columns.iter().find(|column| group.contains(column));
    for [one, other] in [[VIEW, AT], [VFOV, PIXELS]] {
        if let (Some(one), Some(other)) = (first_of(one), first_of(other)) {
            return Err(format!("`{}` and `{}` exclude each other", COLUMNS[*one], COLUMNS[*other]));
        }
    }
    Ok(())
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
    let has = |group: Range<usize>| values[group].iter().any(Option::is_some);
    let look = if has(AT) { Look::At(three(AT.start)?.into()) } else { Look::View(three(VIEW.start)?.into()) };
    let camera = ListedCamera::new(eye, look, three(9)?);
    if let Some(degrees) = values[VFOV.start] {
        return Ok(camera.with_lens(Lens::Vfov { degrees, distance: 1.0 }));
    }
    if !has(PIXELS) {
        return Ok(camera);
    }
    let fx = values[PIXELS.start].ok_or("fx")?;
    let [fy, cx, cy] = [values[14].unwrap_or(fx), values[15].ok_or("cx")?, values[16].ok_or("cy")?];
    Ok(ListedCamera { intrinsics: Some(PixelLens::of(Intrinsics { fx, fy, cx, cy })), ..camera })
}
