//! The scenes of a measurement.

use super::suite::{extremes, ladder};
use halfline::error::Result;
use halfline::scene::Scene;
use std::path::Path;

/// The scenes to measure.
pub struct Subject {
    pub(super) name: String,
    pub(super) kind: SubjectKind,
    pub(super) cases: Vec<SceneGroup>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SubjectKind {
    Scene,
    Extremes,
    Ladder,
}

/// Scenes measured together under one name.
pub(super) struct SceneGroup {
    pub(super) name: String,
    pub(super) scenes: Vec<Scene>,
    /// Warnings of the reader of its scenes, in whole sentences.
    pub(super) warnings: Vec<String>,
}

impl Subject {
    /// One scene, without its lights and its sky: they are the same for every method. `warnings` come from its reader.
    #[must_use]
    pub fn scene(name: impl Into<String>, scene: Scene, warnings: Vec<String>) -> Self {
        let (name, scenes) = (name.into(), vec![Scene { lighting: Default::default(), ..scene }]);
        Self { cases: vec![SceneGroup { name: name.clone(), scenes, warnings }], name, kind: SubjectKind::Scene }
    }

    /// The families of extremes; `folder` contains the third-party data, if there is any.
    ///
    /// # Errors
    /// Errors of [`extremes::Family::scenes`].
    pub fn extremes(folder: Option<&Path>) -> Result<Self> {
        let case = |family: &extremes::Family| {
            let scenes = family.scenes(extremes::SEED, folder)?;
            Ok(SceneGroup { name: family.name.into(), scenes, warnings: Vec::new() })
        };
        let cases: Vec<_> = extremes::FAMILIES.iter().map(case).collect::<Result<_>>()?;
        Ok(Self { name: "suite extremes".into(), kind: SubjectKind::Extremes, cases })
    }

    /// The wall from near to far.
    ///
    /// # Errors
    /// Errors of [`ladder::scene`].
    pub fn ladder() -> Result<Self> {
        let case = |rung: f64| {
            Ok(SceneGroup { name: ladder::name(rung), scenes: vec![ladder::scene(rung)?], warnings: Vec::new() })
        };
        let cases = ladder::RUNGS.into_iter().map(case).collect::<Result<_>>()?;
        Ok(Self { name: "suite ladder".into(), kind: SubjectKind::Ladder, cases })
    }

    /// Sets the size of all its pictures.
    #[must_use]
    pub fn resized(mut self, [width, height]: [u32; 2]) -> Self {
        for scene in self.cases.iter_mut().flat_map(|case| &mut case.scenes) {
            (scene.image.width, scene.image.height) = (width, height);
        }
        self
    }
}
