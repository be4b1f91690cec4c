//! The frames of a file one after the other. A page in a browser has no files, and so none of the readers.

#[cfg(not(target_arch = "wasm32"))]
pub(super) use files::{Reading, open};
#[cfg(target_arch = "wasm32")]
pub(super) use no_files::{Reading, open};

#[cfg(not(target_arch = "wasm32"))]
mod files {
    use crate::scene_args::SceneArgs;
    use crate::scene_frames::sequence;
    use glam::DVec3;
    use halfline::camera::Camera;
    use halfline::error::Result;
    use halfline::progress::Cancel;
    use halfline_files::read::{Keep, Sequence};

    pub(in crate::view) type Reading = Sequence;

    /// Opens the file for its frames from this one on, with the camera and the middle that all share under `--hold all`.
    pub(in crate::view) fn open(args: &SceneArgs, number: u64) -> Result<(Reading, Option<(Camera, DVec3)>)> {
        sequence(args, Keep::All, Some(number), &Cancel::default())
    }
}

#[cfg(target_arch = "wasm32")]
mod no_files {
    use crate::scene_args::SceneArgs;
    use glam::DVec3;
    use halfline::camera::Camera;
    use halfline::error::{Error, Result};
    use halfline_files::read::{Format, SceneFrame};

    /// No value is of this type.
    pub(in crate::view) enum Reading {}

    pub(in crate::view) fn open(args: &SceneArgs, _: u64) -> Result<(Reading, Option<(Camera, DVec3)>)> {
        Err(Error::read(args.path(), std::io::ErrorKind::Unsupported.into()))
    }

    impl Reading {
        pub(in crate::view) fn next_scene(&mut self) -> Result<Option<SceneFrame>> {
            match *self {}
        }

        pub(in crate::view) fn pass(&mut self) -> Result<bool> {
            match *self {}
        }

        pub(in crate::view) fn passed(&self) -> u64 {
            match *self {}
        }

        pub(in crate::view) fn total(&self) -> Option<u64> {
            match *self {}
        }

        pub(in crate::view) fn nothing(&self) -> Error {
            match *self {}
        }

        pub(in crate::view) fn format(&self) -> Format {
            match *self {}
        }
    }
}
