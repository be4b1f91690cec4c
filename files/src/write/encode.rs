//! Encodes buffers as the samples that a format stores.

use super::cryptomatte::MatteHead;
use super::format::{FileFormat, FormatOptions};
use super::layer::{LayerFormat, SampleType};
use super::mattes::MatteLayer;
use super::rows::Rows;
use halfline::error::{Error, Result};
use halfline::frame::coverage::Coverage;
use halfline::frame::tone::Toning;
use halfline::frame::{Aov, Buffer, Data, Frame, srgb};
use halfline::parallel;
use halfline::quote::number;
use halfline::quote::setting::{SELECT, UNIT};
use std::borrow::Cow;
use std::ops::Range;

/// The samples of a frame's buffers, encoded row by row.
pub(super) struct Encoder<'a> {
    buffers: Vec<&'a Buffer>,
    forms: Vec<LayerFormat>,
    mattes: Vec<MatteLayer>,
    coverage: Option<&'a Coverage>,
    /// The fourth channel of colour.
    alpha: Option<&'a [f32]>,
    columns: usize,
    format: FileFormat,
    style: &'a FormatOptions,
    /// Of colour in levels.
    toning: Toning,
}

impl<'a> Encoder<'a> {
    /// The buffers `aovs` of `frame` as `format` stores them; `None` if the frame lacks one of them or one file cannot
    /// hold them.
    pub(super) fn new(frame: &'a Frame, aovs: &[Aov], format: FileFormat, style: &'a FormatOptions) -> Option<Self> {
        let lights = frame.get(Aov::Shadow).map_or(0, Buffer::channels);
        let wide = frame.get(Aov::Id).is_some_and(Buffer::is_wide);
        let forms = format.forms(aovs, style.bits, lights, wide)?;
        let buffers = forms.iter().map(|form| frame.get(form.aov)).collect::<Option<_>>()?;
        let with_alpha = forms.iter().any(LayerFormat::has_alpha);
        let alpha = if with_alpha { Some(frame.f32(Aov::Alpha)?) } else { None };
        let (coverage, columns, toning) = (frame.coverage.as_ref(), frame.width as usize, frame.toning());
        Some(Self { buffers, forms, mattes: Vec::new(), coverage, alpha, columns, format, style, toning })
    }

    /// One buffer as .npy stores it.
    pub(super) fn plain(buffer: &'a Buffer, style: &'a FormatOptions) -> Option<Self> {
        let (format, columns) = (FileFormat::Npy, buffer.shape[1]);
        let forms = format.forms(&[buffer.aov], style.bits, buffer.channels(), buffer.is_wide())?;
        let toning = Toning::default();
        Some(Self {
            buffers: vec![buffer],
            forms,
            mattes: Vec::new(),
            coverage: None,
            alpha: None,
            columns,
            format,
            style,
            toning,
        })
    }

    /// The same with Cryptomatte layers after the buffers.
    pub(super) fn with_mattes(self, mattes: Vec<MatteLayer>) -> Self {
        Self { mattes, ..self }
    }

    /// The facts about the Cryptomatte layers.
    pub(super) fn mattes(&self) -> Vec<MatteHead> {
        self.mattes.iter().map(|matte| matte.head.clone()).collect()
    }

    /// The sample format of each buffer.
    pub(super) fn forms(&self) -> &[LayerFormat] {
        &self.forms
    }
}

impl Rows for Encoder<'_> {
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>> {
        if let (Some(matte), Some(coverage)) = (layer.checked_sub(self.forms.len()), self.coverage) {
            let (matte, columns) = (&self.mattes[matte], self.columns);
            let ranked = |row: &Vec<_>| matte.ranked(row, columns, coverage.samples);
            let rows = &coverage.rows[rows];
            let all = parallel::collect(rows.len(), 1, &|range, out| out.extend(rows[range].iter().flat_map(ranked)));
            return Ok(made(&all, f32::to_le_bytes).into());
        }
        let (buffer, form, style) = (self.buffers[layer], self.forms[layer], self.style);
        let pixels = rows.start * self.columns..rows.end * self.columns;
        let channels = buffer.channels();
        let values = channels * pixels.start..channels * pixels.end;
        Ok(match &buffer.data {
            Data::F32(all) => match self.alpha.filter(|_| form.has_alpha()) {
                Some(alpha) => with_alpha(&all[values], &alpha[pixels], form, self.toning).into(),
                None => floats(&all[values], form, self.toning),
            },
            Data::F64(all) => doubles(&all[values], form, style),
            Data::I32(all) => match form.kind {
                SampleType::U16 => made(&all[values], |id| number_of(id).unwrap_or(u16::MAX).to_le_bytes()).into(),
                _ => plain(&all[values], i32::to_le_bytes),
            },
            Data::I64(all) => plain(&all[values], i64::to_le_bytes),
            Data::U8(all) => bytes(&all[values], form, self.format),
        })
    }
}

fn floats(values: &[f32], form: LayerFormat, toning: Toning) -> Cow<'_, [u8]> {
    // For a normal (n + 1) / 2, so a miss is middle grey.
    let share = |x: f32| if form.aov == Aov::Normal { f32::midpoint(x, 1.0) } else { x };
    match (form.kind, form.aov) {
        (SampleType::U16, Aov::Color) => made(&toning.all(values), |x| srgb::level16(x).to_le_bytes()).into(),
        (SampleType::U8, Aov::Color) => srgb::levels(&toning.all(values)).into(),
        (SampleType::U16, _) => made(values, |x| share16(share(x)).to_le_bytes()).into(),
        (SampleType::U8, _) => made(values, |x| [share8(share(x))]).into(),
        _ => plain(values, f32::to_le_bytes),
    }
}

