//! The pixels of a PNG, filtered and compressed in strips of rows by all cores. Strips depend on the size of the image
//! alone, so the bytes are the same on any number of threads.

use super::joined;
use halfline::parallel;
use std::io::{self, Write};

/// Bytes of samples in a strip, but at least one row. A strip takes 60 bytes in the file besides its pixels.
const STRIP: usize = 1 << 17;

/// Bytes of samples that are collected before they are compressed.
const TOGETHER: usize = 4 << 20;

/// The filter type of Paeth's predictor: smaller than the adaptive choice for shaded spheres, and a third faster.
const PAETH: u8 = 4;

/// The most bytes needed for rows of `row` bytes: samples, filtered, and compressed, which may be longer.
pub(super) fn memory(row: u64) -> u64 {
    4 * row.max(TOGETHER as u64)
}

/// Collects the samples of an image, row by row, and passes on a zlib stream in parts.
pub(super) struct Strips<W> {
    out: W,
    /// Bytes of a row.
    row: usize,
    /// Bytes of a pixel.
    pixel: usize,
    /// The row before the next samples; zeros before the first.
    above: Vec<u8>,
    /// Samples that are not compressed yet.
    samples: Vec<u8>,
    /// Bytes of a strip, and of the strips that are compressed together.
    strip: usize,
    together: usize,
    adler: joined::Adler,
    has_begun: bool,
}

impl<W: FnMut(&[u8]) -> io::Result<()>> Strips<W> {
    /// For rows of `row` bytes with `pixel` bytes per pixel; `out` receives the parts of the stream in order.
    pub(super) fn new(row: usize, pixel: usize, out: W) -> Self {
        let strip = row * if joined::is_possible() { (STRIP / row).max(1) } else { usize::MAX / row };
        let together = strip.saturating_mul((TOGETHER / strip).max(1));
        let (above, samples) = (vec![0; row], Vec::new());
        Self { out, row, pixel, above, samples, strip, together, adler: joined::Adler::default(), has_begun: false }
    }

    /// Compresses the collected samples: whole strips, except at the end of the image.
    fn compress(&mut self) -> io::Result<()> {
        let Self { row, pixel, above, samples, strip, .. } = self;
        let all = &samples[..];
        let above_of = |first: usize| if first == 0 { &above[..] } else { &all[first - *row..first] };
        let packed = parallel::blocks(0..all.len(), *strip, &|bytes, _| {
            joined::Part::new(&filtered(&all[bytes.clone()], above_of(bytes.start), *row, *pixel))
        });
        for part in packed {
            let part = part?;
            self.adler.append(&part);
            let mut bytes = if self.has_begun { Vec::new() } else { joined::BEGIN.to_vec() };
            bytes.extend(part.bytes);
            (self.out)(&bytes)?;
            self.has_begun = true;
        }
        if let Some(last) = self.samples.rchunks_exact(self.row).next() {
            self.above.copy_from_slice(last);
        }
        self.samples.clear();
        Ok(())
    }

    /// Passes on what is left; the image must have `rows` rows in all.
    ///
    /// # Errors
    /// Errors of `out`, and `InvalidInput` for another number of samples.
    pub(super) fn finish(mut self, rows: u64) -> io::Result<()> {
        let given = self.adler.length() / (self.row as u64 + 1) + (self.samples.len() / self.row) as u64;
        if given != rows || !self.samples.len().is_multiple_of(self.row) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{given} of {rows} rows were written")));
        }
        self.compress()?;
        (self.out)(&self.adler.end())
    }
}

