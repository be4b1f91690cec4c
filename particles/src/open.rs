//! Opens a file of particles with the reader of its format.

use super::format::{Format, Has};
use super::frame_range::FrameRange;
use super::opened::SceneSource;
use super::options::ParticleOptions;
use super::particles::added::Added;
use super::particles::frame::{ParticleFrames, Particles};
use super::particles::identity::{self, Ordered};
use super::particles::joined::{Joined, NUMBERS, Topology};
use super::particles::request::{Altloc, Request};
use super::source::Source;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::setting::{
    ADD, ALTLOC, AS_LISTED, ASSEMBLY, AT, ATOM_STYLE, COLOR, COLUMNS, FOCUS, FORMAT, FRAMES, HIDE, MODEL, RADIUS,
    SELECT, STREAM, TOPOLOGY,
};
use std::path::{Path, PathBuf};

/// The frames of a particle file, with the atoms of the topology and in the order of the first one; `None` for formats that
/// contain a whole scene.
pub fn open(source: SceneSource, options: &ParticleOptions) -> Result<Result<Box<dyn ParticleFrames>, SceneSource>> {
    if options.as_operators && options.assembly.is_some() {
        check_operators(options)?;
    }
    let (path, format) = (source.path.clone(), source.format);
    let file = Place::file(path.display().to_string());
    let added = options.added.iter().map(|name| added(name, &path, options)).collect::<Result<Vec<_>>>()?;
    let topology = options.topology.as_deref().map(|name| topology(name, &path, options)).transpose()?;
    let identity = options.identifying(format);
    let mut frames = match listed(source, options.request(format), options)? {
        Ok(frames) => frames,
        Err(source) if topology.is_some() => {
            let problem = format!("{} files contain whole scenes and take no topology", source.format.name());
            return Err(Error::settings(problem, format!("remove {TOPOLOGY}, or read a file of particles")));
        }
        Err(source) if !added.is_empty() => return Err(scene_of_several(source.format, &path)),
        Err(source) => return Ok(Err(source)),
    };
    if let Some(topology) = topology {
        frames = Box::new(Joined::new(frames, file.clone(), topology, identity, format.has(Has::PositionsOnly)));
    }
    if identity.is_some() {
        // The frames that are read have the order of one that is not.
        let first = if options.frames.contains(1) { None } else { first_ids(&path, options) };
        frames = Box::new(Ordered::new(frames, file, options.identity.clone(), first));
    }
    if !added.is_empty() {
        let files = std::iter::once((path, frames)).chain(added).collect();
        frames = Box::new(Added::new(files, options.periodic, options.frames.last() > 1));
    }
    Ok(Ok(frames))
}

/// The frames of a file that is read with another one: its format is detected, and options that the format does not have are left to
/// files that have them.
fn added(path: &Path, first: &Path, options: &ParticleOptions) -> Result<(PathBuf, Box<dyn ParticleFrames>)> {
    if path == Path::new("-") && (first == path || options.added.iter().filter(|name| *name == path).count() > 1) {
        let problem = "two files cannot both come from standard input";
        return Err(Error::settings(problem, format!("name the file of {ADD}")));
    }
    let plain = ParticleOptions { format: None, topology: None, added: Vec::new(), survey: None, ..options.clone() };
    let source = SceneSource::open(path, plain.known_format(), &plain.watch)?;
    let format = source.format;
    let own = ParticleOptions {
        columns_named: if format.has(Has::NamedColumns) { plain.columns_named.clone() } else { Default::default() },
        atom_style: plain.atom_style.clone().filter(|_| format.has(Has::AtomStyles)),
        assembly: plain.assembly.clone().filter(|_| format.has(Has::Assemblies)),
        model: plain.model.filter(|_| format.has(Has::Models)),
        as_listed: plain.as_listed && format.has(Has::Symmetry),
        altloc: if format.has(Has::AlternateLocations) { plain.altloc.clone() } else { Altloc::All },
        ..plain
    };
    match open(source, &own)? {
        Ok(frames) => Ok((path.to_path_buf(), frames)),
        Err(_) => Err(scene_of_several(format, path)),
    }
}

