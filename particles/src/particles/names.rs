//! Names numbered in the order of their first occurrence, for columns of text.

use halfline_ground::error::Result;
use halfline_ground::memory::Ledger;
use std::collections::HashMap;

/// Names numbered in the order of first occurrence.
#[derive(Debug, Clone, Default)]
pub(crate) struct Names {
    pub(super) list: Vec<Vec<u8>>,
    numbers: HashMap<Vec<u8>, u32>,
    last: u32,
    ledger: Ledger,
}

/// Bytes per name, besides its letters, in a list and a map while they grow, and in a list of labels.
const NAME: usize = 160;

/// Whether two short texts are the same. Letters that were just written are compared one by one: a call that loads them together waits
/// for their stores, a quarter of the time of a BinaryCIF.
#[inline]
pub(crate) fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a == b)
}

impl Names {
    /// The names as text, as labels of a column.
    pub(crate) fn labels(&self) -> Vec<String> {
        self.list.iter().map(|name| String::from_utf8_lossy(name).into_owned()).collect()
    }

    /// Turns numbers of other names into the numbers of the same names here.
    ///
    /// # Errors
    /// As [`Names::number`].
    pub(super) fn renumber(&mut self, others: &Self, values: &mut [f64]) -> Result<()> {
        let numbers: Vec<u32> = others.list.iter().map(|name| self.number(name)).collect::<Result<_>>()?;
        values.iter_mut().for_each(|value| *value = f64::from(numbers[*value as usize]));
        Ok(())
    }

    /// The number of a name; a new name gets the next number.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub(crate) fn number(&mut self, name: &[u8]) -> Result<u32> {
        // Atoms of a chain follow each other.
        if !self.list.get(self.last as usize).is_some_and(|last| is_same(last, name)) {
            self.last = match self.numbers.get(name) {
                Some(number) => *number,
                None => {
                    self.ledger.add(NAME + 3 * name.len())?;
                    let number = self.list.len() as u32;
                    self.list.push(name.to_vec());
                    self.numbers.insert(name.to_vec(), number);
                    number
                }
            };
        }
        Ok(self.last)
    }
}
