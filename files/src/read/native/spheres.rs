//! `[[spheres]]`: the spheres of a file, or the selected ones of them.

use super::table::TomlTable;
use crate::read::options::ReadOptions;
use halfline::error::{Error, Place, Result};
use halfline::memory::reserve;
use halfline::progress::Watch;
use halfline::quote::quote;
use halfline::quote::setting::STREAM;
use halfline::scene::{DEFAULT_COLOR, List, Material, Spheres};
use halfline_particles::Selection;
use halfline_particles::detect::of_name;
use halfline_particles::ending;
use halfline_particles::open::open;
use halfline_particles::opened::{KnownFormat, SceneSource};
use halfline_particles::particles::survey::{Pick, Survey};
use halfline_particles::select::{SelectedSpheres, apply};
use halfline_particles::spheres::SphereRows;
use halfline_particles::{csv, npy};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A table `[[spheres]]`.
pub(in crate::read) struct NamedSpheres {
    /// The file, from the folder of the scene file.
    pub(super) path: PathBuf,
    selection: Option<Selection>,
    /// The opacity of its spheres.
    pub(in crate::read) opacity: f32,
    /// The place of the file's name and of the selection.
    place: Place,
    selected_at: Place,
}

impl NamedSpheres {
    /// The table of a scene file at `scene`.
    ///
    /// # Errors
    /// [`Error::Scene`] for keys that are unknown, missing or of another type, for an expression that is not a
    /// selection, and for a file whose name has no supported extension.
    pub(super) fn of(table: &TomlTable<'_>, scene: &Path) -> Result<Self> {
        table.allow(&["file", "select", "opacity"])?;
        let file = table.need("file")?;
        let path = scene.parent().unwrap_or(Path::new("")).join(file.string()?);
        let chosen = table.get("select");
        let selected_at = chosen.map_or_else(|| file.place(), |value| value.place());
        let selection = chosen.map(|value| value.string()?.parse().map_err(|e| at(&selected_at, e))).transpose()?;
        let known = of_name(&unpacked(&path)).filter(|format| !format.is_of_scenes());
        if known.is_none() {
            let problem = format!("{} is not a supported file of spheres", quote(file.string()?));
            let mend = "use a .csv or .npy file, or a particle file such as .pdb or .xyz";
            return Err(Error::scene(file.place(), problem, mend));
        }
        Ok(Self { path, selection, opacity: table.opacity("spheres")?, place: file.place(), selected_at })
    }

    /// Appends the spheres with their opacity; returns messages about them.
    ///
    /// # Errors
    /// Errors of the file's reader and of the selection.
    pub(super) fn read(&self, spheres: &mut Spheres, watch: &Watch) -> Result<Vec<String>> {
        let first = spheres.len();
        let messages = self.shapes(spheres, watch)?;
        spheres.set_opacity_from(first, self.opacity);
        Ok(messages)
    }

    /// Appends the spheres; returns messages about them. Tables and arrays (.csv, .npy) have the columns of spheres; of
    /// other files the first frame is read, with the radii and colours of the file or of the elements.
    ///
    /// # Errors
    /// Errors of the file's reader and of the selection.
    fn shapes(&self, spheres: &mut Spheres, watch: &Watch) -> Result<Vec<String>> {
        let strict = match ending(&self.path).as_str() {
            "csv" => csv::read,
            "npy" => npy::read,
            _ => return self.particles(spheres, watch),
        };
        let Some(selection) = &self.selection else {
            return append_rows(spheres, |rows| strict(&self.path, rows, watch)).map(|()| Vec::new());
        };
        let mut part = SphereRows::default();
        strict(&self.path, &mut part, watch)?;
        let mut selected = SelectedSpheres::new(selection);
        append(spheres, &of_rows(selected.of(part).map_err(|e| at(&self.selected_at, e))?))?;
        Ok(selected.messages())
    }

    /// Whether the spheres have colours, by the head of the file where it says so.
    ///
    /// # Errors
    /// As [`NamedSpheres::read`].
    pub(in crate::read) fn is_colored(&self, watch: &Watch) -> Result<bool> {
        match ending(&self.path).as_str() {
            "csv" => csv::is_colored(&self.path, watch),
            "npy" => npy::is_colored(&self.path, watch),
            _ => {
                let mut spheres = Spheres::default();
                self.particles(&mut spheres, watch)?;
                Ok(spheres.colors.is_some())
            }
        }
    }

    /// Passes the spheres on, block by block; files other than tables and arrays are in memory as a whole. Returns messages about
    /// them.
    ///
    /// # Errors
    /// As [`NamedSpheres::read`]; [`Error::Settings`] for a selection that needs all spheres.
    pub(in crate::read) fn pass(&self, survey: &Survey, watch: &Watch) -> Result<Vec<String>> {
        let in_blocks = match ending(&self.path).as_str() {
            "csv" => csv::pass,
            "npy" => npy::pass,
            _ => {
                let mut spheres = Spheres::default();
                let messages = self.particles(&mut spheres, watch)?;
                return survey.take_spheres(&mut rows_of(spheres), true).map(|()| messages);
            }
        };
        let Some(selection) = &self.selection else {
            return in_blocks(&self.path, survey, watch).map(|()| Vec::new());
        };
        if let Some(word) = selection.word_for_several() {
            let problem = format!("{}: {STREAM}: `{word}` needs all spheres of the file in memory", self.selected_at);
            return Err(Error::settings(problem, format!("remove `{word}` there, or {STREAM}")));
        }
        let picked =
            Arc::new(Mutex::new(Picked { at: self.selected_at.clone(), selected: SelectedSpheres::new(selection) }));
        in_blocks(&self.path, &survey.picking(picked.clone()), watch)?;
        let picked = picked.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(picked.selected.messages())
    }

