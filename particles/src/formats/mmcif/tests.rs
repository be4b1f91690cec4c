use super::*;
use crate::particles::request::Altloc;
use halfline_ground::quote::setting;

fn options(columns: &[&str]) -> Request {
    Request::of(columns)
}

fn read(text: &str, options: &Request) -> Result<Vec<Particles>> {
    let reader = |options: Request| Mmcif::new(Source::of_text(text), options);
    let mut mmcif = reader(options.clone());
    let frames: Vec<Particles> = std::iter::from_fn(|| mmcif.next().transpose()).collect::<Result<_>>()?;
    if options.model.is_some() || options.frames != Request::default().frames {
        return Ok(frames);
    }
    // What is said of the first model depends on the frames that are selected.
    let mut others = reader(Request { frames: "2-".parse()?, ..options.clone() });
    others.skip()?;
    let others = std::iter::from_fn(|| others.next().transpose()).collect::<Result<Vec<Particles>>>()?;
    Ok([frames, others].concat())
}

fn refused(text: &str, options: &Request) -> String {
    read(text, options).map(drop).expect_err(text).to_string()
}

fn xs(particles: &Particles) -> Vec<f64> {
    particles.positions.iter().map(|p| p[0]).collect()
}

/// Columns in an unusual order, a row over several lines, names in quotes, two models.
const ATOMS: &str = "\
loop_
_atom_site.Cartn_z
_atom_site.Cartn_y
_ATOM_SITE.CARTN_X
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_alt_id
_atom_site.label_asym_id
_atom_site.auth_asym_id
_atom_site.auth_seq_id
_atom_site.label_entity_id
_atom_site.occupancy
_atom_site.B_iso_or_equiv
_atom_site.id
_atom_site.pdbx_PDB_model_num
3 2 1 C \"C1'\" . A X 7 1 1.0 20.5 1 1
3 2 2
C 'CB' A B X 8 1 0.4 . 2 1
3 2 3 FE FE ? C Y 9 2 1.0 30 3 1 # a comment
3 2 4 C CB B B X 8 1 0.6 ? 4 1
3 2 5 N N . A X 7 1 1.0 20.5 5 2
#
";

/// The first operator is the identity, `P` translates by 100 along x.
const ASSEMBLY: &str = "\
_pdbx_struct_assembly_gen.assembly_id 1
_pdbx_struct_assembly_gen.oper_expression '(1,P)'
_pdbx_struct_assembly_gen.asym_id_list
;A,
C
;
loop_
_pdbx_struct_oper_list.vector[1]
_pdbx_struct_oper_list.id
_pdbx_struct_oper_list.type
_pdbx_struct_oper_list.matrix[1][1]
_pdbx_struct_oper_list.matrix[1][2]
_pdbx_struct_oper_list.matrix[1][3]
_pdbx_struct_oper_list.matrix[2][1]
_pdbx_struct_oper_list.matrix[2][2]
_pdbx_struct_oper_list.matrix[2][3]
_pdbx_struct_oper_list.matrix[3][1]
_pdbx_struct_oper_list.matrix[3][2]
_pdbx_struct_oper_list.matrix[3][3]
_pdbx_struct_oper_list.vector[2]
_pdbx_struct_oper_list.vector[3]
0 1 'identity operation' 1 0 0 0 1 0 0 0 1 0 0
100 P 'point symmetry' 1 0 0 0 1 0 0 0 1 0 0
";

#[test]
fn columns_stand_in_any_order_and_rows_in_any_lines() {
    let text = format!(
        "data_X\n_cell.length_a 10\n_cell.length_b 20\n_cell.length_c 30\n_cell.angle_alpha 90\n_cell.angle_beta 90\n_cell.angle_gamma 90\n{ATOMS}"
    );
    let names = ["serial", "residue", "chain", "asym", "entity", "occupancy", "bfactor", "model"];
    let frames = read(&text, &options(&names)).expect("two models");
    assert_eq!((frames.len(), &frames[0].elements[..], xs(&frames[1])), (2, &[6, 6, 26, 6][..], vec![5.0]));
    assert_eq!(frames[0].positions[1], [2.0, 2.0, 3.0]);
    let column = |name: &str| &frames[0].columns.iter().find(|column| column.name == name).expect(name).values[..];
    assert_eq!((column("serial"), column("residue")), (&[1.0, 2.0, 3.0, 4.0][..], &[7.0, 8.0, 9.0, 8.0][..]));
    assert_eq!((column("chain"), column("asym")), (&[0.0, 0.0, 1.0, 0.0][..], &[0.0, 1.0, 2.0, 1.0][..]));
    assert_eq!((column("entity"), column("occupancy")), (&[0.0, 0.0, 1.0, 0.0][..], &[1.0, 0.4, 1.0, 0.6][..]));
    assert!(column("bfactor")[0] == 20.5 && column("bfactor")[1].is_nan() && column("model") == [1.0; 4]);
    assert_eq!(frames[0].cell.expect("a cell").edges[1], [0.0, 20.0, 0.0]);
    let warnings = &frames[0].skipped.assumed;
    assert!(
        warnings[0].starts_with("2 of 4 atoms are alternate locations") && warnings[1].contains("more than one model"),
        "{warnings:?}"
    );
    // Names of atoms and residues, and alternate locations, besides.
    assert_eq!(frames[0].has.len(), 11, "{:?}", frames[0].has);
}

