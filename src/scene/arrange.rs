//! Arranges spheres between reading and rendering: periodic copies, clip planes, the outline of the cell.

use super::instances::{Instances, Lattice, is_kept};
use super::{Cell, List, Material, Materials, Spheres};
use glam::DVec3;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::{check, check_spheres, extend_to};
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::progress::Watch;

/// Copies, clip planes and outline, applied in this order.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrangement {
    /// Copies along each edge of the cell, the original included.
    pub copies: [u32; 3],
    /// Half spaces whose spheres are kept: those whose centre c has n.c <= d, given as n and d.
    pub clip: Vec<[f64; 4]>,
    /// Radius of the beads that draw the edges of the cell (of all its copies together); `None` draws none.
    pub outline: Option<Bead>,
}

/// Thickness of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bead {
    /// A 500th of the longest diagonal of the outlined box.
    Thin,
    /// This radius.
    Radius(f64),
}

impl Default for Arrangement {
    /// No change.
    fn default() -> Self {
        Self { copies: [1; 3], clip: Vec::new(), outline: None }
    }
}

/// The most beads along an edge. They overlap by half, so that an edge looks like a wire.
const MAX_BEADS: f64 = 1e5;

/// Colour of an outline, linear RGB, visible on black and on white.
const OUTLINE: [f32; 3] = [0.35; 3];

impl Arrangement {
    /// Arranges spheres. Ids count the spheres in their order, copy after copy (the first edge's fastest), without the
    /// clipped ones; then the beads.
    ///
    /// # Errors
    /// [`Error::Settings`] where copies or an outline need a cell and there is none, or a bead has no radius;
    /// [`Error::Limits`] where the copies do not fit into memory; [`Error::Interrupted`].
    pub fn apply(&self, spheres: &mut Spheres, cell: Option<&Cell>, watch: &Watch) -> Result<()> {
        let need = |what: &str| cell.ok_or_else(|| needs_cell(what));
        if self.copies != [1; 3] {
            let lattice = self.lattice(Some(need("copies")?))?;
            // Copies of no spheres are no spheres.
            if !spheres.is_empty() {
                repeat(spheres, &lattice, watch)?;
            }
        }
        for plane in &self.clip {
            watch.check()?;
            clip(spheres, *plane)?;
        }
        if let Some(bead) = self.outline {
            let cell = need("drawing the cell")?;
            let mut whole = cell.edges.map(DVec3::from_array);
            whole.iter_mut().zip(self.copies).for_each(|(edge, n)| *edge *= f64::from(n));
            outline(spheres, DVec3::from_array(cell.origin), whole, bead)?;
        }
        Ok(())
    }

    /// The spheres that [`Arrangement::apply`] makes of `spheres`, in their order: for each the index of the one that it is a
    /// copy of. The beads of an outline follow them and are left out.
    ///
    /// # Errors
    /// [`Error::Settings`] where copies need a cell and there is none; [`Error::Limits`], [`Error::Interrupted`].
    pub fn rows(&self, spheres: &Spheres, cell: Option<&Cell>, watch: &Watch) -> Result<Vec<u32>> {
        let lattice = self.lattice(cell)?;
        let total = lattice.count().saturating_mul(spheres.len() as u64);
        check(total.saturating_mul(2 * size_of::<u32>() as u64), || format!("the rows of {total} spheres"))?;
        let mut rows = Vec::new();
        for copy in 0..lattice.count() {
            watch.check()?;
            let stays = self.stays(&lattice, copy);
            rows.extend(parallel::collect(spheres.len(), CHEAP, &|range, rows| {
                rows.extend(range.filter(|row| stays(&spheres.centers[*row])).map(|row| row as u32));
            }));
        }
        Ok(rows)
    }

    /// Whether the clip planes keep a copy of a centre.
    fn stays(&self, lattice: &Lattice, copy: u64) -> impl Fn(&[f64; 3]) -> bool {
        let shift = lattice.shift(lattice.place(copy));
        move |center| self.clip.iter().all(|plane| is_kept(*plane, DVec3::from_array(*center) + shift))
    }

