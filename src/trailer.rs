//! The block behind the last number of formats that have no room for words: a reader that takes as many numbers as the
//! header announces does not see it.

const BEGIN: &str = "\nhalfline ";
const END: &str = "\n";

/// No block holds more; what a damaged file claims is not believed.
const LONGEST: usize = 1 << 16;

/// The block of one line of JSON.
pub(crate) fn of(json: &str) -> String {
    format!("{BEGIN}{json}{END}")
}

/// The JSON of a block; `None` for bytes that are no such block.
pub(crate) fn json(block: &[u8]) -> Option<&[u8]> {
    let json = block.strip_prefix(BEGIN.as_bytes())?.strip_suffix(END.as_bytes())?;
    (json.len() <= LONGEST && json.starts_with(b"{") && json.ends_with(b"}")).then_some(json)
}
