//! A metadata block behind the last number, for formats whose headers have no room for metadata. A reader that stops
//! after the announced count of numbers does not see it.

const BEGIN: &str = "\nhalfline ";
const END: &str = "\n";

/// The longest block, bytes; a longer claim in a damaged file is rejected.
const MAX_BLOCK_BYTES: usize = 1 << 16;

/// The block that holds one line of JSON.
pub fn of(json: &str) -> String {
    format!("{BEGIN}{json}{END}")
}

/// The JSON of a block; `None` if the bytes are not such a block.
pub fn json(block: &[u8]) -> Option<&[u8]> {
    let json = block.strip_prefix(BEGIN.as_bytes())?.strip_suffix(END.as_bytes())?;
    (json.len() <= MAX_BLOCK_BYTES && json.starts_with(b"{") && json.ends_with(b"}")).then_some(json)
}
