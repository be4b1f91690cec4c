use super::*;
use crate::elements::element;

/// The symbols of `NAME.RESIDUE` words, all of one residue where the residue's name is the same, and the messages.
fn symbols(columns: bool, words: &str) -> (String, Inferred) {
    let mut inference = Inference::new(columns);
    let mut elements = Vec::new();
    for word in words.split(',') {
        let (name, residue) = word.split_once('.').expect("a residue");
        let name = name.as_bytes();
        inference.push(&AtomNames { symbol: b"", name, residue: residue.as_bytes(), site: b"" }, &mut elements);
    }
    let found = inference.finish(&mut elements);
    let symbol = |code: &u8| match element(*code) {
        Some(element) => element.symbol,
        None if is_site(*code) => "-",
        None => "?",
    };
    (elements.iter().map(symbol).collect::<Vec<_>>().join(" "), found)
}

#[test]
fn left_aligned_names_are_recognised_by_their_columns() {
    let protein = "N   .HSD,CA  .HSD,ND1 .HSD,CE1 .HSD,CD2 .HSD,HG  .SER,C   .SER,CD  .CYX";
    let (found, report) = symbols(true, protein);
    assert_eq!(found, "N C N C C H C C");
    assert!(report.astray && report.counts == [8, 0, 0, 0], "{report:?}");
    // An unknown ligand in the same file; without context its names look like metals.
    let (found, report) = symbols(true, &format!("{protein},CA  .LIG,CE  .LIG,ND  .LIG,CL1 .LIG,HG  .LIG,FE  .LIG"));
    assert_eq!(found, "N C N C C H C C C C N Cl H Fe");
    assert_eq!(report.counts, [8, 0, 0, 6]);
    // In a file of aligned names the same columns mean metals.
    let (found, report) = symbols(true, " N  .ALA, CA .ALA, C  .ALA,CE  .LIG,CD  .LIG,HG  .LIG, C1 .LIG,FE  .LIG");
    assert_eq!(found, "N C C Ce Cd Hg C Fe");
    assert!(!report.astray && report.counts == [3, 0, 5, 0], "{report:?}");
}

#[test]
fn the_residue_decides_where_columns_do_not() {
    // One ligand is left-aligned among aligned residues: its other names show it.
    let aligned = " N  .ALA, CA .ALA, C  .ALA, O  .ALA, CB .ALA, N  .GLY, CA .GLY, C  .GLY, O  .GLY";
    let (found, _) = symbols(true, &format!("{aligned},CD  .LIG,C1  .LIG,O1  .LIG"));
    assert!(found.ends_with("C C O"), "{found}");
    // A modified amino acid has the backbone's atoms, and its CA is a carbon in any column.
    let (found, _) = symbols(true, &format!("{aligned}, N  .XYZ,CA  .XYZ, C  .XYZ"));
    assert!(found.ends_with("N C C"), "{found}");
    // Programs that begin every name in the second column write ions there too.
    let (found, report) = symbols(true, &format!("{aligned}, CL1.LIG, C1 .LIG, ZN . ZN, NA .NA+"));
    assert!(found.ends_with("Cl C Zn Na") && report.astray, "{found}");
    // Haem in a file without ions, where the name is the only evidence.
    let (found, _) = symbols(true, &format!("{aligned}, FE .HEM, NA .HEM, C1A.HEM"));
    assert!(found.ends_with("Fe N C"), "{found}");
}

#[test]
fn ions_are_residues_of_one_atom() {
    for columns in [false, true] {
        let (found, report) = symbols(columns, "CA  .CA,ZN  .ZN2,MG  .MG,SOD .SOD,CLA .CLA,CD  .CD,HG  .HG,K   .K");
        assert_eq!((&found[..], report.counts), ("Ca Zn Mg Na Cl Cd Hg K", [0, 8, 0, 0]), "{columns}");
    }
    let (found, _) = symbols(true, "CA  .ALA,CA  .HSD,CA  .GLY,CA  .ARG");
    assert_eq!(found, "C C C C", "a trace of a chain");
    assert_eq!(symbols(true, "CA  .ABC,CA  .XYZ").0, "C C");
}

