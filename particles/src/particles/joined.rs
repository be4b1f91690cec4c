//! Frames with the atoms of another file, the topology: it gives the elements, radii, colours and columns that the frames lack.
//! Trajectories have positions only; LAMMPS dumps often lack all but the type.

use super::frame::{Column, ParticleFrames, Particles, of_rows};
use super::identity::{key, numbers};
use super::periodic::is_image;
use glam::{DMat3, DVec3};
use halfline_ground::Cell;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check;
use halfline_ground::quote::count;
use halfline_ground::quote::setting::TOPOLOGY;
use std::collections::HashMap;
use std::path::PathBuf;

/// The columns of frames that a topology may have too, where they belong to another moment.
const OWN: [&str; 15] = ["x", "y", "z", "xu", "yu", "zu", "xs", "ys", "zs", "xsu", "ysu", "zsu", "vx", "vy", "vz"];

/// The columns of a topology by which frames find its atoms: in LAMMPS and in PDB.
pub(crate) const NUMBERS: [&str; 2] = ["id", "serial"];

/// The atoms of a trajectory: their elements, radii, names and columns.
pub(crate) struct Topology {
    pub(crate) path: PathBuf,
    pub(crate) atoms: Particles,
}

/// The reader.
pub(crate) struct Joined {
    frames: Box<dyn ParticleFrames>,
    file: Place,
    topology: Topology,
    /// The column of the frames that identifies atoms; `None` takes the rows.
    identity: Option<String>,
    /// The rows of the topology by the numbers of their atoms, where it has them.
    rows: Option<HashMap<u64, u32>>,
    /// Whether the frames do not say where their cell begins.
    is_without_origin: bool,
    /// Whether the messages about the topology were reported, which are the same for all frames.
    has_reported: bool,
}

impl Joined {
    pub(crate) fn new(
        frames: Box<dyn ParticleFrames>,
        file: Place,
        topology: Topology,
        identity: Option<&str>,
        is_without_origin: bool,
    ) -> Self {
        let named = identity.and_then(|own| {
            std::iter::once(own).chain(NUMBERS).find_map(|name| numbers(&topology.atoms, name)).map(<[f64]>::to_vec)
        });
        let rows: Option<HashMap<u64, u32>> =
            named.map(|ids| ids.iter().enumerate().map(|(row, id)| (key(*id), row as u32)).collect());
        // Numbers that repeat, as the serials of several models do, identify nothing.
        let rows = rows.filter(|rows| rows.len() == topology.atoms.positions.len());
        let identity = identity.map(str::to_owned);
        Self { frames, file, topology, identity, rows, is_without_origin, has_reported: false }
    }

    /// The topology's row of each particle; `None` where it is the particle's own.
    fn find(&self, frame: &mut Particles) -> Result<Option<Vec<u32>>> {
        let atoms = &self.topology.atoms;
        let name = self.topology.path.display();
        let column = self.identity.as_deref().unwrap_or_default();
        if let (Some(rows), Some(ids)) = (&self.rows, numbers(frame, column)) {
            check(4 * ids.len() as u64, || format!("{} of a topology", count(ids.len() as u64, "row")))?;
            let row = |id: &f64| {
                rows.get(&key(*id)).copied().ok_or_else(|| {
                    Error::scene(
                        self.file.clone().named(column),
                        format!("there is a particle with the {column} {id}, and the topology {name} has none"),
                        format!("use the {TOPOLOGY} of these particles"),
                    )
                })
            };
            return ids.iter().map(row).collect::<Result<_>>().map(Some);
        }
        let (here, there) = (frame.positions.len(), atoms.positions.len());
        // The frame has the virtual sites that are left out of the topology.
        if here != there && atoms.listed == here && atoms.places.len() == there {
            frame.arrange(&atoms.places);
        } else if here != there {
            let all =
                if atoms.listed > there { format!(" ({} with virtual sites)", atoms.listed) } else { String::new() };
            let problem =
                format!("the trajectory has {}, the topology {name} has {there}{all}", count(here as u64, "atom"));
            return Err(Error::scene(
                self.file.clone().named("number of atoms"),
                problem,
                format!("use the {TOPOLOGY} of the atoms that the trajectory was written for"),
            ));
        }
        Ok(None)
    }

    /// Adds to a frame what it lacks.
    fn join(&self, frame: &mut Particles) -> Result<()> {
        let rows = self.find(frame)?;
        let rows = rows.as_deref();
        let atoms = &self.topology.atoms;
        let each = size_of::<[f64; 3]>() + 32 + atoms.columns.len() * size_of::<f64>();
        check((frame.positions.len() * each) as u64, || format!("{} atoms of a topology", frame.positions.len()))?;
        if frame.elements.iter().all(|element| *element == 0) {
            frame.elements = taken(&atoms.elements, rows);
            frame.unknown.clone_from(&atoms.unknown);
        }
        if frame.radii.is_empty() && !atoms.radii.is_empty() {
            frame.radii = taken(&atoms.radii, rows);
            frame.checked &= atoms.checked;
        }
        if frame.colors.is_empty() {
            frame.colors = taken(&atoms.colors, rows);
            frame.color_type = atoms.color_type;
        }
        if let (Some(cell), Some(of), true) = (&mut frame.cell, &atoms.cell, self.is_without_origin) {
            cell.origin = origin(&cell.edges, of);
        }
        let is_own = |name: &str| OWN.contains(&name) || is_image(name);
        let lacks = |name: &str| !is_own(name) && !frame.has.iter().any(|known| known.eq_ignore_ascii_case(name));
        let columns = atoms.columns.iter().filter(|column| lacks(&column.name));
        let columns: Vec<Column> =
            columns.map(|column| Column { name: column.name.clone(), values: taken(&column.values, rows) }).collect();
        let names: Vec<String> = atoms.has.iter().filter(|name| lacks(name)).cloned().collect();
        let labels = |column: &Column| Some((column.name.clone(), atoms.labels.get(&column.name)?.clone()));
        frame.labels.extend(columns.iter().filter_map(labels));
        frame.columns.extend(columns);
        frame.has.extend(names);
        Ok(())
    }
}

/// The origin of a cell that changes from another one with all that it holds: the point at 0 keeps its fractions.
fn origin(edges: &[[f64; 3]; 3], of: &Cell) -> [f64; 3] {
    let parts = DMat3::from_cols_array_2d(&of.edges).inverse() * DVec3::from_array(of.origin);
    let moved = (DMat3::from_cols_array_2d(edges) * parts).to_array();
    if of.origin == [0.0; 3] || !moved.iter().all(|x| x.is_finite()) || *edges == of.edges { of.origin } else { moved }
}

/// The values of these rows; `None` are all.
fn taken<T: Copy>(values: &[T], rows: Option<&[u32]>) -> Vec<T> {
    rows.map_or_else(|| values.to_vec(), |rows| of_rows(values, rows))
}

impl ParticleFrames for Joined {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(mut frame) = self.frames.next()? else { return Ok(None) };
        self.join(&mut frame)?;
        if !self.has_reported {
            self.has_reported = true;
            frame.skipped.append(self.topology.atoms.skipped.clone());
        }
        Ok(Some(frame))
    }

    fn skip(&mut self) -> Result<bool> {
        self.frames.skip()
    }
}