    /// The copies of `spheres` that the clip planes keep, numbered as by [`Arrangement::apply`], without holding them in
    /// memory. The outline is left out.
    ///
    /// # Errors
    /// [`Error::Settings`] where copies need a cell and there is none; errors of [`Instances`].
    pub fn copies(&self, spheres: &Spheres, cell: Option<&Cell>) -> Result<Instances> {
        Instances::along(spheres.clone(), self.lattice(cell)?, &self.clip)
    }

    /// The lattice of the copies: their number along each edge, and the edges of the cell; edges of length 0 for a
    /// single copy without a cell.
    fn lattice(&self, cell: Option<&Cell>) -> Result<Lattice> {
        let edges = match cell {
            Some(cell) => cell.edges.map(DVec3::from_array),
            None if self.copies == [1; 3] => [DVec3::ZERO; 3],
            None => return Err(needs_cell("copies")),
        };
        Ok(Lattice { copies: self.copies, edges })
    }

    /// Whether the clip planes remove every copy of every sphere, and no outline is drawn; `false` where there are no
    /// spheres.
    ///
    /// # Errors
    /// As [`Arrangement::apply`] for copies that do not fit into memory; [`Error::Interrupted`].
    pub fn leaves_nothing(&self, spheres: &Spheres, cell: Option<&Cell>, watch: &Watch) -> Result<bool> {
        if self.clip.is_empty() || self.outline.is_some() || spheres.is_empty() {
            return Ok(false);
        }
        let Ok(lattice) = self.lattice(cell) else { return Ok(false) };
        check_spheres(lattice.count().saturating_mul(spheres.len() as u64), spheres.colors.is_some())?;
        for copy in 0..lattice.count() {
            watch.check()?;
            let stays = self.stays(&lattice, copy);
            if parallel::any(spheres.len(), CHEAP, &|range| spheres.centers[range].iter().any(&stays)) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

fn needs_cell(what: &str) -> Error {
    Error::settings(
        format!("{what} needs a periodic cell, but the file has none"),
        "use a file with a cell: Lattice, CRYST1, BOX BOUNDS, a box line",
    )
}

/// Spheres copied between two checks for cancellation.
const SPHERES_PER_CHECK: usize = 1 << 22;

fn repeat(spheres: &mut Spheres, lattice: &Lattice, watch: &Watch) -> Result<()> {
    let total = lattice.count().saturating_mul(spheres.len() as u64);
    check_spheres(total, spheres.colors.is_some())?;
    let (own, total) = (std::mem::take(spheres), total as usize);
    let copy = |at: usize| {
        let (sphere, copy) = (at % own.len(), at / own.len());
        (DVec3::from_array(own.centers[sphere]) + lattice.shift(lattice.place(copy as u64))).to_array()
    };
    let centers = spheres.centers.to_mut();
    extend_to(centers, total)?;
    for start in (0..total).step_by(SPHERES_PER_CHECK) {
        watch.check()?;
        let more = total.min(start + SPHERES_PER_CHECK) - start;
        centers.extend(parallel::from_fn(more, |n| copy(start + n)));
    }
    spheres.radii = repeated(own.radii, total, watch)?;
    spheres.materials = own
        .materials
        .map(|Materials { kinds, of }| Ok(Materials { kinds, of: repeated(of, total, watch)? }))
        .transpose()?;
    spheres.opacities = own.opacities.map(|opacities| repeated(opacities, total, watch)).transpose()?;
    spheres.colors = own.colors.map(|colors| repeated(colors, total, watch)).transpose()?;
    Ok(())
}

/// The values repeated to a length of `total`.
fn repeated<T: Copy>(values: List<T>, total: usize, watch: &Watch) -> Result<List<T>> {
    let mut values = values.into_vec();
    extend_to(&mut values, total)?;
    let once = values.len();
    while values.len() < total {
        watch.check()?;
        // Whole copies of all values, so that the next copy begins with the first.
        let more = values.len().min((SPHERES_PER_CHECK / once).max(1) * once).min(total - values.len());
        values.extend_from_within(..more);
    }
    Ok(values.into())
}

fn clip(spheres: &mut Spheres, plane: [f64; 4]) -> Result<()> {
    check(spheres.len() as u64, || format!("a clip plane for {} spheres", spheres.len()))?;
    let kept = parallel::map(&spheres.centers, |c| is_kept(plane, DVec3::from_array(*c)));
    spheres.keep(&kept);
    Ok(())
}

fn outline(spheres: &mut Spheres, origin: DVec3, edges: [DVec3; 3], bead: Bead) -> Result<()> {
    let diagonal = (edges[0] + edges[1] + edges[2]).length();
    let radius = match bead {
        Bead::Thin => diagonal / 500.0,
        Bead::Radius(radius) => radius,
    };
    if !(radius > 0.0 && radius.is_finite()) {
        let problem = format!("the beads of the cell have the radius {radius}");
        return Err(Error::settings(problem, "use a positive radius"));
    }
    // Shared spheres are copied before beads are added.
    check_spheres(spheres.len() as u64, spheres.colors.is_some())?;
    for (k, along) in edges.into_iter().enumerate() {
        let (p, q) = (edges[(k + 1) % 3], edges[(k + 2) % 3]);
        let steps = (along.length() / radius).ceil().clamp(1.0, MAX_BEADS) as u32;
        for corner in [DVec3::ZERO, p, q, p + q] {
            // An edge omits its last bead where the next edge's first bead is: every corner begins or ends three edges.
            for n in 0..=steps {
                let at = origin + corner + along * (f64::from(n) / f64::from(steps));
                spheres.add(at.to_array(), radius, Some(OUTLINE))?;
                spheres.set_last_material(Material::Ink);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: Cell = Cell { origin: [1.0, 0.0, 0.0], edges: [[2.0, 0.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 4.0]] };

    fn two() -> Spheres {
        let mut spheres = Spheres::default();
        spheres.push([0.0; 3], 0.5, None);
        spheres.push([1.0, 1.0, 1.0], 0.25, Some([1.0, 0.0, 0.0]));
        spheres
    }

    #[test]
    fn copies_follow_the_edges_of_the_cell() {
        let mut spheres = two();
        let copies = Arrangement { copies: [2, 1, 3], ..Arrangement::default() };
        copies.apply(&mut spheres, Some(&CELL), &Watch::default()).expect("copies");
        assert_eq!((spheres.len(), spheres.radii.len()), (12, 12));
        assert_eq!((spheres.centers[2], spheres.centers[5]), ([2.0, 0.0, 0.0], [1.0, 1.0, 5.0]));
        assert_eq!(spheres.colors.expect("colours")[11], [1.0, 0.0, 0.0]);
        copies.apply(&mut two(), None, &Watch::default()).expect_err("no cell");
        let many = Arrangement { copies: [1 << 20, 1 << 20, 1 << 20], ..copies };
        assert!(matches!(many.apply(&mut two(), Some(&CELL), &Watch::default()), Err(Error::Limits { .. })));
    }

    #[test]
    fn copies_of_no_spheres_are_none_and_copying_can_be_cancelled() {
        let cancelled = Watch::default().while_true(|| false);
        let many = Arrangement { copies: [100_000; 3], ..Arrangement::default() };
        many.apply(&mut Spheres::default(), Some(&CELL), &cancelled).expect("nothing to do");
        let some = Arrangement { copies: [2; 3], ..Arrangement::default() };
        assert!(matches!(some.apply(&mut two(), Some(&CELL), &cancelled), Err(Error::Interrupted)));
    }

    #[test]
    fn copies_of_more_than_a_batch_are_those_of_less() {
        // Three numbers, so that the end of a batch falls among them, and a list whose doubling does not end with a
        // whole copy.
        let values: List<usize> = (0..3).collect();
        let all = repeated(values, 3 * (SPHERES_PER_CHECK - 1), &Watch::default()).expect("room");
        assert!(all.len() == 3 * (SPHERES_PER_CHECK - 1) && all.iter().enumerate().all(|(k, n)| *n == k % 3));
    }

    #[test]
    fn planes_keep_centres_on_their_side() {
        let mut spheres = two();
        let clip = Arrangement { clip: vec![[1.0, 0.0, 0.0, 0.5]], ..Arrangement::default() };
        clip.apply(&mut spheres, None, &Watch::default()).expect("no cell is needed");
        assert_eq!((spheres.len(), spheres.radii[0], spheres.colors.map(|c| c.len())), (1, 0.5, Some(1)));
    }

    #[test]
    fn what_is_clipped_away_is_known_before() {
        // The copies of the centre 0, 0, 0 along the first edge are at 2 and 4, the copies of 1, 1, 1 at 3 and 5.
        for (copies, clip, bead, nothing) in [
            ([1; 3], vec![[1.0, 0.0, 0.0, -1.0]], None, true),
            ([1; 3], vec![[1.0, 0.0, 0.0, 0.0]], None, false),
            ([1; 3], vec![[-1.0, 0.0, 0.0, -0.5], [0.0, 1.0, 0.0, 0.5]], None, true),
            ([1; 3], vec![[1.0, 0.0, 0.0, -1.0]], Some(Bead::Thin), false),
            ([1; 3], Vec::new(), None, false),
            ([3, 1, 1], vec![[-1.0, 0.0, 0.0, -5.0]], None, false),
            ([3, 1, 1], vec![[-1.0, 0.0, 0.0, -5.5]], None, true),
        ] {
            let arrangement = Arrangement { copies, clip, outline: bead };
            let found = arrangement.leaves_nothing(&two(), Some(&CELL), &Watch::default()).expect("room");
            assert_eq!(found, nothing, "{arrangement:?}");
            let mut spheres = two();
            arrangement.apply(&mut spheres, Some(&CELL), &Watch::default()).expect("room");
            assert_eq!(spheres.is_empty(), nothing, "{arrangement:?}");
        }
        let far = Arrangement { clip: vec![[1.0, 0.0, 0.0, -1.0]], ..Arrangement::default() };
        assert!(far.leaves_nothing(&two(), None, &Watch::default()).expect("no cell is needed"));
        assert!(!far.leaves_nothing(&Spheres::default(), None, &Watch::default()).expect("no spheres"));
        let many = Arrangement { copies: [1 << 20; 3], ..far };
        assert!(matches!(many.leaves_nothing(&two(), Some(&CELL), &Watch::default()), Err(Error::Limits { .. })));
    }

    #[test]
    fn rows_are_the_spheres_that_copies_are_made_of() {
        for (copies, clip) in [
            ([1; 3], Vec::new()),
            ([2, 1, 3], Vec::new()),
            ([1; 3], vec![[1.0, 0.0, 0.0, 0.5]]),
            ([3, 2, 1], vec![[-1.0, 0.0, 0.0, -3.0], [0.0, 1.0, 0.0, 3.5]]),
        ] {
            let arrangement = Arrangement { copies, clip, outline: None };
            // The radius of each sphere says which one it is a copy of.
            let mut spheres = two();
            let rows = arrangement.rows(&spheres, Some(&CELL), &Watch::default()).expect("room");
            let radii = spheres.radii.to_vec();
            arrangement.apply(&mut spheres, Some(&CELL), &Watch::default()).expect("room");
            let expected: Vec<f64> = rows.iter().map(|row| radii[*row as usize]).collect();
            assert_eq!(spheres.radii.to_vec(), expected, "{arrangement:?}");
        }
    }

    #[test]
    fn an_outline_reaches_every_corner() {
        let mut spheres = two();
        let outline = Arrangement { outline: Some(Bead::Radius(0.1)), copies: [1, 2, 1], ..Arrangement::default() };
        outline.apply(&mut spheres, Some(&CELL), &Watch::default()).expect("a cell");
        for corner in [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 6.0, 0.0], [5.0, 6.0, 4.0]] {
            assert!(spheres.centers[4..].contains(&corner), "{corner:?}");
        }
        // Shared spheres are copied, and the others stay as they are.
        let mut shared = two();
        shared.share();
        let others = shared.clone();
        outline.apply(&mut shared, Some(&CELL), &Watch::default()).expect("a cell");
        assert!(shared.len() > 4 && others.len() == 2);
        let none = Arrangement { outline: Some(Bead::Radius(0.0)), ..Arrangement::default() };
        none.apply(&mut spheres, Some(&CELL), &Watch::default()).expect_err("no bead");
    }
}
