//! The spheres that a stream keeps, with their numbers.

use super::witness::Witness;
use crate::scene::Spheres;
use crate::scene::instances::NumberedSpheres;
use halfline_ground::check::keep;
use halfline_ground::error::Result;
use halfline_ground::memory::{check, reserve};

impl NumberedSpheres {
    /// Adds the spheres of a block with these indices, whose numbers `number` gives.
    pub(super) fn add(&mut self, block: &Spheres, number: &impl Fn(usize) -> u64, indices: &[u32]) -> Result<()> {
        reserve(&mut self.numbers, indices.len())?;
        self.spheres.grow(indices.len(), block.colors.is_some())?;
        self.numbers.extend(indices.iter().map(|n| number(*n as usize)));
        self.spheres.add_chosen(block, indices);
        Ok(())
    }

    /// Keeps the spheres whose flag is set.
    pub(super) fn keep(&mut self, flags: &[bool]) {
        keep(&mut self.numbers, flags);
        self.spheres.keep(flags);
    }

    /// The same with a few more spheres, in the order of their numbers.
    pub(super) fn with(mut self, more: impl Iterator<Item = Witness>) -> Result<Self> {
        self.sort()?;
        let known = self.numbers.len();
        for Witness { number, center, radius, color, opacity } in more {
            if self.numbers[..known].binary_search(&number).is_err() && !self.numbers[known..].contains(&number) {
                self.spheres.add(center, radius, color)?;
                self.spheres.set_opacity_from(self.spheres.len() - 1, opacity);
                self.numbers.push(number);
            }
        }
        self.sort()?;
        Ok(self)
    }

    /// The same with all of another list, in the order of their numbers, each once.
    pub(super) fn united(mut self, other: &Self) -> Result<Self> {
        self.sort()?;
        let is_new = |n: &u32| self.numbers.binary_search(&other.numbers[*n as usize]).is_err();
        let new: Vec<u32> = (0..other.numbers.len() as u32).filter(is_new).collect();
        self.add(&other.spheres, &|n| other.numbers[n], &new)?;
        self.sort()?;
        Ok(self)
    }

    /// Sorts the spheres by number.
    pub(super) fn sort(&mut self) -> Result<()> {
        if self.numbers.is_sorted() {
            return Ok(());
        }
        let count = self.numbers.len() as u64;
        check(count * 40, || format!("the order of {count} spheres"))?;
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.sort_by_key(|n| self.numbers[*n as usize]);
        self.numbers = order.iter().map(|n| self.numbers[*n as usize]).collect();
        self.spheres.choose(&order);
        Ok(())
    }
}
