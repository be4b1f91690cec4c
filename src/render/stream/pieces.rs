//! BLAKE3 of bytes that arrive in pieces, in any order, more than once and from many machines: the hash of all is the hash of
//! the bytes in one piece. BLAKE3 is a binary tree over chunks of 1024 bytes (specification, section 2.1), so whole subtrees
//! are kept as their chaining values, and the bytes of chunks that are known in part as they are.

use blake3::hazmat::{ChainingValue, HasherExt, Mode, left_subtree_len, max_subtree_len};
use blake3::hazmat::{merge_subtrees_non_root, merge_subtrees_root};
use blake3::{CHUNK_LEN, Hash, Hasher};
use halfline_ground::parallel;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const CHUNK: u64 = CHUNK_LEN as u64;

/// The known bytes of a list. Equal sets of known bytes give equal values, however they were added.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Record", into = "Record")]
pub(super) struct Pieces {
    /// The largest subtrees whose bytes are all known, by their first chunk. None begins with chunk 0: which of its
    /// subtrees the root joins depends on the length of the whole.
    trees: BTreeMap<u64, Tree>,
    /// Known bytes by their place: chunk 0, and chunks that are known only in part. Two runs of a chunk do not touch.
    runs: BTreeMap<u64, Vec<u8>>,
}

/// A whole subtree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Tree {
    /// Its number of chunks, a power of two.
    chunks: u64,
    value: ChainingValue,
}

/// [`Pieces`] as lists.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Record {
    trees: Vec<(u64, Tree)>,
    runs: Vec<(u64, Vec<u8>)>,
}

/// Two pieces give a byte different values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Differing;

impl Pieces {
    /// Whether nothing is known.
    pub(super) fn is_empty(&self) -> bool {
        self.trees.is_empty() && self.runs.is_empty()
    }

    /// Adds the bytes from place `at` on.
    pub(super) fn add(&mut self, mut at: u64, mut bytes: &[u8]) -> Result<(), Differing> {
        while !bytes.is_empty() {
            let (size, is_run) = match at % CHUNK {
                0 if at > 0 && bytes.len() >= CHUNK_LEN => {
                    let room = max_subtree_len(at).unwrap_or(CHUNK);
                    (room.min(1 << bytes.len().ilog2()), false)
                }
                within => ((CHUNK - within).min(bytes.len() as u64), true),
            };
            let (piece, rest) = bytes.split_at(size as usize);
            if is_run {
                self.add_run(at, piece)?;
            } else {
                self.add_tree(at / CHUNK, Tree { chunks: size / CHUNK, value: chaining_value(at, piece) })?;
            }
            (at, bytes) = (at + size, rest);
        }
        Ok(())
    }

    /// Adds what another list of pieces knows.
    pub(super) fn join(&mut self, other: &Self) -> Result<(), Differing> {
        other.trees.iter().try_for_each(|(first, tree)| self.add_tree(*first, *tree))?;
        other.runs.iter().try_for_each(|(at, bytes)| self.add_run(*at, bytes))
    }

    /// The known intervals of bytes, in order; no two touch.
    pub(super) fn known(&self) -> Vec<[u64; 2]> {
        let trees = self.trees.iter().map(|(first, tree)| [first * CHUNK, (first + tree.chunks) * CHUNK]);
        let mut all: Vec<_> = trees.chain(self.runs.iter().map(|(at, bytes)| [*at, at + bytes.len() as u64])).collect();
        all.sort_unstable();
        all.dedup_by(|next, last| {
            let touches = last[1] == next[0];
            if touches {
                last[1] = next[1];
            }
            touches
        });
        all
    }

    /// BLAKE3 of the whole list, which ends where the pieces do; `None` while bytes before that are missing.
    pub(super) fn whole(&self) -> Option<Hash> {
        match self.known()[..] {
            [] => Some(blake3::hash(&[])),
            [[0, length]] if length <= CHUNK => self.runs.get(&0).map(|bytes| blake3::hash(bytes)),
            [[0, length]] => {
                let left = left_subtree_len(length);
                let (left, right) = (self.value(0, left)?, self.value(left, length - left)?);
                Some(merge_subtrees_root(&left, &right, Mode::Hash))
            }
            _ => None,
        }
    }

    /// A hash of what is known, for lists with gaps.
    pub(super) fn of_parts(&self) -> Hash {
        let mut hasher = Hasher::new();
        hasher.update(b"parts");
        for (first, tree) in &self.trees {
            hasher.update(&first.to_le_bytes()).update(&tree.chunks.to_le_bytes()).update(&tree.value);
        }
        for (at, bytes) in &self.runs {
            hasher.update(&at.to_le_bytes()).update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
        }
        hasher.finalize()
    }

