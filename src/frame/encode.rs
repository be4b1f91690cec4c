//! Buffers become the samples that a format stores.

use super::format::{Bits, Format, Style};
use super::sheet::{Kind, Layer};
use super::{Aov, Buffer, Data, Frame, srgb};
use rayon::prelude::*;
use std::borrow::Cow;

/// The buffers `aovs` of `frame`, as `format` stores them; those the frame does not hold are left out.
pub(super) fn layers<'a>(frame: &'a Frame, aovs: &[Aov], format: Format, style: &Style) -> Vec<Layer<'a>> {
    let alpha = frame.f32(Aov::Alpha).filter(|_| format == Format::Png && aovs.contains(&Aov::Alpha));
    let within = |aov: &Aov| !(alpha.is_some() && *aov == Aov::Alpha && aovs.contains(&Aov::Color));
    let buffers = aovs.iter().filter(|aov| within(aov)).filter_map(|aov| frame.get(*aov));
    buffers.map(|buffer| layer(buffer, alpha, format, style)).collect()
}

/// One buffer as `format` stores it; colour in a PNG with `alpha`, if that is given.
pub(super) fn layer<'a>(buffer: &'a Buffer, alpha: Option<&[f32]>, format: Format, style: &Style) -> Layer<'a> {
    let (aov, channels) = (buffer.aov, buffer.aov.channels());
    let (kind, bytes) = match (format, &buffer.data) {
        (Format::Png, data) => {
            let (channels, kind, bytes) = levels(aov, data, alpha, style);
            return Layer { aov, kind, channels, bytes: bytes.into() };
        }
        (Format::Exr | Format::Pfm, Data::F64(values)) => {
            (Kind::F32, made(values, |x| (missed(aov, style, x) as f32).to_le_bytes()).into())
        }
        (Format::Exr, Data::I32(values)) => (Kind::U32, plain(values, i32::to_le_bytes)),
        (Format::Exr, Data::U8(values)) if aov == Aov::Mask => {
            (Kind::F32, made(values, |x| f32::from(x).to_le_bytes()).into())
        }
        (Format::Exr, Data::U8(values)) => (Kind::U32, made(values, |x| u32::from(x).to_le_bytes()).into()),
        (_, Data::F64(values)) if is_length(aov) && style.no_return.value() != f64::INFINITY => {
            (Kind::F64, made(values, |x| missed(aov, style, x).to_le_bytes()).into())
        }
        (_, Data::F64(values)) => (Kind::F64, plain(values, f64::to_le_bytes)),
        (_, Data::F32(values)) => (Kind::F32, plain(values, f32::to_le_bytes)),
        (_, Data::I32(values)) => (Kind::I32, plain(values, i32::to_le_bytes)),
        (_, Data::U8(values)) => (Kind::U8, Cow::Borrowed(&values[..])),
    };
    Layer { aov, kind, channels, bytes }
}

fn is_length(aov: Aov) -> bool {
    matches!(aov, Aov::Distance | Aov::Depth)
}

/// The number that is written, another one on a miss if that is asked for.
fn missed(aov: Aov, style: &Style, x: f64) -> f64 {
    if is_length(aov) && x == f64::INFINITY { style.no_return.value() } else { x }
}

/// The bytes that memory already holds, where it holds them as files do.
fn plain<T: bytemuck::NoUninit + Sync, const N: usize>(
    values: &[T],
    little: impl Fn(T) -> [u8; N] + Sync,
) -> Cow<'_, [u8]> {
    if cfg!(target_endian = "little") {
        Cow::Borrowed(bytemuck::cast_slice(values))
    } else {
        made(values, little).into()
    }
}

fn made<T: Copy + Sync, const N: usize>(values: &[T], bytes: impl Fn(T) -> [u8; N] + Sync) -> Vec<u8> {
    let mut out = vec![0; N * values.len()];
    out.par_chunks_exact_mut(N).zip(values).with_min_len(1 << 12).for_each(|(out, x)| out.copy_from_slice(&bytes(*x)));
    out
}

