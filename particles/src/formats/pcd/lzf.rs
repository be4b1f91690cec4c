//! LZF, the compression of PCD: runs of plain bytes, and copies of bytes before (the format of liblzf,
//! oldhome.schmorp.de/marc/liblzf.html). The crate lzf 1.0 is deprecated by its author.

use halfline_ground::error::Result;
use halfline_ground::memory::reserve;

/// Decompresses `packed` to exactly `size` bytes; `None` where it is damaged. The list grows with the bytes that exist.
///
/// # Errors
/// [`Error::Limits`](halfline_ground::Error::Limits).
pub(super) fn unpack(mut packed: &[u8], size: u64) -> Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    while let Some((control, rest)) = packed.split_first() {
        packed = rest;
        let control = usize::from(*control);
        if control < 32 {
            // A run of plain bytes.
            let Some((plain, rest)) = packed.split_at_checked(control + 1) else { return Ok(None) };
            packed = rest;
            reserve(&mut bytes, plain.len())?;
            bytes.extend_from_slice(plain);
        } else {
            let Some((length, rest)) = copied(control >> 5, packed) else { return Ok(None) };
            let Some((low, rest)) = rest.split_first() else { return Ok(None) };
            packed = rest;
            let behind = ((control & 31) << 8 | usize::from(*low)) + 1;
            let Some(from) = bytes.len().checked_sub(behind) else { return Ok(None) };
            reserve(&mut bytes, length)?;
            // A copy may contain bytes that it writes itself.
            for k in 0..length {
                bytes.push(bytes[from + k]);
            }
        }
        if bytes.len() as u64 > size {
            return Ok(None);
        }
    }
    Ok((bytes.len() as u64 == size).then_some(bytes))
}

/// The length of a copy and the bytes after it.
fn copied(short: usize, packed: &[u8]) -> Option<(usize, &[u8])> {
    match short {
        7 => packed.split_first().map(|(more, rest)| (9 + usize::from(*more), rest)),
        _ => Some((short + 2, packed)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_copies_are_unpacked() {
        let whole = |packed: &[u8], size| unpack(packed, size).expect("room");
        // Three plain bytes, a copy of 3 from 3 before, and a long copy of 9 + 2 from the last byte.
        let packed = [2, b'a', b'b', b'c', 1 << 5, 2, 7 << 5, 2, 0];
        assert_eq!(whole(&packed, 17).expect("bytes"), b"abcabcccccccccccc");
        for size in [0, 16, 18] {
            assert_eq!(whole(&packed, size), None, "another size");
        }
        for damaged in [&[2, b'a'][..], &[1 << 5, 0], &[0, b'a', 1 << 5], &[0, b'a', 7 << 5], &[0, b'a', 1 << 5, 1]] {
            assert_eq!(whole(damaged, 4), None, "{damaged:?}");
        }
    }
}
