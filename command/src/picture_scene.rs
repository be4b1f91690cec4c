//! The scene of one picture, with all options applied.

use super::light_args::PictureLook;
use halfline::frame::legend::Legend;
use halfline::render::stream::{PartView, StreamIds};
use halfline::scene::Scene;
use halfline_files::read::mark::Marked;
use halfline_files::read::matte::MatteNames;
use halfline_files::read::{FrameTime, Skipped};

/// A scene that is ready to render, and its number for file names.
pub(super) struct PictureScene {
    /// The number of the frame or the turn, from 1.
    pub(super) number: u64,
    pub(super) scene: Scene,
    /// The number of its spheres that are beads of a cell.
    pub(super) beads: usize,
    pub(super) skipped: Skipped,
    pub(super) legend: Option<Legend>,
    pub(super) look: PictureLook,
    pub(super) when: FrameTime,
    /// Words for the spheres that the camera frames, for `halfline plan`; `None` for a camera that is given.
    pub(super) framed: Option<String>,
    /// The ids in the stream of the spheres that are left of it; `None` for a scene that is read as a whole.
    pub(super) ids: Option<StreamIds>,
    /// The things that have marks, with their texts.
    pub(super) marked: Vec<Marked>,
    /// The names of the spheres in Cryptomatte layers.
    pub(super) mattes: Vec<MatteNames>,
    /// Words and names by the columns of a figure's groups, then by others that its paths have.
    pub(super) path_names: Vec<(String, MatteNames)>,
    /// The frame that the parts were made for; `None` for a scene that is not of parts.
    pub(super) part_view: Option<PartView>,
}

impl PictureScene {
    /// A single picture, with nothing else known of it yet.
    pub(super) fn bare(scene: Scene, look: PictureLook) -> Self {
        Self {
            number: 1,
            scene,
            beads: 0,
            skipped: Skipped::default(),
            legend: None,
            look,
            when: FrameTime::default(),
            framed: None,
            ids: None,
            marked: Vec::new(),
            mattes: Vec::new(),
            path_names: Vec::new(),
            part_view: None,
        }
    }
}
