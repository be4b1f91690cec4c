//! The vertices of a polygon file in binary.

use super::header::{PlyElement, Property, short_of, truncated};
use super::vertex::VertexColumns;
use crate::input::{Input, fill};
use crate::npy::header::Scalar;
use crate::particles::bytes::skip;
use crate::particles::frame::Particles;
use halfline_ground::error::{Error, Place, Result, relocate};
use std::io::{self, BufReader, Read};
use std::path::PathBuf;

/// The most bytes that are counted after the last element.
const BEHIND: u64 = 1 << 29;

/// The binary data after a header.
pub(super) struct Binary {
    pub(super) reader: BufReader<Input>,
    pub(super) path: PathBuf,
}

impl Binary {
    /// Fills `bytes`; `false` at the end of the file.
    fn bytes(&mut self, bytes: &mut [u8]) -> Result<bool> {
        match self.reader.read_exact(bytes) {
            Ok(()) => Ok(true),
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
            Err(e) => Err(Error::read(&self.path, e)),
        }
    }

    /// A number; `None` at the end of the file.
    fn number(&mut self, scalar: Scalar) -> Result<Option<f64>> {
        let mut bytes = [0; 8];
        Ok(self.bytes(&mut bytes[..scalar.size()])?.then(|| scalar.number(&bytes)))
    }

    /// Skips bytes; returns the number skipped.
    fn skip(&mut self, bytes: u64) -> Result<u64> {
        skip(&mut self.reader, &self.path, bytes)
    }

    /// Skips a property; `false` at the end of the file.
    fn skip_property(&mut self, property: &Property) -> Result<bool> {
        let size = property.scalar.size() as u64;
        let bytes = match property.length {
            None => size,
            Some(length) => match self.number(length)? {
                Some(count) => (count as u64).saturating_mul(size),
                None => return Ok(false),
            },
        };
        Ok(self.skip(bytes)? == bytes)
    }

    /// Skips an element's entries; returns the number skipped.
    pub(super) fn pass(&mut self, element: &PlyElement) -> Result<u64> {
        if element.properties.iter().all(|property| property.length.is_none()) {
            let size = element.properties.iter().map(|property| property.scalar.size() as u64).sum::<u64>();
            let passed = self.skip(element.count.saturating_mul(size))?;
            return Ok(passed.checked_div(size).unwrap_or(element.count));
        }
        for entry in 0..element.count {
            for property in &element.properties {
                if !self.skip_property(property)? {
                    return Ok(entry);
                }
            }
        }
        Ok(element.count)
    }

    /// Checks that only the other elements follow the vertices.
    pub(super) fn rest(
        &mut self,
        vertices: &PlyElement,
        behind: &[PlyElement],
        particles: &mut Particles,
    ) -> Result<()> {
        let file = Place::file(self.path.display().to_string());
        for element in behind {
            let passed = self.pass(element)?;
            if passed < element.count {
                particles.skipped.assumed.push(short_of(file, passed, element));
                return Ok(());
            }
        }
        let left = self.skip(BEHIND)?;
        let numbers = vertices.properties.iter().map(|property| property.length.unwrap_or(property.scalar));
        let size = numbers.map(|number| number.size() as u64).sum::<u64>().max(1);
        if left < size {
            return Ok(());
        }
        let what = format!("expected {} vertices, but {left} bytes follow the last element", vertices.count);
        if behind.is_empty() && left.is_multiple_of(size) {
            let problem = format!("{what}, the size of {} more vertices", left / size);
            return Err(Error::scene(file.named("count"), problem, "correct the count"));
        }
        particles.skipped.assumed.push(format!("{file}: {what}; the number of vertices may be wrong"));
        Ok(())
    }

    /// Reads the vertices, which all cores decode.
    pub(super) fn vertices(
        &mut self,
        element: &PlyElement,
        columns: &VertexColumns,
        particles: &mut Particles,
    ) -> Result<()> {
        let file = Place::file(self.path.display().to_string());
        let (record, mut block, mut read) = (&columns.record, Vec::new(), 0);
        while read < element.count {
            let most = record.per_block().min(element.count - read);
            let found = self.records(element, record.size(), most, &mut block)?;
            record.append(&block, &columns.layout, particles, columns.splat.is_none(), |n, numbers, particles| {
                let vertex = read + n as u64;
                let placed = |e| relocate(e, |field| file.clone().named(format!("vertex {vertex} {field}")));
                columns.add(numbers, particles, placed)
            })?;
            self.reader.get_ref().found();
            read += found;
            if found < most {
                return Err(truncated(file, read, element));
            }
        }
        Ok(())
    }

    /// Replaces the content of `block` with at most `most` vertices without their lists, `size` bytes each; returns their number,
    /// which is lower where the file ends before.
    fn records(&mut self, element: &PlyElement, size: usize, most: u64, block: &mut Vec<u8>) -> Result<u64> {
        block.clear();
        if element.properties.iter().all(|property| property.length.is_none()) {
            block.resize(most as usize * size, 0);
            let filled = fill(&mut self.reader, block).map_err(|e| Error::read(&self.path, e))?;
            block.truncate(filled - filled % size);
            return Ok((filled / size) as u64);
        }
        for n in 0..most {
            for property in &element.properties {
                let at = block.len();
                let there = match property.length {
                    Some(_) => self.skip_property(property)?,
                    None => {
                        block.resize(at + property.scalar.size(), 0);
                        self.bytes(&mut block[at..])?
                    }
                };
                if !there {
                    block.truncate(n as usize * size);
                    return Ok(n);
                }
            }
        }
        Ok(most)
    }
}
