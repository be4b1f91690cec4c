//! Estimates what parsing a text as TOML may allocate, before it is parsed: the parser itself has no limit.

/// An upper bound of the bytes that the parser (toml 1.2) holds while it parses `text`, including its tree: a sum over
/// the characters that begin a token, a value, a key or a table. The weights are a quarter above the maximum of 36
/// texts, each consisting of one construct, at 16 lengths from 4 kB to 500 kB; for a list of spheres the sum is 1.6
/// times the actual memory. Fuzzing compares it with a counting allocator.
pub(super) fn most_bytes(text: &str) -> u64 {
    let (mut sum, mut key, mut braces, mut quoted, mut last) =
        (16 * text.len() as u64, true, 0u64, false, CostClass::Mark);
    for byte in text.bytes() {
        let class = CostClass::of(byte);
        if class == CostClass::Mark || class != last {
            sum += 64;
        }
        last = class;
        match byte {
            b'\n' => {
                sum += 128;
                (key, quoted) = (true, false);
            }
            b'=' => {
                sum += 384;
                key = false;
            }
            b',' => {
                sum += 288;
                key |= braces > 0;
            }
            b'[' => sum += 288,
            b'{' => {
                sum += 512;
                braces += 1;
                key = true;
            }
            b'}' => braces = braces.saturating_sub(1),
            b'"' | b'\'' => quoted = true,
            // A dot in a key creates a table; after a quote, keys and numbers cannot be distinguished.
            b'.' if key || quoted => sum += 1152,
            _ => {}
        }
    }
    sum
}

/// The character classes of tokens: each mark is a token, and so is a run of blanks or of letters.
#[derive(Clone, Copy, PartialEq, Eq)]
enum CostClass {
    Blank,
    Word,
    Mark,
}

impl CostClass {
    fn of(byte: u8) -> Self {
        match byte {
            b' ' | b'\t' => Self::Blank,
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'-' | b'+' | b'#' | b':' | 128.. => Self::Word,
            _ => Self::Mark,
        }
    }
}
