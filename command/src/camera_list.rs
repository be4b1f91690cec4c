//! `--cameras`: a picture for each camera of a list, and the list `cameras.json` beside the pictures.

use clap::Args;
use halfline::camera::{Aperture, CameraRecord, Intrinsics, Lens};
use halfline::error::{Error, Result};
use halfline::scene::{ImagePlane, Scene};
use halfline_files::read::cameras::{self, ListedCamera};
use halfline_files::write::file::{is_standard_output, write_atomically};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The options for lists of cameras.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(super) struct CameraListArgs {
    /// Renders a picture for each camera of a list: JSON (cameras with eye, view or at, and up; transforms.json of NeRF;
    /// pose matrices in the axes of OpenCV) or CSV. Writes cameras.json beside the pictures. With --frames, frame N has
    /// camera N.
    #[arg(long = "cameras", value_name = "FILE", conflicts_with_all =
        ["eye", "at", "view", "up", "focus", "frame_share", "fit", "ortho", "spin", "from", "lens"])]
    pub(super) file: Option<PathBuf>,
    /// The cameras, once they were read.
    #[arg(skip)]
    listed: OnceLock<Vec<ListedCamera>>,
}

impl CameraListArgs {
    /// The cameras of the list; `None` without one.
    ///
    /// # Errors
    /// Errors of [`cameras::read`].
    pub(super) fn listed(&self) -> Result<Option<&[ListedCamera]>> {
        let Some(file) = &self.file else { return Ok(None) };
        if let Some(listed) = self.listed.get() {
            return Ok(Some(listed));
        }
        let listed = cameras::read(file)?;
        Ok(Some(self.listed.get_or_init(|| listed)))
    }

    /// Checks that the cameras of these numbers have images of one size, as far as the list gives sizes.
    ///
    /// # Errors
    /// [`Error::Settings`] with two cameras whose images differ; errors of [`cameras::read`].
    pub(super) fn check_one_size(&self, film: &Path, is_used: impl Fn(u64) -> bool) -> Result<()> {
        let listed = self.listed()?.unwrap_or_default().iter().zip(1..);
        let mut sizes =
            listed.filter(|(_, number)| is_used(*number)).filter_map(|(camera, number)| Some((number, camera.size?)));
        let Some((first, size)) = sizes.next() else { return Ok(()) };
        match sizes.find(|(_, other)| *other != size) {
            Some((number, other)) => Err(sizes_differ(film, [(first, size), (number, other)])),
            None => Ok(()),
        }
    }

    /// The size of the lens of camera `number` of the list, from 1; `None` for a pinhole.
    ///
    /// # Errors
    /// Errors of [`cameras::read`].
    pub(super) fn aperture(&self, number: u64) -> Result<Option<Aperture>> {
        let index = usize::try_from(number - 1).unwrap_or(usize::MAX);
        Ok(self.listed()?.and_then(|listed| listed.get(index)?.aperture))
    }

    /// Gives a scene camera `number` of the list, from 1; `intrinsics` or `vfov` where it has no lens. Its size comes from the option, the list
    /// or the scene.
    ///
    /// # Errors
    /// [`Error::Settings`] for a camera without a lens, and errors of [`ListedLens::for_image`](cameras::ListedLens::for_image).
    pub(super) fn apply(
        &self,
        number: u64,
        size: Option<(u32, u32)>,
        (intrinsics, vfov): (Option<Intrinsics>, Option<Lens>),
        scene: &mut Scene,
    ) -> Result<()> {
        let listed = self.listed()?.unwrap_or_default();
        let index = usize::try_from(number - 1).unwrap_or(usize::MAX);
        let Some(found) = listed.get(index) else {
            let problem = format!("frame {number} has no camera: the list has {}", listed.len());
            return Err(Error::settings(problem, "select fewer --frames, or add cameras to the list"));
        };
        if let (None, Some([width, height])) = (size, found.size) {
            (scene.image.width, scene.image.height) = (width, height);
        }
        let lens = found.lens(intrinsics, vfov).ok_or_else(|| {
            let problem = format!("camera {index} has no lens");
            Error::settings(problem, "add --intrinsics FX,FY,CX,CY or --vfov DEG, or intrinsics to the list")
        })?;
        let ImagePlane { width, height, .. } = scene.image;
        let lens = lens.for_image(index, width, height)?;
        scene.camera = halfline::Camera { lens, ..found.camera };
        Ok(())
    }
}

/// The error of a film whose pictures of these numbers have two sizes.
pub(super) fn sizes_differ(film: &Path, [(a, first), (b, other)]: [(u64, [u32; 2]); 2]) -> Error {
    let words = |number, [width, height]: [u32; 2]| format!("picture {number} has {width} x {height} pixels");
    let problem = format!("{}: {}, and {}", film.display(), words(a, first), words(b, other));
    Error::settings(problem, "add --size WxH, which all pictures of a film have, or write pictures, such as o.%04d.png")
}

/// The cameras of the pictures that were written.
#[derive(Debug, Serialize)]
pub(super) struct WrittenCameras {
    schema: &'static str,
    version: u32,
    cameras: Vec<WrittenCamera>,
}

/// The camera of a picture and its files.
#[derive(Debug, Serialize)]
struct WrittenCamera {
    number: u64,
    files: Vec<PathBuf>,
    #[serde(flatten)]
    camera: Option<CameraRecord>,
}

impl Default for WrittenCameras {
    fn default() -> Self {
        Self { schema: "halfline-cameras", version: 1, cameras: Vec::new() }
    }
}

impl WrittenCameras {
    /// Adds a picture. Files are named from the folder of the list.
    pub(super) fn add<'a>(&mut self, number: u64, files: impl Iterator<Item = &'a Path>, camera: Option<CameraRecord>) {
        let files = files.filter(|path| !is_standard_output(path)).map(Path::to_path_buf).collect();
        self.cameras.push(WrittenCamera { number, files, camera });
    }

    /// Writes the list as `cameras.json` in this folder.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn write(mut self, folder: &Path) -> Result<()> {
        for camera in &mut self.cameras {
            for file in &mut camera.files {
                *file = file.strip_prefix(folder).map_or_else(|_| file.clone(), Path::to_path_buf);
            }
        }
        let path = list_in(folder);
        let text = serde_json::to_string_pretty(&self).map_err(|e| Error::write(&path, e.into()))?;
        write_atomically(&path, |out| {
            out.write_all(text.as_bytes())?;
            out.write_all(b"\n")
        })
    }
}

/// The list in a folder.
pub(super) fn list_in(folder: &Path) -> PathBuf {
    folder.join("cameras.json")
}
