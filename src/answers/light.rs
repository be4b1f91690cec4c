//! Light of the pixels of a frame: its buffers and the answers of devices.

use super::open_sky::{SkyAtHit, SkyCounts};
use glam::DVec3;

/// The certainty of a pixel with a ray that the judge decided.
pub(crate) const SETTLED: u8 = 1;
/// The certainty of a pixel with a ray that is not proved.
pub(crate) const NOT_CERTIFIED: u8 = 255;

/// The buffers of lights and sky in row order; those that were not requested are empty.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct LightBuffers {
    /// Linear RGB, three numbers per pixel.
    pub(crate) color: Vec<f32>,
    /// Share of each light that is hidden, one number per light and pixel.
    pub(crate) shadow: Vec<f32>,
    /// Share of the sky that is open.
    pub(crate) occlusion: Vec<f32>,
    /// Normals and rays toward the sky, as [`SkyAtHit`] writes them.
    pub(crate) sky: [Vec<i16>; 2],
    /// Depths of the hits as [`PictureRays::depths`] writes them.
    ///
    /// [`PictureRays::depths`]: crate::view::picture_rays::PictureRays::depths
    pub(crate) depth: Vec<f64>,
    /// Pixels that are less than certain in f64, in their order, and their certainty.
    pub(crate) unsure: Vec<(u32, u8)>,
}

/// A device's answers to the rays from the hits of a window's pixels. Every pixel has the same number of words, and a
/// bit for each ray, which is set where nothing hides the end of the ray. One more bit is set where the device did not
/// decide all rays of the pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Traced<'a> {
    pub(crate) words: &'a [u32],
    /// The numbers of rays of a pixel toward the sky and toward lights, in the order of their bits.
    pub(crate) rays: usize,
    pub(crate) lights: usize,
}

impl<'a> Traced<'a> {
    /// The number of words of a pixel with `rays` rays.
    pub(crate) fn words_of(rays: usize) -> usize {
        rays / 32 + 1
    }

    /// The number of words of each pixel.
    pub(crate) fn words_of_pixel(&self) -> usize {
        Self::words_of(self.rays + self.lights)
    }

    /// The words of one pixel; `None` if the device did not decide all its rays.
    pub(crate) fn of(&self, pixel: u32) -> Option<Self> {
        let count = self.words_of_pixel();
        let words = &self.words[pixel as usize * count..][..count];
        Some(Self { words, ..*self }).filter(|own| !own.is_open(self.rays + self.lights))
    }

    /// Whether nothing hides the end of a ray, of the pixel that the words are of.
    pub(crate) fn is_open(&self, ray: usize) -> bool {
        self.words[ray / 32] >> (ray % 32) & 1 == 1
    }
}

/// Light of one pixel. Buffers that were not requested do not take its numbers.
#[derive(Debug, Default)]
pub(crate) struct PixelLight<'a> {
    /// Linear RGB.
    pub(crate) color: DVec3,
    /// Share of each light that is hidden.
    pub(crate) shadow: &'a [f32],
    /// Share of the sky that is open.
    pub(crate) occlusion: f32,
    /// Rays toward the sky.
    pub(crate) sky: SkyAtHit,
    /// `None` where f64 is certain.
    pub(crate) certainty: Option<u8>,
}

/// A run of consecutive pixels of a [`LightBuffers`].
pub(crate) struct Chunk<'a> {
    pub(crate) first: usize,
    pub(crate) count: usize,
    pub(crate) color: &'a mut [f32],
    pub(crate) shadow: &'a mut [f32],
    pub(crate) occlusion: &'a mut [f32],
    pub(crate) sky: [&'a mut [i16]; 2],
    pub(crate) depth: &'a mut [f64],
}

impl Chunk<'_> {
    /// Writes the light of pixel `n` of the run into the buffers that were requested.
    pub(crate) fn write(&mut self, n: usize, light: &PixelLight<'_>) {
        let lights = light.shadow.len();
        if let Some(color) = self.color.get_mut(3 * n..3 * n + 3) {
            color.copy_from_slice(&light.color.as_vec3().to_array());
        }
        if let Some(shadow) = self.shadow.get_mut(n * lights..(n + 1) * lights) {
            shadow.copy_from_slice(light.shadow);
        }
        if let Some(occlusion) = self.occlusion.get_mut(n) {
            *occlusion = light.occlusion;
        }
        let [normals, sums] = self.sky_of(n);
        light.sky.write(normals, sums);
    }

    /// Writes the rays toward the sky of pixel `n` of the run from a lane; zeros for `None`.
    #[inline(always)]
    pub(crate) fn write_counts(&mut self, n: usize, counts: &SkyCounts, lane: Option<usize>) {
        let [normals, sums] = self.sky_of(n);
        for (out, counts) in [(normals, &counts.normal[..]), (sums, &counts.sums[..])] {
            out.iter_mut().zip(counts).for_each(|(out, counts)| *out = lane.map_or(0, |lane| counts[lane]));
        }
    }

    /// The numbers of pixel `n` of the run; empty if they were not requested.
    #[inline(always)]
    fn sky_of(&mut self, n: usize) -> [&mut [i16]; 2] {
        let count = self.count;
        self.sky.each_mut().map(|numbers| {
            let each = numbers.len() / count;
            &mut numbers[n * each..][..each]
        })
    }
}

impl LightBuffers {
    /// The buffers of a frame in which no pixel shows a sphere: the background, no shadow, an open sky without light.
    pub(crate) fn of_nothing(mut self, background: impl Fn(u32) -> [f32; 3]) -> Self {
        (0..).zip(self.color.chunks_exact_mut(3)).for_each(|(pixel, color)| color.copy_from_slice(&background(pixel)));
        self.shadow.fill(0.0);
        self.occlusion.fill(1.0);
        self.sky.iter_mut().for_each(|numbers| numbers.fill(0));
        self.depth.fill(f64::INFINITY);
        self
    }

    /// Splits the buffers of `pixels` pixels and `lights` lights after every `count` pixels.
    pub(crate) fn chunks(&mut self, pixels: usize, count: usize, lights: usize) -> impl Iterator<Item = Chunk<'_>> {
        let mut colors = self.color.chunks_mut(3 * count);
        let mut shadows = self.shadow.chunks_mut((lights * count).max(1));
        let mut shares = self.occlusion.chunks_mut(count);
        let mut depths = self.depth.chunks_mut(count);
        let mut skies = self.sky.each_mut().map(|numbers| {
            let each = numbers.len() / pixels.max(1);
            numbers.chunks_mut((each * count).max(1))
        });
        (0..pixels).step_by(count).map(move |first| Chunk {
            first,
            count: count.min(pixels - first),
            color: colors.next().unwrap_or_default(),
            shadow: shadows.next().unwrap_or_default(),
            occlusion: shares.next().unwrap_or_default(),
            sky: skies.each_mut().map(|chunks| chunks.next().unwrap_or_default()),
            depth: depths.next().unwrap_or_default(),
        })
    }
}
