//! The records of the tree: eight boxes of a node, eight spheres of a block.

/// Children of a node, and spheres of a block: the lanes of a vector.
pub(crate) const WIDE: usize = crate::number::vector::LANES;

/// Eight boxes: least x, y, z, then greatest x, y, z. A missing child has its least above its greatest.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    pub(crate) planes: [[f32; WIDE]; 6],
}

/// Eight spheres in the tree's unit, rounded to f32, the radii upward. A missing sphere has the radius -[`ABSENT`], so that
/// every ray certainly misses it.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block {
    pub(crate) center: [[f32; WIDE]; 3],
    pub(crate) radius: [f32; WIDE],
}

impl Block {
    /// Without spheres.
    pub(super) const NONE: Self = Self { center: [[0.0; WIDE]; 3], radius: [-ABSENT; WIDE] };
}

impl Node {
    /// Of at most eight boxes.
    pub(super) fn of(boxes: impl IntoIterator<Item = [[f32; 3]; 2]>) -> Self {
        let mut node = Self { planes: std::array::from_fn(|n| [if n < 3 { ABSENT } else { -ABSENT }; WIDE]) };
        for (lane, bounds) in boxes.into_iter().enumerate() {
            for (n, plane) in node.planes.iter_mut().enumerate() {
                plane[lane] = bounds[n / 3][n % 3];
            }
        }
        node
    }
}

/// Beyond every coordinate, and its square is finite.
pub(crate) const ABSENT: f32 = (1u64 << 60) as f32;