/// The error for a file with a whole scene among several.
fn scene_of_several(format: Format, path: &Path) -> Error {
    let problem = format!("{} is a whole scene ({}), and {ADD} reads particles", path.display(), format.name());
    Error::settings(problem, "use files of particles, or [[spheres]] tables with file = \"...\" in a scene file")
}

/// Refuses what needs all atoms of an assembly.
fn check_operators(options: &ParticleOptions) -> Result<()> {
    if !options.added.is_empty() {
        let problem = format!("{STREAM}: {ADD} needs all atoms of an assembly in memory");
        return Err(Error::settings(problem, format!("remove {ADD}, or {STREAM}")));
    }
    if options.all_selections().next().is_none() {
        return Ok(());
    }
    let problem = format!("{STREAM}: selections need all atoms of an assembly in memory");
    Err(Error::settings(
        problem,
        format!("remove selections ({SELECT}, {HIDE}, {AT}, {FOCUS}, and in {COLOR} and {RADIUS}), or {STREAM}"),
    ))
}

/// The numbers of the particles of the file's first frame; `None` where it cannot be read again, or has none.
fn first_ids(path: &Path, options: &ParticleOptions) -> Option<Vec<f64>> {
    if !path.is_file() {
        return None;
    }
    let column = options.identity.column()?;
    let source = SceneSource::open(path, options.known_format(), &options.watch).ok()?;
    let request = Request { columns: vec![column.to_owned()], ..options.request(source.format) };
    let frame = listed(source, request, options).ok()?.ok()?.next().ok()??;
    identity::numbers(&frame, column).map(<[f64]>::to_vec)
}

/// The frames of a particle file as it has them; `None` for formats that contain a whole scene.
pub fn listed(
    source: SceneSource,
    request: Request,
    options: &ParticleOptions,
) -> Result<Result<Box<dyn ParticleFrames>, SceneSource>> {
    let format = source.format;
    if !options.columns_named.is_empty() && !format.has(Has::NamedColumns) {
        let problem = format!("{COLUMNS} names the columns of tables, but the file is {}", format.name());
        return Err(Error::settings(problem, format!("remove it, or add {FORMAT} csv if the file is a table")));
    }
    if options.topology.is_none() {
        check(format, &request)?;
    }
    if format.has(Has::AnyColumns) {
        options.check_columns()?;
    }
    let SceneSource { reader, path, warning, .. } = source;
    Ok(match (format.frames(Source { reader, path }, request, options.topology.is_some())?, warning) {
        (Err(Source { reader, path }), warning) => Err(SceneSource { reader, path, format, warning }),
        (Ok(frames), None) => Ok(frames),
        (Ok(frames), warning) => Ok(Box::new(Noted { frames, warning })),
    })
}

/// Returns an error for options that a format does not have.
///
/// # Errors
/// [`Error::Settings`] with the option to remove.
fn check(format: Format, request: &Request) -> Result<()> {
    let requests = [
        (request.atom_style.is_some(), Has::AtomStyles, "atom styles", format!("remove {ATOM_STYLE}")),
        (request.assembly.is_some(), Has::Assemblies, "biological assemblies", format!("remove {ASSEMBLY}")),
        (
            request.model.is_some(),
            Has::Models,
            "numbered models",
            format!("remove {MODEL}, or use {FRAMES}, which counts from 1"),
        ),
        (request.as_listed, Has::Symmetry, "symmetry of crystals", format!("remove {AS_LISTED}")),
        (request.altloc != Altloc::All, Has::AlternateLocations, "alternate locations", format!("remove {ALTLOC}")),
    ];
    match requests.into_iter().find(|(is_requested, property, ..)| *is_requested && !format.has(*property)) {
        Some((_, _, what, mend)) => Err(Error::settings(format!("{} files have no {what}", format.name()), mend)),
        None => Ok(()),
    }
}

