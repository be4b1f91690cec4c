//! The content of a page without a server, from a file and the options of the command.

use super::content::{Content, PageText};
use super::frames::Frames;
use super::given::{Given, GivenOption};
use super::handler::read_first;
use super::parse::Parser;
use crate::option_table::{Call, call};
use halfline::error::{Error, Result};
use halfline_files::read::{FrameRange, SceneFrame};
use std::path::Path;

/// The content of a page that shows these frames of a file with the options that were typed. `kept` are the names of the columns that it
/// has of each sphere.
///
/// # Errors
/// Errors of the options, of reading the file, and of a column that it lacks; [`Error::Settings`] for frames with gaps between them.
pub(crate) fn content(given: &Given, range: Option<&FrameRange>, kept: &[String]) -> Result<Content> {
    let first = range.map_or(1, |range| range.numbers().next().unwrap_or(1));
    let mut parser = Parser::new()?;
    let words = given.words(&given.initial());
    let args = parser.args(&words)?;
    let (mut read, summary, _) = read_first(Frames::new(words.clone(), parser.args(&words)?), &args, first)?;
    let mut frames = vec![read.get(first)?.copy()];
    for number in range.into_iter().flat_map(FrameRange::numbers).skip(1) {
        if number != first + frames.len() as u64 {
            let problem =
                format!("frames {} and {number} do not follow each other", number.min(first + frames.len() as u64 - 1));
            return Err(Error::settings(problem, "use a range such as --frames 5-20"));
        }
        let frame = read.get(number).map(SceneFrame::copy);
        match frame {
            Err(_) if range.is_some_and(|range| range.last() == u64::MAX) && read.total == Some(number - 1) => break,
            frame => frames.push(frame?),
        }
    }
    let of_pictures = |id: &str| matches!(call(id), Some(Call::Render | Call::Camera | Call::Save));
    let all = given.with_preferences(given.options().to_vec());
    let rendering = all.iter().filter(|option| of_pictures(&option.id)).map(GivenOption::written).collect();
    // Another machine has another device.
    let copied = given.options().iter().filter(|option| call(&option.id) != Some(Call::Renderer));
    let copied = copied.map(GivenOption::written).collect();
    let name = Path::new(&given.scene).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut content = Content {
        edges: frames[0].cell,
        frames,
        source: Some(given.scene.clone()),
        name,
        rendering,
        copied,
        camera: serde_json::from_value(summary["camera"].clone())
            .map_err(|error| Error::settings(error.to_string(), "use another camera"))?,
        size: serde_json::from_value(summary["size"].clone())
            .map_err(|error| Error::settings(error.to_string(), "use another size"))?,
        is_sized: summary["sized"] == true,
        is_framed: !read.get(first)?.has_camera && args.camera.frames_all(),
        text: PageText::default(),
    };
    content.keep(kept)?;
    Ok(content)
}
