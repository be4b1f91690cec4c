//! Files of rays.

use super::{Allowed, PER_BYTE, Pieces, Unpacked, allowed, check_error, unpacked};
use halfline::Watch;
use halfline_files::read::rays::{RayBlock, RayOptions, RayReader};
use std::io::{Cursor, Read};
use std::path::Path;

/// Reads all rays in blocks of two sizes, and in pieces.
pub(super) fn read(data: &[u8]) -> Allowed {
    let Some((choice, content)) = data.split_first() else { return allowed(0, 0) };
    let Some(Unpacked { length, whole }) = unpacked(content) else { return allowed(0, 0) };
    let skip_invalid = choice & 1 != 0;
    let of = |reader: Cursor<Vec<u8>>, most| rows(reader, skip_invalid, most, length);
    let at_once = of(Cursor::new(content.to_vec()), usize::MAX >> 1);
    let in_blocks = of(Cursor::new(content.to_vec()), 1 + usize::from(choice >> 1 & 7));
    assert!(at_once == in_blocks || !whole, "at once {at_once:?}, in blocks {in_blocks:?}");
    if choice & 0x80 != 0 {
        let in_pieces = rows(Pieces { content: content.to_vec(), at: 0 }, skip_invalid, 1 << 10, length);
        assert!(at_once == in_pieces || !whole, "at once {at_once:?}, in pieces {in_pieces:?}");
    }
    allowed(length, PER_BYTE)
}

/// The bits of all rays, the invalid rows, and the error that ended them.
type Outcome = (Vec<[u64; 7]>, Vec<u64>, Option<String>);

fn rows(reader: impl Read + Send + 'static, skip_invalid: bool, most: usize, length: usize) -> Outcome {
    let (mut rays, mut invalid, mut count) = (Vec::new(), Vec::new(), 0);
    let options = RayOptions { skip_invalid, watch: Watch::default() };
    let mut reader = match RayReader::from_reader(reader, Path::new("fuzzed"), &options) {
        Ok(reader) => reader,
        Err(error) => return (rays, invalid, Some(check_error(&error))),
    };
    loop {
        match reader.next_block(most) {
            Ok(Some(block)) => {
                assert!((1..=most).contains(&block.rows()));
                check(&block, skip_invalid);
                for (n, (origin, direction)) in block.origins.iter().zip(&block.directions).enumerate() {
                    let limit = block.limits.get(n).unwrap_or(&f64::INFINITY);
                    let mut numbers = origin.iter().chain(direction).chain([limit]);
                    rays.push([0; 7].map(|_| numbers.next().map_or(0, |x: &f64| x.to_bits())));
                }
                invalid.extend(block.invalid.iter().map(|place| count + u64::from(*place)));
                count += block.rows() as u64;
                // A row has at least a byte and the end of its line.
                assert!(2 * count <= length as u64 + 1, "{count} rows of {length} bytes");
            }
            Ok(None) => {
                assert!(reader.count().is_none_or(|announced| announced == count));
                return (rays, invalid, None);
            }
            // Rows before an invalid one are not kept.
            Err(error) => return (Vec::new(), Vec::new(), Some(check_error(&error))),
        }
    }
}

fn check(block: &RayBlock, skip_invalid: bool) {
    assert!(block.origins.iter().chain(&block.directions).flatten().all(|x| x.is_finite()));
    assert!(block.directions.iter().all(|direction| direction.iter().any(|x| *x != 0.0)));
    assert_eq!(block.origins.len(), block.directions.len());
    assert!(block.limits.is_empty() || block.limits.len() == block.directions.len());
    assert!(!block.limits.iter().any(|limit| limit.is_nan()));
    assert!(block.invalid.is_sorted_by(|a, b| a < b) && block.invalid.iter().all(|at| (*at as usize) < block.rows()));
    assert!(skip_invalid || block.invalid.is_empty());
    assert_eq!(block.fault.is_some(), !block.invalid.is_empty());
    block.fault.iter().for_each(|fault| drop(check_error(fault)));
}
