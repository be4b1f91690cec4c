use super::*;
use halfline_ground::Cell;

fn particles(positions: &[[f64; 3]], cell: Option<Cell>) -> Particles {
    Particles { positions: positions.to_vec(), cell, ..Particles::default() }
}

fn column(particles: &Particles, name: &str) -> Result<Vec<f64>> {
    let mut particles = particles.clone();
    add(&mut particles, &[name.to_owned()])?;
    Ok(particles.columns.pop().expect("a column").values)
}

/// All pairs, all images, by squares.
fn by_all_pairs(particles: &Particles, reach: f64) -> Vec<f64> {
    let edges = particles.cell.map_or([[0.0; 3]; 3], |cell| cell.edges);
    let steps = |k: usize| {
        let most = if edges[k] == [0.0; 3] || particles.open_edges[k] { 0 } else { 4 };
        (-most..=most).map(f64::from)
    };
    let shifts: Vec<[f64; 3]> = steps(0)
        .flat_map(|a| steps(1).flat_map(move |b| steps(2).map(move |c| [a, b, c])))
        .map(|[a, b, c]| [0, 1, 2].map(|k| a * edges[0][k] + b * edges[1][k] + c * edges[2][k]))
        .collect();
    let near = |a: &[f64; 3], b: &[f64; 3], shift: &[f64; 3]| {
        (0..3).map(|k| (b[k] + shift[k] - a[k]).powi(2)).sum::<f64>() <= reach * reach
    };
    let of = |a: &[f64; 3]| {
        let all = particles.positions.iter().flat_map(|b| shifts.iter().map(move |shift| (b, shift)));
        all.filter(|(b, shift)| near(a, b, shift)).count() as f64 - 1.0
    };
    particles.positions.iter().map(of).collect()
}

/// Positions and edges in eighths, so that all squares are exact, and many distances equal the reach.
#[test]
fn neighbours_are_those_of_all_pairs() {
    let mut state = 3_u64;
    let mut next = |range: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % range) as f64 / 8.0
    };
    let tilted = Cell { origin: [-1.0, 0.5, 0.0], edges: [[4.0, 0.0, 0.0], [1.0, 4.0, 0.0], [-1.0, 0.5, 4.0]] };
    let plane = Cell { origin: [0.0; 3], edges: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0; 3]] };
    for cell in [None, Some(tilted), Some(plane)] {
        let positions: Vec<[f64; 3]> = (0..80).map(|_| [next(32), next(32), next(32)]).collect();
        let inside = |p: &[f64; 3]| cell.is_none_or(|cell| cell.edges[2] != [0.0; 3] || p[2] < 4.0);
        let positions: Vec<_> = positions.into_iter().filter(inside).collect();
        for open_edges in [[false; 3], [true, false, true]] {
            let of = Particles { open_edges, ..particles(&positions, cell) };
            for reach in [0.125, 1.0, 1.5, 3.0, 9.0] {
                let expected = by_all_pairs(&of, reach);
                let found = column(&of, &format!("coordination:{reach}")).expect("neighbours");
                assert_eq!(found, expected, "{reach}, {cell:?}, {open_edges:?}");
                let volume = 4.0 / 3.0 * PI * reach.powi(3);
                let dense: Vec<f64> = expected.iter().map(|count| (count + 1.0) / volume).collect();
                assert_eq!(column(&of, &format!("Density:{reach}")).expect("a density"), dense);
            }
        }
    }
}

#[test]
fn crystals_have_the_coordination_of_their_lattice() {
    // One atom, whose neighbours are its images: simple cubic has 6, then 12 more, then 8; close packing has 12.
    let cube = Cell { origin: [0.0; 3], edges: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };
    let packed = Cell { origin: [0.0; 3], edges: [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]] };
    for (cell, reach, expected) in [(cube, 1.0, 6.0), (cube, 1.5, 18.0), (cube, 1.75, 26.0), (packed, 1.5, 12.0)] {
        let found = column(&particles(&[[0.25, 7.5, -3.0]], Some(cell)), &format!("coordination:{reach}"));
        assert_eq!(found.expect("neighbours"), [expected]);
    }
    let many = column(&particles(&[[0.0; 3]], Some(cube)), "coordination:60");
    assert!(many.expect_err("too many").to_string().contains("50 periodic cells"));
}

#[test]
fn a_column_of_the_file_comes_first_and_a_distance_is_needed() {
    let own = Particles {
        columns: vec![Column { name: "density".into(), values: vec![7.0] }],
        ..particles(&[[0.0; 3]], None)
    };
    assert_eq!(column(&own, "density").expect("the file's"), [7.0]);
    for name in ["coordination", "density:", "coordination:-1", "density:inf", "coordination:x"] {
        let error = column(&particles(&[[0.0; 3]], None), name).expect_err(name).to_string();
        assert!(error.contains("no distance") && error.contains(":3.5"), "{error}");
    }
    assert!(
        column(&particles(&[[0.0; 3]], None), "spectrum").expect_err("no residues").to_string().contains("residues")
    );
}

#[test]
fn a_spectrum_is_the_place_of_residues_in_their_chain() {
    // Three residues in chain A, one of them with two atoms, a water of it, and one residue in chain B.
    let numbers = |name: &str, values: &[f64]| Column { name: name.into(), values: values.to_vec() };
    let mut of = particles(&[[0.0; 3]; 6], None);
    of.columns = vec![
        numbers("residue", &[5.0, 5.0, 6.0, 7.0, 8.0, 1.0]),
        numbers("chain", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        numbers("resname", &[0.0, 0.0, 0.0, 1.0, 2.0, 0.0]),
    ];
    of.labels.insert("resname".into(), ["ALA", "DG", "HOH"].map(String::from).to_vec());
    let found = column(&of, "spectrum").expect("places");
    assert_eq!((&found[..4], found[5]), (&[0.0, 0.0, 0.5, 1.0][..], 0.0));
    assert!(found[4].is_nan(), "water is no polymer");
}

#[test]
fn distances_are_from_the_mean_of_all() {
    let far = 1e9;
    let of = particles(&[[far, 0.0, 0.0], [far + 3.0, 0.0, 0.0], [far, 3.0, 0.0], [far + 3.0, 3.0, 6.0]], None);
    // The mean is (1.5, 1.5, 1.5) from the first.
    let [near, top] = [6.75_f64.sqrt(), 24.75_f64.sqrt()];
    assert_eq!(column(&of, "Distance").expect("distances"), [near, near, near, top]);
    assert_eq!(column(&particles(&[], None), "distance").expect("none"), [0.0; 0]);
    let own = Column { name: "distance".into(), values: vec![7.0; 4] };
    let mut known = Particles { columns: vec![own.clone()], ..of };
    add(&mut known, &["distance".to_owned()]).expect("its own");
    assert_eq!(known.columns, [own]);
}
