"""The atoms that selections take, compared with MDAnalysis over its own test files.

    pip install MDAnalysis MDAnalysisTests
    cargo build --release --example spheres
    python tests/independent/selections.py target/release/examples/spheres

Positions are compared in the order of the file. MDAnalysis stores float32 and converts nm to angstrom in it: two roundings of
2^-24 of at most 1000 A, below 2e-4 A (2e-3 where both are rounded for sorting); atoms are never closer than 0.1 A. Virtual sites (MW) are not atoms here and are removed
there. `within` includes the selected atoms, as in VMD.
"""
import json, subprocess, sys, warnings

import MDAnalysis, numpy as np
from MDAnalysisTests import datafiles

warnings.simplefilter("ignore")
program = sys.argv[1]

# An expression, or ours and theirs where the words differ.
PROTEIN = [
    "all", ("none", "not all"), "protein", "not protein", "backbone", "name CA", "name CA CB", "name C*", "name ?A", "name H*",
    "name [CN]", "protein and not name H*", "protein and name CA C N O", "resname ALA", "resname ALA GLY LYS",
    "resname HS*", "resid 10", "resid 10:20", "resid 10-20", "resid 10 to 20", "resid 1:5 10 200:1000", "not resid 10:200",
    "resid 10:100 and name CA", "(resid 1:20 or resid 50:60) and backbone", "index 5", "index 5:20 100", "bynum 1:10",
    "bynum 7", "name N or name O", "resname ARG and name N* or resid 5", "not (resname ALA or resname GLY) and name CB",
    "prop x > 0", "prop y <= 10.5", "prop abs z < 5", "prop x > -5 and prop x < 5", "around 3 resname ARG",
    "around 4.5 (resid 10 and name CA)", "protein and around 5 resname GLY", "byres name SD", "byres around 3 resid 20",
    "same resname as resid 7", "same name as index 0", "same residue as name CZ",
    ("within 5 of (resid 30)", "(around 5 resid 30) or resid 30"),
    ("within 3 of resname LYS", "(around 3 resname LYS) or resname LYS"),
    ("exwithin 4 of (resid 1:3)", "around 4 resid 1:3"),
    ("x > 0 and y < 3", "prop x > 0 and prop y < 3"),
    ("resnum 4:9", "resid 4:9"),
]
WATER = [
    "water", "not water", "water and name OW", "resname SOL and around 3 protein", "protein or resname NA+",
    "same residue as (resname SOL and around 3 resid 12)", "resname SOL and prop z > 40", "byres (resname SOL and around 2.5 protein)",
    ("water and within 4 of (protein)", "resname SOL and ((around 4 protein) or protein)"),
]
PDB = ["segid 4AKE", "segid 4*", "prop x > 20", ("bfactor < 20", "prop tempfactor < 20"), ("beta == 0", "prop tempfactor == 0"),
       ("occupancy > 0.5", "prop occupancy > 0.5")]
CRYSTAL = [
    "protein", "chainID A", "chainID A B", "not chainID A", "chainID A and name CA", "altLoc A", "altLoc A B", "icode A B",
    "record_type HETATM", "record_type ATOM and not protein", "element C", "element C N", "element S", "not element H",
    "resid 30", "resid 1:30", "resid 1A", "resid 1A:1C", "resid 60:60C", "resid 14A-15", "water", "nucleic",
    ("bfactor < 20", "prop tempfactor < 20"), ("bfactor >= 30 and name CA", "prop tempfactor >= 30 and name CA"),
    ("occupancy < 1", "prop occupancy < 1"), "same residue as element S", "around 4 element S", "id 10:100", "id 5 7 9",
    ("serial 10:100", "id 10:100"),
    ("hydrogen", "element H"),
]
NUCLEIC = ["nucleic", "not nucleic", "resname ADE", "nucleic and name P", "name *5'", "name O?'", "resid 3:5 and name C*", "byres name P"]
DUMP = ["type 1", "type 2", "type 1 2", "id 1:10", "id 5", "prop x < 2", "index 0:3", "around 2 type 1"]

FILES = [
    (datafiles.GRO, PROTEIN + WATER, "MW"),
    (datafiles.PDB_small, PROTEIN + PDB, None),
    (datafiles.PDB_icodes, CRYSTAL, None),
    (datafiles.PDB_full, CRYSTAL, None),
    (datafiles.PDB_HOLE, CRYSTAL + PROTEIN, None),
    (datafiles.PDB_mc, CRYSTAL, None),
    (datafiles.NUCLsel, NUCLEIC, None),
    (datafiles.LAMMPSDUMP, DUMP, None),
    (datafiles.PQR, PROTEIN[:30], None),
]


def ours(file, expression):
    run = subprocess.run([program, str(file), "--frames", "1", "--select", expression], capture_output=True, text=True)
    if run.returncode != 0:
        return run.stderr.strip()
    return np.array(json.loads(run.stdout.splitlines()[0])["centers"]).reshape(-1, 3)


compared = atoms = 0
expressions, differ = set(), []
for file, all_expressions, left_out in FILES:
    kind = {"topology_format": "LAMMPSDUMP"} if "lammps" in str(file).lower() else {}
    universe = MDAnalysis.Universe(str(file), **kind)
    for expression in all_expressions:
        mine, theirs = expression if isinstance(expression, tuple) else (expression, expression)
        try:
            with_sites = f"({theirs}) and not name {left_out}" if left_out else theirs
            expected = universe.select_atoms(with_sites, periodic=False).positions
        except Exception as error:
            print(f"skipped: {file}: {theirs}: {error}")
            continue
        found = ours(file, mine)
        same = not isinstance(found, str) and found.shape == expected.shape
        if same and kind and len(found):  # MDAnalysis sorts by id and moves the box to the origin.
            found, expected = (sorted((p - a.min(axis=0)).round(3).tolist()) for p, a in
                               [(found, ours(file, "all")), (expected, universe.atoms.positions)])
        same = same and np.allclose(found, expected, rtol=0, atol=2e-3 if kind else 2e-4)
        compared += 1
        atoms += len(expected)
        expressions.add(mine)
        if not same:
            differ.append((file, mine))
            print(f"DIFFERENT: {file}: {mine}: {len(expected)} there, {found if isinstance(found, str) else len(found)} here")
print(f"{compared} comparisons of {len(expressions)} expressions over {len(FILES)} files, {atoms} atoms: {len(differ)} differ")
sys.exit(bool(differ))