/// Channels, type and samples of a PNG.
fn levels(aov: Aov, data: &Data, alpha: Option<&[f32]>, style: &Style) -> (usize, Kind, Vec<u8>) {
    let sixteen = style.bits == Bits::Sixteen;
    let kind = if sixteen { Kind::U16 } else { Kind::U8 };
    match (data, alpha) {
        (Data::F32(linear), Some(alpha)) if aov == Aov::Color && sixteen => {
            (4, kind, straight(linear, alpha, |x| srgb::level16(x).to_le_bytes(), |x| share16(x).to_le_bytes()))
        }
        (Data::F32(linear), Some(alpha)) if aov == Aov::Color => {
            (4, kind, straight(linear, alpha, |x| [srgb::level(x)], |x| [share8(x)]))
        }
        (Data::F32(linear), _) if aov == Aov::Color && sixteen => {
            (3, kind, made(linear, |x| srgb::level16(x).to_le_bytes()))
        }
        (Data::F32(linear), _) if aov == Aov::Color => (3, kind, srgb::levels(linear)),
        (Data::F32(values), _) => {
            // Of a normal (n + 1) / 2: a miss is the middle grey.
            let share = |x: f32| if aov == Aov::Normal { f32::midpoint(x, 1.0) } else { x };
            let bytes = match sixteen {
                true => made(values, |x| share16(share(x)).to_le_bytes()),
                false => made(values, |x| [share8(share(x))]),
            };
            (aov.channels(), kind, bytes)
        }
        (Data::F64(values), _) => (1, Kind::U16, made(values, |x| step(x, style.unit).to_le_bytes())),
        (Data::U8(values), _) => (1, Kind::U8, made(values, |x| [if x == 0 { 0 } else { 255 }])),
        // Ids are no picture: Format::takes refuses them, and nobody takes no channels for a buffer.
        (Data::I32(_), _) => (0, Kind::U8, Vec::new()),
    }
}

/// Red, green, blue and alpha, each of `N` bytes, of colours that were multiplied by alpha.
fn straight<const N: usize>(
    linear: &[f32],
    alpha: &[f32],
    level: impl Fn(f32) -> [u8; N] + Sync,
    share: impl Fn(f32) -> [u8; N] + Sync,
) -> Vec<u8> {
    let mut out = vec![0; 4 * N * alpha.len()];
    let pixels = out.par_chunks_exact_mut(4 * N).zip(linear.par_chunks_exact(3)).zip(alpha);
    pixels.for_each(|((out, rgb), alpha)| {
        for (out, x) in out.chunks_exact_mut(N).zip(rgb) {
            out.copy_from_slice(&level(if *alpha > 0.0 { x / alpha } else { 0.0 }));
        }
        out[3 * N..].copy_from_slice(&share(*alpha));
    });
    out
}

/// The level nearest to a share of 1. The cast saturates, and NaN is 0.
fn share8(x: f32) -> u8 {
    (255.0 * x).round() as u8
}

/// The same of 65535, in f64: half a level is beyond f32's last bits.
fn share16(x: f32) -> u16 {
    (65535.0 * f64::from(x)).round() as u16
}

/// A length in whole units; 0 is kept for a miss, so a hit is 1 at least.
fn step(x: f64, unit: f64) -> u16 {
    if x.is_finite() { (x / unit).round().clamp(1.0, STEPS) as u16 } else { 0 }
}

/// The greatest length of a 16-bit PNG, in units.
const STEPS: f64 = 65535.0;

/// What does not fit the steps of a 16-bit PNG, in words.
pub(super) fn warning(buffer: &Buffer, unit: f64) -> Option<String> {
    let Data::F64(values) = &buffer.data else { return None };
    let beyond = |x: &&f64| x.is_finite() && (**x / unit).round() > STEPS;
    let count = values.par_iter().filter(beyond).count();
    if count == 0 {
        return None;
    }
    let farthest = values.par_iter().filter(|x| x.is_finite()).copied().reduce(|| 0.0, f64::max);
    let (aov, enough) = (buffer.aov, farthest / STEPS);
    Some(format!(
        "{count} values of {aov} are beyond 65535 steps of {unit} and are written as 65535, the farthest is {farthest}; \
         give --unit {enough:.3e} or more, or write .exr or .npy"
    ))
}