    /// The chaining value of the subtree of these bytes.
    fn value(&self, at: u64, length: u64) -> Option<ChainingValue> {
        match self.trees.get(&(at / CHUNK)) {
            Some(tree) if tree.chunks * CHUNK == length => Some(tree.value),
            _ if length <= CHUNK => {
                self.runs.get(&at).filter(|bytes| bytes.len() as u64 == length).map(|bytes| chaining_value(at, bytes))
            }
            _ => {
                let left = left_subtree_len(length);
                Some(merge_subtrees_non_root(
                    &self.value(at, left)?,
                    &self.value(at + left, length - left)?,
                    Mode::Hash,
                ))
            }
        }
    }

    /// The tree that has this chunk.
    fn tree_of(&self, chunk: u64) -> Option<(u64, Tree)> {
        let (first, tree) = self.trees.range(..=chunk).next_back()?;
        (first + tree.chunks > chunk).then_some((*first, *tree))
    }

    fn add_tree(&mut self, mut first: u64, mut tree: Tree) -> Result<(), Differing> {
        if let Some((start, known)) = self.tree_of(first)
            && known.chunks >= tree.chunks
        {
            let differs = (start, known.chunks) == (first, tree.chunks) && known != tree;
            return if differs { Err(Differing) } else { Ok(()) };
        }
        self.trees.retain(|known, _| !(first..first + tree.chunks).contains(known));
        self.runs.retain(|at, _| !(first..first + tree.chunks).contains(&(at / CHUNK)));
        // Siblings become their parent.
        loop {
            let sibling = first ^ tree.chunks;
            let Some(other) = self.trees.get(&sibling).copied().filter(|other| other.chunks == tree.chunks) else {
                break;
            };
            self.trees.remove(&sibling);
            let (left, right) = if sibling < first { (other, tree) } else { (tree, other) };
            let value = merge_subtrees_non_root(&left.value, &right.value, Mode::Hash);
            (first, tree) = (first.min(sibling), Tree { chunks: 2 * tree.chunks, value });
        }
        self.trees.insert(first, tree);
        Ok(())
    }

    /// Adds bytes of one chunk.
    fn add_run(&mut self, at: u64, bytes: &[u8]) -> Result<(), Differing> {
        let chunk = at / CHUNK;
        if self.tree_of(chunk).is_some() {
            return Ok(());
        }
        let start = chunk * CHUNK;
        let mut known = [None; CHUNK_LEN];
        let places: Vec<u64> = self.runs.range(start..start + CHUNK).map(|(at, _)| *at).collect();
        let before = places.iter().filter_map(|at| self.runs.remove(at).map(|bytes| (*at, bytes)));
        let mut differs = false;
        for (at, bytes) in before.collect::<Vec<_>>().into_iter().chain([(at, bytes.to_vec())]) {
            for (slot, byte) in known[(at - start) as usize..].iter_mut().zip(bytes) {
                differs |= slot.replace(byte).is_some_and(|known| known != byte);
            }
        }
        if differs {
            return Err(Differing);
        }
        if chunk > 0 && known.iter().all(Option::is_some) {
            let whole: Vec<u8> = known.into_iter().flatten().collect();
            return self.add_tree(chunk, Tree { chunks: 1, value: chaining_value(start, &whole) });
        }
        let mut run: Option<u64> = None;
        for (place, byte) in (start..).zip(known) {
            match byte {
                Some(byte) => self.runs.entry(*run.get_or_insert(place)).or_default().push(byte),
                None => run = None,
            }
        }
        Ok(())
    }
}

/// The chaining value of a subtree, not the root, whose bytes begin at `at`.
fn chaining_value(at: u64, bytes: &[u8]) -> ChainingValue {
    parallel::hash(Hasher::new().set_input_offset(at), bytes).finalize_non_root()
}

impl From<Pieces> for Record {
    fn from(pieces: Pieces) -> Self {
        Self { trees: pieces.trees.into_iter().collect(), runs: pieces.runs.into_iter().collect() }
    }
}

impl TryFrom<Record> for Pieces {
    type Error = String;

