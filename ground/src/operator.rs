//! Placement of a copy: a rotation and a translation.

/// A rotation and a translation: three rows of a matrix, each followed by its translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Operator(pub [[f64; 4]; 3]);

impl Operator {
    /// The image of a point.
    #[must_use]
    pub fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        self.0.map(|[a, b, c, d]| a * p[0] + b * p[1] + c * p[2] + d)
    }

    /// The product: first `other`, then this.
    #[must_use]
    pub fn after(&self, other: &Self) -> Self {
        Self(self.0.map(|row| {
            let column = |k: usize| (0..3).map(|j| row[j] * other.0[j][k]).sum::<f64>();
            [column(0), column(1), column(2), column(3) + row[3]]
        }))
    }
}
