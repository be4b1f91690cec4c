//! What lights and the sky give to the pixels of a frame.

/// The certainty of a pixel of which the judge decided a ray.
pub(crate) const SETTLED: u8 = 1;
/// That of a pixel of which a ray is not proved.
pub(crate) const NOT_CERTIFIED: u8 = 255;

/// The buffers of lights and sky in row order; those that were not requested are empty.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Lit {
    /// Linear RGB, three numbers per pixel.
    pub(crate) color: Vec<f32>,
    /// Share of each light that is hidden, one number per light and pixel.
    pub(crate) shadow: Vec<f32>,
    /// Share of the sky that is open.
    pub(crate) occlusion: Vec<f32>,
    /// Pixels that are less than certain in f64, in their order, and their certainty.
    pub(crate) unsure: Vec<(u32, u8)>,
}

/// A run of consecutive pixels of a [`Lit`].
pub(crate) struct Chunk<'a> {
    pub(crate) first: usize,
    pub(crate) count: usize,
    pub(crate) color: &'a mut [f32],
    pub(crate) shadow: &'a mut [f32],
    pub(crate) occlusion: &'a mut [f32],
}

impl Chunk<'_> {
    /// Fills what is requested of a pixel that shows no sphere.
    pub(crate) fn miss(&mut self, n: usize, lights: usize, background: [f32; 3]) {
        if let Some(color) = self.color.get_mut(3 * n..3 * n + 3) {
            color.copy_from_slice(&background);
        }
        if let Some(shadow) = self.shadow.get_mut(n * lights..(n + 1) * lights) {
            shadow.fill(0.0);
        }
        if let Some(occlusion) = self.occlusion.get_mut(n) {
            *occlusion = 1.0;
        }
    }
}

impl Lit {
    /// The buffers where no pixel shows a sphere.
    pub(crate) fn of_nothing(mut self, background: [f32; 3]) -> Self {
        self.color.chunks_exact_mut(3).for_each(|color| color.copy_from_slice(&background));
        self.shadow.fill(0.0);
        self.occlusion.fill(1.0);
        self
    }

    /// Splits the buffers of `pixels` pixels and `lights` lights after every `count` pixels.
    pub(crate) fn chunks(&mut self, pixels: usize, count: usize, lights: usize) -> impl Iterator<Item = Chunk<'_>> {
        let mut colors = self.color.chunks_mut(3 * count);
        let mut shadows = self.shadow.chunks_mut((lights * count).max(1));
        let mut shares = self.occlusion.chunks_mut(count);
        (0..pixels).step_by(count).map(move |first| Chunk {
            first,
            count: count.min(pixels - first),
            color: colors.next().unwrap_or_default(),
            shadow: shadows.next().unwrap_or_default(),
            occlusion: shares.next().unwrap_or_default(),
        })
    }
}
