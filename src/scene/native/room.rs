//! What parsing a text as TOML may allocate, told before it is parsed: the parser itself stops at nothing.

/// Bytes that the parser (toml 1.2) holds at most while it parses `text`, its tree included: a sum over the characters
/// that begin a token, a value, a key or a table. The weights are a quarter above the most that any of 36 texts took, each
/// of which is all of one kind, at 16 lengths from 4 kB to 500 kB; of a list of spheres the sum is 1.6 times what is held.
/// Fuzzing holds it against a counting allocator.
pub(super) fn most_held(text: &str) -> u64 {
    let (mut sum, mut key, mut braces, mut quoted, mut last) = (16 * text.len() as u64, true, 0u64, false, Class::Mark);
    for byte in text.bytes() {
        let class = Class::of(byte);
        if class == Class::Mark || class != last {
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
            // A dot in a key makes a table; behind a quote there is no telling keys from numbers.
            b'.' if key || quoted => sum += 1152,
            _ => {}
        }
    }
    sum
}

/// What a token is made of: each mark is one, and so is a run of blanks or of letters.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Class {
    Blank,
    Word,
    Mark,
}

impl Class {
    fn of(byte: u8) -> Self {
        match byte {
            b' ' | b'\t' => Self::Blank,
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'-' | b'+' | b'#' | b':' | 128.. => Self::Word,
            _ => Self::Mark,
        }
    }
}