fn doubles<'a>(values: &'a [f64], form: LayerFormat, style: &FormatOptions) -> Cow<'a, [u8]> {
    let (aov, changed) = (form.aov, is_length(form.aov) && style.no_return.value() != f64::INFINITY);
    match form.kind {
        SampleType::U16 => made(values, |x| step(x, style.unit).to_le_bytes()).into(),
        SampleType::F32 => made(values, |x| (missed(aov, style, x) as f32).to_le_bytes()).into(),
        _ if changed => made(values, |x| missed(aov, style, x).to_le_bytes()).into(),
        _ => plain(values, f64::to_le_bytes),
    }
}

fn bytes(values: &[u8], form: LayerFormat, format: FileFormat) -> Cow<'_, [u8]> {
    match form.kind {
        SampleType::U32 => made(values, |x| u32::from(x).to_le_bytes()).into(),
        SampleType::F32 => made(values, |x| f32::from(x).to_le_bytes()).into(),
        _ if format == FileFormat::Png => made(values, |x| [if x == 0 { 0 } else { 255 }]).into(),
        _ => Cow::Borrowed(values),
    }
}

fn with_alpha(linear: &[f32], alpha: &[f32], form: LayerFormat, toning: Toning) -> Vec<u8> {
    match form.kind {
        SampleType::U16 => {
            straight(linear, alpha, toning, |x| srgb::level16(x).to_le_bytes(), |x| share16(x).to_le_bytes())
        }
        _ => straight(linear, alpha, toning, |x| [srgb::level(x)], |x| [share8(x)]),
    }
}

fn is_length(aov: Aov) -> bool {
    matches!(aov, Aov::Distance | Aov::Depth)
}

/// The written number; a miss may have another one.
fn missed(aov: Aov, style: &FormatOptions, x: f64) -> f64 {
    if is_length(aov) && x == f64::INFINITY { style.no_return.value() } else { x }
}

/// The bytes of the values, where memory and file have the same byte order.
pub(super) fn plain<T: bytemuck::NoUninit + Sync, const N: usize>(
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
    parallel::zip(out.as_chunks_mut().0, values, |out, x| *out = bytes(*x));
    out
}

/// Red, green, blue and alpha, each of `N` bytes, from colours premultiplied by alpha.
fn straight<const N: usize>(
    linear: &[f32],
    alpha: &[f32],
    toning: Toning,
    level: impl Fn(f32) -> [u8; N] + Sync,
    share: impl Fn(f32) -> [u8; N] + Sync,
) -> Vec<u8> {
    let (linear, mut out) = (linear.as_chunks().0, vec![0; 4 * N * alpha.len()]);
    parallel::each(out.as_chunks_mut().0.as_chunks_mut().0, |n, out| {
        let own = linear[n].map(|x| if alpha[n] > 0.0 { x / alpha[n] } else { 0.0 });
        let [red, green, blue] = toning.of(own).map(&level);
        *out = [red, green, blue, share(alpha[n])];
    });
    out
}

/// The 8-bit level nearest to a share of 1. The cast saturates, and NaN gives 0.
fn share8(x: f32) -> u8 {
    (255.0 * x).round() as u8
}

/// The 16-bit level, in f64: half a level is below the last bits of f32.
fn share16(x: f32) -> u16 {
    (65535.0 * f64::from(x)).round() as u16
}

/// A length in whole units; 0 means a miss, so a hit is at least 1.
fn step(x: f64, unit: f64) -> u16 {
    if x.is_finite() { (x / unit).round().clamp(1.0, STEPS) as u16 } else { 0 }
}

/// The largest length in a 16-bit PNG, in units.
const STEPS: f64 = 65535.0;

/// The number of a sphere in a 16-bit PNG, from 1: 0 is a miss. `None` for an id that is too large.
fn number_of(id: i32) -> Option<u16> {
    u16::try_from(i64::from(id) + 1).ok()
}

/// Checks that a 16-bit PNG can hold the ids.
///
/// # Errors
/// [`Error::Settings`] for an id above 65534.
pub(super) fn check_ids(buffer: &Buffer) -> Result<()> {
    let Data::I32(ids) = &buffer.data else { return Ok(()) };
    match Some(parallel::reduce(ids, -1, i32::max)).filter(|id| number_of(*id).is_none()) {
        Some(id) => {
            let problem = format!("the id {id} does not fit into a 16-bit PNG, which holds ids up to 65534");
            Err(Error::settings(problem, format!("write .npy or .exr, or {SELECT} fewer spheres")))
        }
        None => Ok(()),
    }
}

/// A warning about lengths that do not fit into a 16-bit PNG.
pub(super) fn warning(buffer: &Buffer, unit: f64) -> Option<String> {
    let Data::F64(values) = &buffer.data else { return None };
    let beyond = |n: usize| values[n].is_finite() && (values[n] / unit).round() > STEPS;
    let count = parallel::count(values.len(), beyond);
    if count == 0 {
        return None;
    }
    let farthest = parallel::reduce(values, 0.0, |most, x| if x.is_finite() { most.max(x) } else { most });
    let (aov, enough) = (buffer.aov, farthest / STEPS);
    Some(format!(
        "{count} values of {aov} exceed 65535 units of {unit} and are written as 65535; the largest is {farthest}; \
         use {UNIT} {} or more, or write .exr or .npy",
        number(enough, 4)
    ))
}