#[test]
fn virtual_sites_are_distinguished_from_atoms() {
    for (words, expected) in [
        ("OW.SOL,HW1.SOL,HW2.SOL,MW.SOL", "O H H -"),
        ("OH2.TIP4,H1.TIP4,H2.TIP4,OM.TIP4", "O H H -"),
        ("O.WAT,H1.WAT,H2.WAT,EPW.WAT", "O H H -"),
        ("O.TP5,H1.TP5,H2.TP5,EP1.TP5,EP2.TP5", "O H H - -"),
        ("OH2.SWM4,DOH2.SWM4,LPX.SWM4,H1.SWM4,H2.SWM4", "O - - H H"),
        ("N.ALA,DN.ALA,CA.ALA,DCA.ALA,HA.ALA,C.ALA,DC.ALA,O.ALA,DO.ALA,LPA.ALA", "N - C - H C - O - -"),
        // Deuterium, and a name that begins like a virtual site's.
        ("N.ALA,D.ALA,CA.ALA,DA.ALA,CB.ALA,DB1.ALA,O.ALA", "N H C H C H O"),
        ("O.DOD,D1.DOD,D2.DOD", "O H H"),
        ("MN.MN", "Mn"),
        ("N.LYSH,NZ.LYSH,MNZ1.LYSH,MNZ2.LYSH", "N N - -"),
        ("C1.LIG,M.LIG,O.LIG", "C ? O"),
        ("ZND.ZNM,DM1.ZNM,DM2.ZNM", "Zn - -"),
    ] {
        let (found, report) = symbols(false, words);
        assert_eq!((&found[..], report.sites()), (expected, expected.matches('-').count() as u64), "{words}");
    }
}

#[test]
fn beads_are_not_atoms() {
    let (found, report) = symbols(false, "NC3.DPPC,PO4.DPPC,GL1.DPPC,C1A.DPPC,W.W,W.W,BB.LEU,SC1.LEU,CL-.ION");
    assert_eq!((&found[..], report.beads), ("? ? ? ? ? ? ? ? Cl", 8));
    assert_eq!(report.sentences(9).len(), 2);
}

#[test]
fn inferred_elements_are_reported_with_counts() {
    let (_, report) = symbols(false, "OW.SOL,HW1.SOL,HW2.SOL,MW.SOL,C1.LIG,X.LIG,NA.NA");
    assert_eq!(
        report.sentences(7),
        [
            "the file gives no element for 6 of 7 atoms; inferred: 3 from known residues, 1 as single ions, 1 from their \
             names alone, 1 unknown",
            "1 virtual site left out (1 `MW`)"
        ]
    );
    assert_eq!(report.names, ["X"]);
}

#[test]
fn a_symbol_of_a_virtual_site_is_one_whatever_its_name() {
    let mut inference = Inference::new(true);
    let mut elements = Vec::new();
    for (symbol, name) in [(" O", " O  "), (" H", " H1 "), (" H", " H2 "), ("EP", " M1 "), ("EP", " H3 ")] {
        let (symbol, name) = (symbol.as_bytes(), name.as_bytes());
        inference.push(&AtomNames { symbol, name, residue: b"HOH", site: b"A   1" }, &mut elements);
    }
    let found = inference.finish(&mut elements);
    assert_eq!(elements[..3], [8, 1, 1]);
    assert!(is_site(elements[3]) && is_site(elements[4]) && found.sites() == 2, "{elements:?}");
}

#[test]
fn a_given_element_is_kept() {
    let mut inference = Inference::new(true);
    let mut elements = Vec::new();
    for (symbol, name) in
        [(" N", " N  "), ("CA", "CA  "), ("  ", " C  "), ("X ", " UNK"), ("EP", " EP "), ("2-", " O  ")]
    {
        let (symbol, name) = (symbol.as_bytes(), name.as_bytes());
        inference.push(&AtomNames { symbol, name, residue: b"ALA", site: b"A   1" }, &mut elements);
    }
    let found = inference.finish(&mut elements);
    assert_eq!((&elements[..3], elements[5]), (&[7, 20, 6][..], 8));
    assert!(unknown(elements[3]) == Some(0) && is_site(elements[4]) && found.names == ["X"], "{elements:?}");
    assert_eq!((found.counts, found.unknown, found.sites()), ([2, 0, 0, 0], 1, 1));
}

#[test]
fn unknown_names_are_counted_to_a_limit() {
    let words: Vec<String> = (0..40).map(|n| format!("Y{}Z.L{n}", (b'A' + n % 26) as char)).collect();
    let mut inference = Inference::new(false);
    let mut elements = Vec::new();
    for (n, word) in words.iter().enumerate() {
        let name = format!("X{n}");
        let atom = AtomNames { symbol: b"", name: name.as_bytes(), residue: word.as_bytes(), site: b"" };
        inference.push(&atom, &mut elements);
    }
    let found = inference.finish(&mut elements);
    assert_eq!((found.names.len(), &found.names[NAMES][..], found.unknown), (NAMES + 1, "others", 40));
}
