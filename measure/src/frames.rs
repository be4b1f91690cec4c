//! The buffers of two files that correspond.

use super::Array;
use halfline::error::{Error, Result};
use halfline::quote::setting::AOV;
use halfline::quote::{list, quote};
use halfline_files::write::buffers::FrameFile;

/// Corresponding buffers of two files.
#[derive(Debug, Clone, PartialEq)]
pub struct BufferPair<'a> {
    /// Their name, where either file gives one.
    pub name: Option<&'a str>,
    /// The first file's.
    pub a: &'a Array,
    /// The second file's.
    pub b: &'a Array,
}

/// The buffers of two files, matched.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchedBuffers<'a> {
    /// The buffers that both have.
    pub common: Vec<BufferPair<'a>>,
    /// Buffers that only one of them has: the buffer's name, and the file's.
    pub missing: Vec<(&'a str, &'a str)>,
}

impl<'a> MatchedBuffers<'a> {
    /// Matches the buffers of two files: buffers of the same name, or the buffers in `requested`. If each file has a single
    /// buffer, they are matched whatever their names.
    ///
    /// # Errors
    /// [`Error::Settings`] for a name that a file does not have, and for an unnamed buffer beside several.
    pub fn of(a: &'a FrameFile, b: &'a FrameFile, requested: &'a [String]) -> Result<Self> {
        if !requested.is_empty() {
            let pair = |name: &'a String| Ok(BufferPair { name: Some(name), a: buffer(a, name)?, b: buffer(b, name)? });
            return Ok(Self { common: requested.iter().map(pair).collect::<Result<_>>()?, missing: Vec::new() });
        }
        if let ([one], [other]) = (&a.buffers[..], &b.buffers[..]) {
            let name = one.name.as_deref().or(other.name.as_deref());
            return Ok(Self { common: vec![BufferPair { name, a: &one.array, b: &other.array }], missing: Vec::new() });
        }
        for (nameless, other) in [(a, b), (b, a)] {
            if nameless.buffers.iter().any(|buffer| buffer.name.is_none()) {
                let problem =
                    format!("{} has an unnamed buffer, which may be any buffer of {}", nameless.name, other.name);
                return Err(Error::settings(problem, format!("choose with {AOV}: {}", names(other))));
            }
        }
        let (mut common, mut missing) = (Vec::new(), Vec::new());
        for buffer in &a.buffers {
            let name = buffer.name.as_deref().unwrap_or_default();
            match b.buffers.iter().find(|other| other.name == buffer.name) {
                Some(other) => common.push(BufferPair { name: Some(name), a: &buffer.array, b: &other.array }),
                None => missing.push((name, &a.name[..])),
            }
        }
        let only_b = b.buffers.iter().filter(|buffer| a.buffers.iter().all(|other| other.name != buffer.name));
        missing.extend(only_b.map(|buffer| (buffer.name.as_deref().unwrap_or_default(), &b.name[..])));
        Ok(Self { common, missing })
    }
}

/// The buffer of this name.
fn buffer<'a>(file: &'a FrameFile, name: &str) -> Result<&'a Array> {
    let found = match &file.buffers[..] {
        // A file with one unnamed buffer matches any name.
        [only] if only.name.is_none() => Some(only),
        all => all.iter().find(|buffer| buffer.name.as_deref() == Some(name)),
    };
    found.map(|buffer| &buffer.array).ok_or_else(|| {
        Error::settings(format!("{} has no buffer {}", file.name, quote(name)), format!("the file has {}", names(file)))
    })
}

/// The names of its buffers, for messages.
fn names(file: &FrameFile) -> String {
    list(file.buffers.iter().filter_map(|buffer| buffer.name.as_deref()))
}

#[cfg(test)]
mod tests;
