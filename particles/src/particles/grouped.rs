//! Items by the number of their group.

/// The items of each group, in the order in which they were given.
#[derive(Default)]
pub(super) struct Grouped {
    /// For each group the place of its first item, and the end.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Grouped {
    /// Groups items, each with the number of its group, of so many groups.
    pub(super) fn new(groups: usize, items: impl Iterator<Item = (usize, u32)> + Clone) -> Self {
        let mut starts = vec![0; groups + 1];
        items.clone().for_each(|(group, _)| starts[group + 1] += 1);
        (0..groups).for_each(|group| starts[group + 1] += starts[group]);
        let (mut next, mut sorted) = (starts.clone(), vec![0; starts[groups] as usize]);
        for (group, item) in items {
            sorted[next[group] as usize] = item;
            next[group] += 1;
        }
        Self { starts, items: sorted }
    }

    /// The items of a group.
    pub(super) fn of(&self, group: usize) -> &[u32] {
        &self.items[self.starts[group] as usize..self.starts[group + 1] as usize]
    }
}
