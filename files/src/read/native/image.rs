//! The image of a native scene file: `[image]`.

use super::table::TomlTable;
use halfline::error::{Error, Result};
use halfline::scene::{ImagePlane, check_size};
use halfline::settings::{FileLook, Look};

/// The values of the table `[image]`.
#[derive(Default)]
pub(super) struct Read {
    /// The size; its background is the default one.
    pub(super) image: ImagePlane,
    pub(super) background: Option<[f32; 3]>,
    pub(super) look: FileLook,
}

pub(super) fn read(table: &TomlTable<'_>) -> Result<Read> {
    table.allow(&["size", "background", "samples", "look"])?;
    let mut image = ImagePlane::default();
    if let Some(size) = table.get("size") {
        (image.width, image.height) = check_size(size.whole_numbers()?, || size.place())?;
    }
    let background = table.get("background").map(|color| color.color()).transpose()?;
    Ok(Read { image, background, look: look(table)? })
}

/// The look and the samples of the picture.
fn look(table: &TomlTable<'_>) -> Result<FileLook> {
    let look = table.get("look").map(|value| {
        value.string()?.parse::<Look>().map_err(|error| match error {
            Error::Settings { problem, mend } => Error::scene(value.place(), problem, mend),
            other => other,
        })
    });
    let samples = table.get("samples").map(|value| {
        let count = value.whole_number()?;
        u32::try_from(count).ok().filter(|count| *count > 0).ok_or_else(|| {
            let problem = format!("a pixel cannot have {count} samples");
            Error::scene(value.place(), problem, format!("give a whole number between 1 and {}", u32::MAX))
        })
    });
    Ok(FileLook { is_particles: false, look: look.transpose()?, samples: samples.transpose()? })
}