    /// Adds all again, so that damaged records are found or become pieces that keep the rules of this file.
    fn try_from(record: Record) -> Result<Self, String> {
        let mut pieces = Self::default();
        for (first, tree) in record.trees {
            let is_aligned = tree.chunks.is_power_of_two() && first > 0 && first % tree.chunks == 0;
            let is_bounded = first < 1 << 50 && tree.chunks < 1 << 50;
            if !is_aligned || !is_bounded {
                return Err(format!("{} chunks from {first} are no subtree", tree.chunks));
            }
            pieces.add_tree(first, tree).map_err(|Differing| "two subtrees differ")?;
        }
        for (at, bytes) in record.runs {
            if at >= 1 << 60 || at % CHUNK + bytes.len() as u64 > CHUNK {
                return Err(format!("{} bytes from {at} are not of one chunk", bytes.len()));
            }
            pieces.add_run(at, &bytes).map_err(|Differing| "two runs differ")?;
        }
        Ok(pieces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes that differ from place to place.
    fn bytes(length: usize) -> Vec<u8> {
        (0..length as u32).map(|n| (n.wrapping_mul(2654435761) >> 13) as u8).collect()
    }

    fn cut(all: &[u8], places: &[usize]) -> Vec<(usize, Vec<u8>)> {
        let ends = places.iter().copied().chain([all.len()]);
        [0].iter().chain(places).zip(ends).map(|(start, end)| (*start, all[*start..end].to_vec())).collect()
    }

    #[test]
    fn pieces_in_any_order_have_the_hash_of_the_whole() {
        for length in [0, 1, 1000, 1023, 1024, 1025, 2048, 2049, 3072, 5000, 8192, 65_536, 100_001] {
            let all = bytes(length);
            for step in [7, 24, 1024, 1500, 4096, 30_000, 200_000] {
                if length / step > 3000 {
                    continue;
                }
                let places: Vec<usize> = (step..length).step_by(step).collect();
                let mut pieces = cut(&all, &places);
                let count = pieces.len();
                let mut joined = Pieces::default();
                for turn in 0..3 {
                    pieces.rotate_left(turn * count / 3);
                    pieces.reverse();
                    let mut one = Pieces::default();
                    for (at, piece) in &pieces {
                        one.add(*at as u64, piece).expect("equal bytes");
                    }
                    assert_eq!(one.whole(), Some(blake3::hash(&all)), "{length} bytes, steps of {step}");
                    joined.join(&one).expect("equal bytes");
                    assert_eq!(joined, one, "what is known is one thing");
                }
                let text = serde_json::to_string(&joined).expect("JSON");
                assert_eq!(serde_json::from_str::<Pieces>(&text).expect("pieces"), joined);
            }
        }
    }

    #[test]
    fn overlaps_add_nothing_and_gaps_are_known() {
        let all = bytes(50_000);
        let part = |range: std::ops::Range<usize>| {
            let mut part = Pieces::default();
            part.add(range.start as u64, &all[range]).expect("equal bytes");
            part
        };
        let parts = [part(0..17_000), part(9_000..30_001), part(30_001..50_000), part(12_345..12_360)];
        let of = |order: &[usize]| {
            let mut joined = Pieces::default();
            order.iter().for_each(|n| joined.join(&parts[*n]).expect("equal bytes"));
            joined
        };
        assert_eq!(of(&[0, 1, 2]), of(&[3, 2, 1, 0, 2, 3]));
        assert_eq!(of(&[1, 0, 2]).whole(), Some(blake3::hash(&all)));
        let gap = of(&[0, 2]);
        assert_eq!((gap.whole(), gap.known()), (None, vec![[0, 17_000], [30_001, 50_000]]));
        assert_ne!(gap.of_parts(), of(&[0, 1]).of_parts());
        assert_eq!(gap.of_parts(), of(&[2, 0]).of_parts());
    }

    #[test]
    fn different_bytes_at_one_place_are_found() {
        let all = bytes(10_000);
        for place in [5, 1500, 9_999] {
            let mut other = all.clone();
            other[place] ^= 1;
            let [mut one, mut two] = [Pieces::default(), Pieces::default()];
            one.add(0, &all).expect("new bytes");
            two.add(0, &other).expect("new bytes");
            assert_eq!(one.join(&two), Err(Differing), "{place}");
        }
        let damaged = r#"{"trees":[[3,{"chunks":2,"value":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}]],"runs":[]}"#;
        serde_json::from_str::<Pieces>(damaged).expect_err("not aligned");
        serde_json::from_str::<Pieces>(
            r#"{"trees":[],"runs":[[1000,[1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,21,22,23,24,25]]]}"#,
        )
        .expect_err("two chunks");
    }
}
