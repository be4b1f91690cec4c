//! Readings of a file before its blocks are: of what depends on all rows.

use super::{frame, start};
use crate::read::open::listed;
use crate::read::options::ReadOptions;
use crate::read::particles::colors::ColorSurvey;
use crate::read::particles::request::Request;
use crate::read::particles::survey::Survey;
use crate::read::source::SceneSource;
use crate::read::style::Style;
use halfline::error::Result;
use std::path::Path;

/// Surveys the colours of a file, reading until their scale is certain; `None` where a part has no colours. Errors of
/// rows are reported when their block is used, not here.
pub(super) fn colors_of(path: &Path, options: &ReadOptions) -> Result<Option<ColorSurvey>> {
    let source = SceneSource::open(path, options.known_format(), &options.watch)?;
    let (_, parts, reader) = start(source, &ReadOptions { style: Style::default(), ..options.clone() }, Vec::new())?;
    let mut colors = ColorSurvey::default();
    for part in &parts {
        options.watch.check()?;
        colors.see(part.color_type, &part.colors);
        if part.colors.is_empty() || colors.is_decided() {
            return Ok((!part.colors.is_empty()).then_some(colors));
        }
    }
    if let Ok(Ok(Some(rest))) = reader.join() {
        colors.see(rest.color_type, &rest.colors);
    }
    Ok(Some(colors))
}

/// Those of these columns in which some row of the frame has a text; none where the file cannot be read to its end, so that the
/// error is that of its row.
pub(super) fn texts_of(path: &Path, options: &ReadOptions, columns: &[String]) -> Result<Vec<String>> {
    let source = SceneSource::open(path, options.known_format(), &options.watch)?;
    let survey = Survey::default();
    let request = Request { columns: columns.to_vec(), survey: Some(survey.clone()), ..options.request(source.format) };
    let Ok(frames) = listed(source, request, options)? else { return Ok(Vec::new()) };
    let Ok(Some(rest)) = frame(frames, options.frames.numbers().next().unwrap_or(1)) else { return Ok(Vec::new()) };
    let counts = rest.counted(&survey);
    Ok(counts.columns.into_iter().filter(|(_, column)| column.is_text()).map(|(name, _)| name).collect())
}