#[test]
fn models_and_alternate_locations_are_chosen() {
    let text = format!("data_X\n{ATOMS}");
    let with = |altloc, model| read(&text, &Request { altloc, model, ..options(&["occupancy"]) });
    assert_eq!(xs(&with(Altloc::Highest, None).expect("atoms")[0]), [1.0, 3.0, 4.0]);
    assert_eq!(xs(&with(Altloc::Named("A".into()), None).expect("atoms")[0]), [1.0, 2.0, 3.0]);
    let second = with(Altloc::All, Some(2)).expect("the second");
    assert_eq!((second.len(), xs(&second[0]), &second[0].skipped.assumed[..]), (1, vec![5.0], &[][..]));
    let error = with(Altloc::All, Some(3)).map(drop).expect_err("no third").to_string();
    assert!(error.contains("no model 3") && error.contains("the file has 1, 2"), "{error}");
    let both = Request { frames: "1-".parse().expect("frames"), ..options(&[]) };
    let mut mmcif = Mmcif::new(Source::of_text(&text), both);
    assert!(mmcif.skip().expect("skipped"));
    assert_eq!(xs(&mmcif.next().expect("read").expect("the second")), [5.0]);
    assert!(!mmcif.skip().expect("the end") && mmcif.next().expect("the end").is_none());
}

#[test]
fn assemblies_are_built_wherever_their_operators_stand() {
    let with = |id: &str| Request { assembly: Some(id.into()), ..options(&["copy"]) };
    for text in [format!("data_X\n{ASSEMBLY}{ATOMS}"), format!("data_X\n{ATOMS}{ASSEMBLY}data_Y\n_a 'open\n")] {
        let mut mmcif = Mmcif::new(Source::of_text(&text), with("1"));
        let whole = mmcif.next().expect("read").expect("an assembly");
        assert_eq!(xs(&whole), [1.0, 3.0, 101.0, 103.0]);
        assert_eq!(
            (&whole.elements[..], &whole.columns[0].values[..]),
            (&[6, 26, 6, 26][..], &[0.0, 0.0, 1.0, 1.0][..])
        );
        let error = refused(&text, &with("PAU"));
        assert!(error.contains("no assembly `PAU`") && error.contains("the file has 1"), "{error}");
    }
    let text = format!("data_X\n{ASSEMBLY}{ATOMS}");
    let unit = read(&text, &options(&[])).expect("as they stand").remove(0);
    assert!(
        unit.skipped.assumed.iter().any(|warning| warning.contains(&format!("2 copies; use {} 1", setting::ASSEMBLY))),
        "{:?}",
        unit.skipped
    );
    let behind = format!("data_X\n{ATOMS}{ASSEMBLY}");
    let all = Request { frames: "1-".parse().expect("frames"), ..with("1") };
    let models = read(&behind, &all).expect("two models");
    assert_eq!([xs(&models[0]), xs(&models[1])], [vec![1.0, 3.0, 101.0, 103.0], vec![5.0, 105.0]]);
    assert_eq!(xs(&read(&behind, &Request { model: Some(2), ..all }).expect("one model")[0]), [5.0, 105.0]);
    let error = refused(&text.replace("100 P", "x P"), &with("1"));
    assert!(error.contains("text:24:1: _pdbx_struct_oper_list: operator `P` does not have 12"), "{error}");
    let error = refused(&text.replace("(1,P)", "(1-999999999)"), &with("1"));
    assert!(error.contains("text:3:") && error.contains("more operators than the 2"), "{error}");
    assert!(refused(&format!("data_X\n{ATOMS}"), &with("1")).contains("the file has none"));
}

