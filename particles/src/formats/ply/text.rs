//! The vertices of a polygon file in text.

use super::header::{PlyElement, short_of, truncated};
use super::vertex::VertexColumns;
use crate::input::Input;
use crate::lines::{Lines, Words};
use crate::npy::header::{bits, levels};
use crate::particles::frame::Particles;
use crate::particles::role::Role;
use crate::particles::rows::{blank_rest, filled_rows};
use halfline_ground::error::{Result, relocate};
use halfline_ground::quote::quote;
use std::io::BufRead;

/// Reads the vertices, on all cores.
pub(super) fn text(
    lines: &mut Lines<Input>,
    element: &PlyElement,
    columns: &VertexColumns,
    particles: &mut Particles,
) -> Result<()> {
    let add = |line: &Lines<&[u8]>, particles: &mut Particles| vertex(line, element, columns, particles);
    match filled_rows(lines, element.count, &columns.layout, particles, add)? {
        read if read < element.count => Err(truncated(lines.file(), read, element)),
        _ => Ok(()),
    }
}

/// Adds the vertex of a line.
fn vertex<R: BufRead>(
    lines: &Lines<R>,
    element: &PlyElement,
    columns: &VertexColumns,
    particles: &mut Particles,
) -> Result<()> {
    let layout = &columns.layout;
    let (mut numbers, mut invalid) = (Vec::with_capacity(layout.len()), None);
    let mut words = Words::of(lines);
    for (k, property) in element.properties.iter().enumerate() {
        let need = || lines.ends(&property.name, "the line ends before it", "give every property of the vertex");
        let word = words.next().ok_or_else(need)?;
        match property.length {
            Some(_) => {
                // Each item is a word; items beyond the line are missing.
                let count = word.finite(&property.name)?;
                for _ in 0..count as u64 {
                    words.next().ok_or_else(need)?;
                }
            }
            None if columns.packed == Some(k) => {
                numbers.extend(levels(bits(word.number(&property.name)?, property.scalar)));
            }
            None => {
                let (role, name) = (layout.role(numbers.len()), &property.name);
                let number = match role {
                    Role::Radius | Role::Diameter => word.positive(name),
                    Role::Position(_) | Role::Color(_) => word.finite(name),
                    _ => word.number(name),
                };
                let skips = layout.skips_invalid() && role.is_checked();
                let number = match number {
                    Err(error) if skips => {
                        invalid.get_or_insert(error);
                        f64::NAN
                    }
                    number => number.map_err(|error| layout.offer_to_skip(numbers.len(), error))?,
                };
                numbers.push(number);
            }
        }
    }
    if let Some(word) = words.next() {
        let problem =
            format!("{} is one number more than the {} properties", quote(word.text), element.properties.len());
        let mend = "correct the number of vertices and the list of their properties";
        return Err(lines.fail(word.at, "vertex", problem, mend));
    }
    match invalid {
        Some(error) => particles.reading.left_out.add(error),
        None => {
            columns.add(&mut numbers, particles, |e| relocate(e, |field| lines.place(0).named(field)))?;
        }
    }
    Ok(())
}

/// Skips the lines of an element; returns their number. Lines without properties are blank.
pub(super) fn pass(lines: &mut Lines<Input>, element: &PlyElement) -> Result<u64> {
    if element.properties.is_empty() { lines.pass(element.count) } else { lines.pass_filled(element.count) }
}

/// Checks that the lines after the vertices belong to the other elements, so that no vertex is among them.
pub(super) fn rest_of_text(
    lines: &mut Lines<Input>,
    vertices: &PlyElement,
    behind: &[PlyElement],
    particles: &mut Particles,
) -> Result<()> {
    for element in behind {
        let passed = pass(lines, element)?;
        if passed < element.count {
            particles.skipped.assumed.push(short_of(lines.file(), passed, element));
            return Ok(());
        }
    }
    blank_rest(lines, vertices.count, "vertices")
}