    fn particles(&self, spheres: &mut Spheres, watch: &Watch) -> Result<Vec<String>> {
        let select = self.selection.iter().cloned().collect();
        let particles = halfline_particles::ParticleOptions { select, watch: watch.clone(), ..Default::default() };
        let options = ReadOptions { particles, ..ReadOptions::default() };
        let source = SceneSource::open(&self.path, KnownFormat::Nothing, watch)?;
        let name = self.path.display().to_string();
        let Ok(mut frames) = open(source, &options.reading())? else {
            let problem = format!("{} is a scene, not a file of particles", quote(&name));
            return Err(Error::scene(self.place.clone(), problem, "use its spheres in this scene file"));
        };
        let Some(mut particles) = frames.next()? else {
            return Err(Error::scene(
                Place::file(name),
                "the file has no atoms or particles",
                "use a file with coordinates",
            ));
        };
        options.style.settle(&mut particles);
        let spaced = options.style.spaced(&particles);
        let notes = apply(&options.selections(), &mut particles).map_err(|e| at(&self.selected_at, e))?;
        particles.skipped.assumed.extend(notes.iter().map(ToString::to_string));
        let (part, skipped, _) = options.style.to_spheres(particles, spaced, &Place::file(name))?;
        append(spheres, &part)?;
        Ok(skipped.warnings())
    }
}

/// The selection of a table, for the blocks of its file.
#[derive(Debug)]
struct Picked {
    at: Place,
    selected: SelectedSpheres,
}

impl Pick for Picked {
    fn pick(&mut self, block: SphereRows) -> Result<SphereRows> {
        self.selected.of(block).map_err(|error| at(&self.at, error))
    }
}

/// The spheres of rows.
fn of_rows(SphereRows { centers, radii, colors }: SphereRows) -> Spheres {
    let colors = (!colors.is_empty()).then(|| colors.into());
    Spheres { centers: centers.into(), radii: radii.into(), colors, ..Spheres::default() }
}

/// The rows of spheres, without their materials and opacities.
pub(in crate::read) fn rows_of(spheres: Spheres) -> SphereRows {
    let Spheres { centers, radii, colors, .. } = spheres;
    SphereRows {
        centers: centers.into_vec(),
        radii: radii.into_vec(),
        colors: colors.map(List::into_vec).unwrap_or_default(),
    }
}

/// Appends the rows that `read` appends, in the same memory.
///
/// # Errors
/// Errors of `read`, which leave no spheres.
fn append_rows(spheres: &mut Spheres, read: impl FnOnce(&mut SphereRows) -> Result<()>) -> Result<()> {
    let before = spheres.len();
    let Spheres { centers, radii, colors, mut materials, mut opacities, cuts } = std::mem::take(spheres);
    let mut rows = SphereRows { centers: centers.into_vec(), radii: radii.into_vec(), colors: Vec::new() };
    read(&mut rows)?;
    let SphereRows { centers, radii, colors: mut new } = rows;
    let count = centers.len();
    let colors = if colors.is_some() || !new.is_empty() {
        let mut colors = colors.map_or_else(|| vec![DEFAULT_COLOR; before], List::into_vec);
        reserve(&mut colors, count - before)?;
        colors.append(&mut new);
        colors.resize(count, DEFAULT_COLOR);
        Some(colors.into())
    } else {
        None
    };
    if let Some(materials) = &mut materials {
        (before..count).for_each(|_| materials.push(Material::default()));
    }
    if let Some(opacities) = &mut opacities {
        opacities.to_mut().resize(count, 1.0);
    }
    *spheres = Spheres { centers: centers.into(), radii: radii.into(), colors, materials, opacities, cuts };
    Ok(())
}

fn append(spheres: &mut Spheres, more: &Spheres) -> Result<()> {
    let color = |n: usize| more.colors.as_ref().map(|colors| colors[n]);
    let all = more.centers.iter().zip(&more.radii).enumerate();
    all.into_iter().try_for_each(|(n, (center, radius))| spheres.add(*center, *radius, color(n)))
}

/// The path without the extension of a compression.
fn unpacked(path: &Path) -> PathBuf {
    if ["gz", "bz2"].contains(&ending(path).as_str()) { path.with_extension("") } else { path.to_path_buf() }
}

/// An error of a selection as one of the scene file.
fn at(place: &Place, error: Error) -> Error {
    match error {
        Error::Settings { problem, mend } => Error::scene(place.clone(), problem, mend),
        other => other,
    }
}