impl<W: FnMut(&[u8]) -> io::Result<()>> Write for Strips<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.together - self.samples.len());
        self.samples.extend_from_slice(&bytes[..taken]);
        if self.samples.len() == self.together {
            self.compress()?;
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The rows of a strip, each with the type of its filter before it.
fn filtered(samples: &[u8], above: &[u8], row: usize, pixel: usize) -> Vec<u8> {
    let mut out = vec![0; samples.len() / row * (row + 1)];
    let mut up = above;
    for (out, line) in out.chunks_exact_mut(row + 1).zip(samples.chunks_exact(row)) {
        let Some((kind, out)) = out.split_first_mut() else { continue };
        *kind = PAETH;
        // Left of the first pixel are zeros, so the predictor gives the sample above.
        let first = pixel.min(row);
        for k in 0..first {
            out[k] = line[k].wrapping_sub(up[k]);
        }
        // By indices into slices of one length: a loop of vectors when optimised, and no calls of iterators when not.
        let (out, count) = (&mut out[first..], row - first);
        let (x, left, above, corner) = (&line[first..], &line[..count], &up[first..row], &up[..count]);
        for k in 0..out.len().min(x.len()).min(count) {
            out[k] = x[k].wrapping_sub(paeth(left[k], above[k], corner[k]));
        }
        up = line;
    }
    out
}

/// Paeth's predictor (<https://www.w3.org/TR/png-3/#9Filter-type-4-Paeth>), without branches.
fn paeth(left: u8, above: u8, corner: u8) -> u8 {
    let (a, b, c) = (i16::from(left), i16::from(above), i16::from(corner));
    // Not `abs`, which is a call where nothing is optimised: builds of tests spent a third of their time on a picture in it.
    let [of_left, of_above, of_corner] = [b - c, a - c, a + b - 2 * c];
    let of_left = if of_left < 0 { -of_left } else { of_left };
    let of_above = if of_above < 0 { -of_above } else { of_above };
    let of_corner = if of_corner < 0 { -of_corner } else { of_corner };
    let second = if of_above <= of_corner { b } else { c };
    (if of_left <= of_above && of_left <= of_corner { a } else { second }) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth samples with noise.
    fn samples(count: usize) -> Vec<u8> {
        let noise = |n: usize| (n.wrapping_mul(0x9e37_79b9) >> 20) as u8 & 3;
        (0..count).map(|n| (n / 90) as u8 ^ if n % 5000 < 900 { noise(n) } else { 0 }).collect()
    }

    /// The file of an image, its samples passed on `piece` bytes at a time.
    fn file(samples: &[u8], [width, height]: [u32; 2], piece: usize) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().expect("a header");
        let pass = |part: &[u8]| writer.write_chunk(png::chunk::IDAT, part).map_err(io::Error::other);
        let mut strips = Strips::new(3 * width as usize, 3, pass);
        samples.chunks(piece).for_each(|piece| strips.write_all(piece).expect("in memory"));
        strips.finish(height.into()).expect("all rows");
        writer.finish().expect("in memory");
        file
    }

    #[test]
    fn files_decode_to_their_samples_whatever_the_number_of_threads() {
        // One pixel, one strip, strips of one row, more samples than are compressed together, and a strip that is not full.
        for [width, height] in [[1, 1], [1, 300], [200, 100], [50_000, 3], [1500, 1000]] {
            let samples = samples(3 * width as usize * height as usize);
            let files = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
                pool.install(|| file(&samples, [width, height], 1000 * threads + 7))
            });
            assert!(files[0] == files[1], "{width} x {height}");
            let mut reader = png::Decoder::new(io::Cursor::new(&files[0])).read_info().expect("a header");
            let mut read = vec![0; samples.len()];
            reader.next_frame(&mut read).expect("pixels");
            reader.finish().expect("the end, with its checksum");
            assert!(read == samples, "{width} x {height}");
        }
    }

    #[test]
    fn missing_and_surplus_samples_are_errors() {
        for bytes in [0, 29, 31, 60] {
            let mut strips = Strips::new(10, 1, |_: &[u8]| Ok(()));
            strips.write_all(&vec![1; bytes]).expect("in memory");
            assert_eq!(strips.finish(3).expect_err("not 3 rows").kind(), io::ErrorKind::InvalidInput, "{bytes}");
        }
    }

    #[test]
    fn the_predictor_follows_its_definition() {
        for (a, b, c) in (0..=255).flat_map(|n: u8| (0..=255).map(move |m: u8| (n, m, n.wrapping_mul(7) ^ (m / 3)))) {
            // The estimate is a + b - c; the nearest of the three is taken, in their order.
            let estimate = i32::from(a) + i32::from(b) - i32::from(c);
            let nearest = [a, b, c].into_iter().min_by_key(|x| (estimate - i32::from(*x)).abs());
            assert_eq!(Some(paeth(a, b, c)), nearest, "{a} {b} {c}");
        }
    }
}
