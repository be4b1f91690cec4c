//! The size of the lens in a native scene file: `aperture` and `focus` of `[camera]`.

use super::table::TomlTable;
use halfline::error::{Error, Result, relocate};
use halfline::scene::camera::{Aperture, Camera};

/// The lens of a camera, which is a pinhole without `aperture`.
pub(super) fn read(table: &TomlTable<'_>, camera: &Camera) -> Result<Option<Aperture>> {
    let number = |key| table.get(key).map(|value| value.number()).transpose();
    let (diameter, focus) = (number("aperture")?, number("focus")?);
    let Some(diameter) = diameter else {
        return match table.get("focus") {
            Some(focus) => {
                let problem = "all is in focus without an aperture";
                Err(Error::scene(
                    focus.place(),
                    problem,
                    "add aperture = 0.1, the diameter of the lens, or remove focus",
                ))
            }
            None => Ok(None),
        };
    };
    let aperture = Aperture { diameter, focus };
    let locate = |field: &str| table.place_of(field.trim_start_matches("camera."), "aperture").named(field);
    aperture.distance(camera).map_err(|error| relocate(error, locate))?;
    Ok(Some(aperture))
}