/// The frames of a file with a warning, which the first frame that is read carries.
struct Noted {
    frames: Box<dyn ParticleFrames>,
    warning: Option<String>,
}

impl ParticleFrames for Noted {
    fn next(&mut self) -> Result<Option<Particles>> {
        let mut frame = self.frames.next()?;
        if let Some(frame) = &mut frame {
            frame.skipped.assumed.extend(self.warning.take());
        }
        Ok(frame)
    }

    fn skip(&mut self) -> Result<bool> {
        self.frames.skip()
    }
}

/// The first frame of the file with the atoms of a trajectory.
fn topology(path: &Path, trajectory: &Path, options: &ParticleOptions) -> Result<Topology> {
    let name = path.display();
    let unfit = |problem: String| {
        Err(Error::settings(problem, "use a particle file with the atoms of the trajectory, such as PDB or GRO"))
    };
    if path == Path::new("-") && trajectory == path {
        return unfit("the trajectory and its topology cannot both come from standard input".into());
    }
    let options =
        ParticleOptions { topology: None, format: None, frames: FrameRange::first(), survey: None, ..options.clone() };
    let source = SceneSource::open(path, options.known_format(), &options.watch)?;
    if source.format.has(Has::PositionsOnly) {
        return unfit(format!("the topology {name} is a trajectory, which has positions only"));
    }
    // Frames find its atoms by these.
    let mut request = options.request(source.format);
    if source.format.has(Has::AnyColumns) {
        request.columns.extend(options.identity.column().into_iter().chain(NUMBERS).map(str::to_owned));
    } else if source.format.has(Has::Serials) {
        request.columns.push("serial".to_owned());
    }
    match listed(source, request, &options)? {
        Ok(mut frames) => match frames.next()? {
            Some(atoms) => Ok(Topology { path: path.to_path_buf(), atoms }),
            None => unfit(format!("the topology {name} has no atoms")),
        },
        Err(_) => unfit(format!("the topology {name} is a scene, not a particle file")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_molecules_are_refused_for_other_formats() {
        let plain = Request::default();
        for (options, word) in [
            (Request { assembly: Some("1".into()), ..plain.clone() }, ASSEMBLY),
            (Request { model: Some(1), ..plain.clone() }, MODEL),
            (Request { altloc: Altloc::Highest, ..plain.clone() }, ALTLOC),
            (Request { as_listed: true, ..plain.clone() }, AS_LISTED),
        ] {
            for format in Format::ALL {
                let known = match format.name() {
                    "cif" => true,
                    "pdb" => word != AS_LISTED,
                    "pdbqt" => [MODEL, ALTLOC].contains(&word),
                    _ => false,
                };
                let found = check(format, &options);
                assert_eq!(found.is_ok(), known, "{format:?} {word}");
                assert!(found.is_ok() || found.is_err_and(|error| error.to_string().contains(word)));
                check(format, &plain).expect("no option is set");
            }
        }
    }

    #[test]
    fn selections_are_refused_where_an_assembly_is_operators() {
        let select = vec!["chain A".parse().expect("a selection")];
        let options =
            ParticleOptions { as_operators: true, assembly: Some("1".into()), select, ..ParticleOptions::default() };
        let open = |options: &ParticleOptions| {
            let text = "ATOM      1  N   MET A   1      27.340  24.430   2.614\n";
            crate::Frames::from_reader(text.as_bytes(), Path::new("a.pdb"), options).map(drop)
        };
        let error = open(&options).expect_err("a selection").to_string();
        assert!(error.contains("selections need all atoms"), "{error}");
        open(&ParticleOptions { select: Vec::new(), ..options.clone() }).expect("no selection");
        let added = ParticleOptions { select: Vec::new(), added: vec!["b.pdb".into()], ..options };
        let error = open(&added).expect_err("another file").to_string();
        assert!(error.contains("needs all atoms"), "{error}");
    }
}