#[test]
fn the_first_block_with_atoms_is_read_and_others_are_skipped() {
    let text = format!(
        "data_ONE\n_a.b 1\nsave_frame\n_c.d 2\nsave_\nloop_\n_e.f\n_e.g\n1 2 3 4\ndata_TWO\n{ATOMS}data_THREE\n{ATOMS}"
    );
    assert_eq!(read(&text, &options(&[])).expect("two models").len(), 2);
    let single = "data_X\n_atom_site.Cartn_x 1.5\n_atom_site.Cartn_y 2\n_atom_site.Cartn_z -3(1)\n_atom_site.type_symbol ZN\n_x.y z\n";
    for end in [single.len(), single.len() - "_x.y z\n".len()] {
        let one = read(&single[..end], &options(&[])).expect("one atom");
        assert_eq!((one.len(), one[0].positions[0], one[0].elements[0]), (1, [1.5, 2.0, -3.0], 30));
    }
    for bad in ["", "data_X\n", "data_X\nloop_\n", "data_X\nloop_\n_atom_site.id\n1\n", "data_X\n_atom_site.id\n"] {
        assert!(refused(bad, &options(&[])).contains("the file has no atoms"), "{bad:?}");
    }
}

#[test]
fn fractions_of_the_cell_become_places() {
    let cell = "_cell_length_a 10.0(2)\n_cell_length_b 20\n_cell_length_c 30\n_cell_angle_alpha 90\n_cell_angle_beta 90\n_cell_angle_gamma 120\n";
    let atoms = "loop_\n_atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\nCu1 0.5 0 0\nO2 0 0.5(1) 0.25\n";
    let frame = read(&format!("data_x\n{cell}{atoms}"), &options(&[])).expect("atoms").remove(0);
    assert_eq!((&frame.elements[..], frame.positions[0]), (&[29, 8][..], [5.0, 0.0, 0.0]));
    let expected = [-5.0, 10.0 * f64::sqrt(0.75), 7.5];
    // The cosine of 120 degrees and a few products of numbers below 16.
    assert!(frame.positions[1].iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{:?}", frame.positions[1]);
    assert!(frame.skipped.assumed.iter().any(|warning| warning.contains("symmetry")), "{:?}", frame.skipped);
    // The cell may follow the atoms.
    assert_eq!(read(&format!("data_x\n{atoms}{cell}"), &options(&[])).expect("atoms")[0].positions, frame.positions);
    assert!(refused(&format!("data_x\n{atoms}"), &options(&[])).contains("fractions of a cell"));
}

#[test]
fn errors_are_reported_with_line_and_column() {
    let text = format!("data_X\n{ATOMS}");
    for (old, new, place) in [
        ("3 2 1 C", "3 2 one C", "text:17:5: x: expected a finite number, found `one`"),
        ("3 2 1 C", "3 ? 1 C", "text:17:3: y: the atom has no position"),
        ("20.5 1 1", "20.5 1 first", "text:17:36: pdbx_PDB_model_num"),
        ("20.5 5 2\n", "20.5 5\n", "_atom_site: the row of this atom ends after 13 of 14 values"),
        ("'CB'", "'CB", "text:19:3: a quote"),
        ("3 2 1 C", "3 2 1e999 C", "text:17:5: x"),
    ] {
        let error = refused(&text.replacen(old, new, 1), &options(&[]));
        assert!(error.contains(place), "{error}");
    }
}

#[test]
fn symmetry_fills_the_cell_of_a_small_molecule() {
    let cell = "_cell_length_a 4\n_cell_length_b 4\n_cell_length_c 4\n_cell_angle_alpha 90\n_cell_angle_beta 90\n_cell_angle_gamma 90\n";
    let operators = |tag: &str, list: &str| format!("loop_\n{tag}\n{list}\n");
    let atoms = "loop_\n_atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\n_atom_site_calc_flag\n\
        CA1 0 0 0 d\nO1 0.25 0.25 0.25 d\nCg 0.1 0.1 0.1 dum\n";
    let centred = "x,y,z\n'1/2+x, 1/2+y, z'\n-x,-y,-z";
    let sum = "_chemical_formula_sum 'Ca O'\n";
    for tag in ["_symmetry_equiv_pos_as_xyz", "_space_group_symop_operation_xyz", "_space_group_symop.operation_xyz"] {
        for text in [
            format!("data_x\n{sum}{cell}{}{atoms}", operators(tag, centred)),
            format!("data_x\n{sum}{atoms}{}{cell}", operators(tag, centred)),
        ] {
            let frame = read(&text, &options(&["copy"])).expect("a cell").remove(0);
            assert_eq!(frame.elements, [20, 8, 20, 8, 8], "{tag}");
            assert_eq!(frame.positions[1..], [[1.0; 3], [2.0, 2.0, 0.0], [3.0, 3.0, 1.0], [3.0; 3]]);
            assert_eq!(frame.columns[0].values, [0.0, 0.0, 1.0, 1.0, 2.0]);
            let warnings = &frame.skipped.assumed;
            assert!(warnings.iter().any(|warning| warning.starts_with("3 operators make 5 atoms")), "{warnings:?}");
            assert!(
                warnings.iter().any(|warning| warning.starts_with("1 virtual site left out (1 `DUM`)")),
                "{warnings:?}"
            );
            let listed = Request { as_listed: true, ..options(&["copy"]) };
            assert_eq!(read(&text, &listed).expect("as listed")[0].positions, [[0.0; 3], [1.0; 3]]);
        }
    }
    // P 1 with only x,y,z has no symmetry.
    let plain = format!(
        "data_x\n_symmetry_space_group_name_H-M 'P 1'\n{cell}_space_group_symop_operation_xyz x,y,z\n{}",
        atoms.replace("Cg 0.1 0.1 0.1 dum\n", "")
    );
    let frame = read(&plain, &options(&[])).expect("a cell").remove(0);
    assert!(frame.skipped.assumed.is_empty() && frame.positions.len() == 2, "{:?}", frame.skipped);
    let bad = format!("data_x\n{cell}{}{atoms}", operators("_symmetry_equiv_pos_as_xyz", "x,y,z\nx,y"));
    let error = refused(&bad, &options(&[]));
    assert!(error.contains("text:11:1: symmetry: `x,y` is not a symmetry operator"), "{error}");
    let two = read(&format!("{plain}data_y\n{atoms}"), &options(&[])).expect("the first").remove(0);
    assert_eq!((two.positions.len(), two.skipped.assumed.len()), (2, 1));
    assert!(two.skipped.assumed[0].starts_with("the file has several data blocks"), "{:?}", two.skipped);
    // Macromolecular files list the asymmetric unit, even if operators follow.
    let entry = format!("data_X\n{ATOMS}{}", operators("_symmetry_equiv.pos_as_xyz", centred));
    assert_eq!(read(&entry, &options(&[])).expect("atoms")[0].positions.len(), 4);
}

/// Rows of models in any order are read as the models one after the other.
#[test]
fn rows_of_models_need_not_follow_each_other() {
    let head = "data_x\nloop_\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n\
        _atom_site.Cartn_z\n_atom_site.pdbx_PDB_model_num\n";
    let row = |model: i64, n: i64| format!("{n} C {n} {model} 0 {model}\n");
    for models in [vec![1, 2], vec![1, 2, 3], vec![7, 3, 5, 4]] {
        let rows: Vec<(i64, i64)> = models.iter().flat_map(|model| (0..5).map(|n| (*model, n))).collect();
        let text = |rows: &[(i64, i64)]| {
            let rows: String = rows.iter().map(|(model, n)| row(*model, *n)).collect();
            format!("{head}{rows}loop_\n_cell.length_a\n1\n")
        };
        let mut turns = rows.clone();
        turns.sort_by_key(|(model, n)| (*n, models.iter().position(|other| other == model)));
        let mut late = rows.clone();
        let last = late.remove(1);
        late.push(last);
        late.sort_by_key(|(_, n)| *n == 1);
        for other in [&turns, &late] {
            for request in [
                Request { frames: "1-".parse().expect("a range"), ..Request::default() },
                Request::default(),
                Request { model: Some(models[1]), ..Request::default() },
            ] {
                let frames = |rows: &[(i64, i64)]| {
                    let frames = read(&text(rows), &request).expect("models");
                    let of = |frame: &Particles| {
                        let mut positions = frame.positions.clone();
                        positions.sort_by(|a, b| a[0].total_cmp(&b[0]));
                        positions
                    };
                    frames.iter().map(of).collect::<Vec<_>>()
                };
                let whole = frames(&rows);
                assert!(whole.iter().take(2).all(|frame| frame.len() == 5), "{request:?}");
                assert_eq!(frames(other), whole, "{models:?} {request:?}");
            }
        }
    }
}

/// Each model is found among the others by its number.
#[test]
fn a_file_may_have_as_many_models_as_atoms() {
    let head = "data_x\nloop_\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n\
        _atom_site.pdbx_PDB_model_num\n";
    let rows: String = (0..20_000).map(|n| format!("C {n} 2 3 {n}\n")).collect();
    let found = read(&format!("{head}{rows}"), &options(&[])).expect("models");
    assert_eq!(found.len(), 20_000);
}
