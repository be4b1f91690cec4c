//! Signs of CIF, in text and binary.

use crate::signs::content_lines;

/// A map of MessagePack whose first key is one of BinaryCIF.
pub(super) fn is_binary_cif(bytes: &[u8]) -> bool {
    let entries = match bytes {
        [0x80..=0x8f, rest @ ..] | [0xde, _, _, rest @ ..] | [0xdf, _, _, _, _, rest @ ..] => rest,
        _ => return false,
    };
    [&b"\xa7version"[..], b"\xa7encoder", b"\xaadataBlocks"].iter().any(|key| entries.starts_with(key))
}

/// A word that begins a file of CIF, and a word of CIF behind it, if there is any.
pub(super) fn is_mmcif(lines: &[&str]) -> bool {
    let mut words = content_lines(lines).flat_map(str::split_whitespace);
    let Some(word) = words.next().map(str::to_ascii_lowercase) else { return false };
    // Libraries of monomers begin with what is global.
    let is_block = word == "global_" || word.len() > 5 && word.starts_with("data_") && !word.contains('=');
    let is_tag = |word: &str| word.starts_with('_');
    let next = words.next().map(str::to_ascii_lowercase);
    let begins = ["loop_", "data_", "save_", "global_"];
    match next.as_deref() {
        None => is_block || word == "loop_" || word.starts_with("_atom_site."),
        Some(next) if is_block => is_tag(next) || begins.iter().any(|word| next.starts_with(word)),
        Some(next) if word == "loop_" => is_tag(next),
        // A value follows.
        Some(value) => {
            let ends = |word: &str| is_tag(word) || begins.contains(&word) || value.starts_with(['\'', '"', ';']);
            word.starts_with("_atom_site.") && words.next().is_none_or(ends)
        }
    }
}
