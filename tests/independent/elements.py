"""Compares the elements that halfline finds with the elements of gemmi, MDAnalysis and ParmEd, atom by atom.

    pip install gemmi MDAnalysis MDAnalysisTests parmed
    cargo build --example elements
    python tests/independent/elements.py target/debug/examples/elements [FOLDER...]

Files: every PDB, GRO and mmCIF file of MDAnalysisTests and of the folders that are named. An atom is the same atom in two
programs where its place is the same, to the last of three decimals, and it is the n-th of that place.

Topologies: every PSF, AMBER and GROMACS topology there. They give elements as masses or atomic numbers; their names are
written to files that give none (PDB with names that begin in the first column, in the second, and as the format says; GRO),
which halfline reads.

Crystals: every small-molecule CIF of those folders. The cell that halfline fills equals gemmi's, atom by atom; ASE's too
where it is installed and reads the file.

Prints tables in markdown: files, atoms and differences; the differences that EXPLAINED explains; those that nothing explains.
Exits with 1 if there are any of the last, or an atom that one program alone has and that is no virtual site.
"""
import bz2, collections, gzip, itertools, json, logging, os, re, shutil, subprocess, sys, tempfile, warnings

import gemmi, MDAnalysis, numpy as np, parmed
from MDAnalysis.guesser.default_guesser import DefaultGuesser
import MDAnalysisTests

warnings.filterwarnings("ignore")
logging.disable(logging.CRITICAL)

STRUCTURES = (".pdb", ".ent", ".gro", ".cif", ".pdbx")
TOPOLOGIES = (".psf", ".xplor", ".parm7", ".prmtop", ".tpr")

# Differences where the other program is wrong, as "program file residue atom halfline's-element theirs" with "-" for none, and
# why. A pattern names its files, and where it covers many atoms it says what halfline's element must be.
EXPLAINED = [
    (
        r"gemmi (adk_(open|closed|open_10res)|nucl_res|test_topology|CONECT2TER|SINGLECONECT)\.pdb \S+ ([CHNOS])\S* \3 \S+",
        "names begin in column 13 throughout; gemmi reads columns 13 and 14 as a symbol (CA calcium, HG1 mercury, HN none)",
    ),
    (
        r"(gemmi|ParmEd) (cobrotoxin|adk_oplsaa|pdbqt_querypdb|gromos11_traj_(solv|vac))\.pdb\S* \S+ (CL Cl C|NA Na N|FE Fe F)",
        "ions and haem's iron begin in column 14, where the format has symbols of one letter",
    ),
    (r"(gemmi|ParmEd) 1k5i_c36\.pdb\.gz POT POT K P", "CHARMM's name of potassium begins in column 14; read as phosphorus"),
    (r"ParmEd cobrotoxin\.pdb \S+ \dH\S+ H -", "hydrogens numbered in front (1HG2): ParmEd gives no element"),
    (r"ParmEd \S+\.gro\S* (NA\+ NA Na N|CL CL Cl C)", "ions of GRO files: ParmEd takes the first letter"),
    (
        r"(MDAnalysis|ParmEd) (martini_dppc_chol_bilayer|dppc_vesicle_hg|grovels)\.gro (DPPC|DOPC|CHOL) \S+ - [CNOPGR]",
        "beads of Martini, several atoms each; the other takes the first letter",
    ),
    (
        r"(MDAnalysis|ParmEd) dummy(_2021)?\.gro TEST T\d+ - H",
        "numbered types of a test of bonded interactions, no atoms; T is taken for tritium",
    ),
    (r"MDAnalysis \S+\.gro SOL [AEG] - [AEG]", "names without meaning; MDAnalysis returns the letter, which is no element"),
    (r"MDAnalysis argon_npt_compressed\.gro\.gz Ar Ar Ar A", "argon; MDAnalysis cuts the name to A, which is no element"),
    (r"MDAnalysis YiiP_lipids\.gro\.gz ZNM ZND Zn N", "zinc amid its six dummies; MDAnalysis strips Z and D"),
    (r"MDAnalysis pdbqt_querypdb\.pdb HEM NA N Na", "a nitrogen of haem's ring; MDAnalysis guesses sodium"),
    (
        r"gemmi sample\.cif THR (ZN Zn|([CHNO])\S* \2) -",
        "type_symbol is XX throughout; halfline takes the names, gemmi nothing",
    ),
    (r"ParmEd 5PTI\.cif\.gz UNX UNK - U", "type_symbol is X, unknown; ParmEd takes the name's first letter, uranium"),
    (r"ParmEd SCM_A\.pdb ALA CA Ca C", "the file's element column says CA, and halfline and gemmi believe it; ParmEd does not"),
    (r".* mp8\.prmtop HEH FE Fe F", "iron of haem, mass 55; the topology's atomic number is fluorine's"),
]
VIRTUAL = r"MW|EP|DM\d"


def plain(path):
    """The name without the extension of its compression."""
    return re.sub(r"\.(gz|bz2)$", "", path)


def unpacked(path, folder):
    """The file, decompressed into a folder if needed."""
    if plain(path) == path:
        return path
    out = os.path.join(folder, os.path.basename(plain(path)))
    with (gzip.open if path.endswith("gz") else bz2.open)(path) as source, open(out, "wb") as target:
        shutil.copyfileobj(source, target)
    return out


def normal(symbol):
    symbol = (symbol or "").strip().capitalize()
    return {"D": "H", "T": "H", "X": "", "Ep": "", "Lp": "", "Du": "", "M": "", "Mw": ""}.get(symbol, symbol)


def of_gemmi(path):
    if path.endswith(".gro"):
        return None
    model = gemmi.read_structure(path, format=gemmi.CoorFormat.Detect)[0]
    for chain in model:
        for residue in chain:
            for atom in residue:
                yield atom.pos.tolist(), residue.name, atom.name, normal(atom.element.name)


def of_mdanalysis(path):
    if path.endswith((".cif", ".pdbx")):
        return None
    format = "PDB" if path.endswith(".ent") else None
    universe = MDAnalysis.Universe(path, format=format, topology_format=format, to_guess=())
    atoms = universe.atoms
    given = getattr(atoms, "elements", [""] * len(atoms))
    guessed = DefaultGuesser(None).guess_types(atoms.names)
    for atom, given, guessed in zip(atoms, given, guessed):
        yield atom.position.tolist(), getattr(atom, "resname", ""), atom.name, normal(given) or normal(guessed)


def of_parmed(path):
    structure = parmed.load_file(path, structure=True) if not path.endswith(".gro") else parmed.load_file(path)
    for first in structure.atoms:
        # Alternate locations are stored beside the first one.
        for atom in (first, *first.other_locations.values()):
            symbol = parmed.periodic_table.Element[atom.atomic_number] if atom.atomic_number > 0 else ""
            yield [atom.xx, atom.xy, atom.xz], first.residue.name, atom.name, normal(symbol)


PROGRAMS = {"gemmi": of_gemmi, "MDAnalysis": of_mdanalysis, "ParmEd": of_parmed}


def halfline(binary, paths):
    run = subprocess.run([binary, *paths], stdout=subprocess.PIPE, check=True, text=True)
    return [json.loads(line) for line in run.stdout.splitlines()]


def place(position):
    return tuple(round(float(x) * 1000) for x in position)


def at(atoms, position):
    """The atoms at that position, or a step beside it where another program's single precision rounded differently."""
    around = itertools.product((0, -1, 1), repeat=3)
    near = (tuple(map(sum, zip(place(position), step))) for step in around)
    return next((atoms[place] for place in near if atoms.get(place)), None)


def explanation(key):
    words = " ".join(part or "-" for part in key)
    return next((why for pattern, why in EXPLAINED if re.fullmatch(pattern, words)), None)


def compare(found, truth, key, differences):
    """Counts of atoms that are compared, that differ, and whose difference is explained; atoms that only one program has."""
    theirs = collections.defaultdict(collections.deque)
    for position, residue, name, symbol in truth:
        theirs[place(position)].append((residue, name, symbol))
    counts, alone = collections.Counter(), []
    for position, ours in zip(found["positions"], map(normal, found["symbols"])):
        queue = at(theirs, position)
        if not queue:
            alone.append(f"only in halfline: {ours}")
            continue
        residue, name, symbol = queue.popleft()
        counts["atoms"] += 1
        if ours != symbol:
            difference = (*key, residue, name, ours, symbol)
            differences[difference] += 1
            counts["different"] += 1
            counts["explained"] += explanation(difference) is not None
    return counts, alone + [name for queue in theirs.values() for _, name, _ in queue]


def files(folders, endings):
    for folder in folders:
        for parent, _, names in sorted(os.walk(folder)):
            for name in sorted(names):
                if plain(name).lower().endswith(endings):
                    yield os.path.join(parent, name)


def structures(binary, folders, differences):
    rows = collections.defaultdict(collections.Counter)
    sites, refused = collections.Counter(), []
    with tempfile.TemporaryDirectory() as folder:
        for path in files(folders, STRUCTURES):
            try:
                there = unpacked(path, folder)
            except OSError as error:
                refused.append((path, "everybody", f"not what its name says: {error}"))
                continue
            found = halfline(binary, [path])[0]
            if "error" in found:
                refused.append((path, "halfline", found["error"]))
                continue
            given = ".gro" not in path and not any("gives no element" in said for said in found["warnings"])
            kind = plain(path).rsplit(".", 1)[1].lower().replace("ent", "pdb").replace("pdbx", "cif")
            for program, read in PROGRAMS.items():
                try:
                    truth = read(there)
                    truth = None if truth is None else list(truth)
                except Exception as error:  # Each has files that it does not read.
                    refused.append((path, program, f"{type(error).__name__}: {error}"))
                    continue
                if not truth:
                    continue
                counts, alone = compare(found, truth, (program, os.path.basename(path)), differences)
                source = "MDAnalysisTests" if "MDAnalysisTests" in path else "other folders"
                rows[source, kind, "given" if given else "inferred", program] += counts + collections.Counter(files=1)
                sites.update((program, os.path.basename(path), name) for name in alone)
    return rows, sites, refused


WEIGHTS = [(symbol, mass) for symbol, mass in parmed.periodic_table.Mass.items() if mass > 0]


def of_mass(mass):
    """The element, "" for sites without mass and Drude particles, None for a mass of no element."""
    if mass < 0.9:
        return "" if mass <= 0 or mass > 0.2 else None
    symbol, weight = min(WEIGHTS, key=lambda known: abs(known[1] - mass))
    return normal(symbol) if abs(weight - mass) < 0.15 else None


def topology(path):
    """Name, residue, residue's number and element of every atom."""
    if path.endswith(".tpr"):
        for atom in MDAnalysis.Universe(path, topology_format="TPR", to_guess=()).atoms:
            yield atom.name, atom.resname, atom.resindex, of_mass(atom.mass)
        return
    numbers = not path.endswith((".psf", ".xplor"))
    for atom in parmed.load_file(path).atoms:
        number = atom.atomic_number
        element = (normal(parmed.periodic_table.Element[number]) if number > 0 else "") if numbers else of_mass(atom.mass)
        yield atom.name, atom.residue.name, atom.residue.idx, element


def pdb(align):
    def write(atoms, out):
        for n, (name, residue, number, element) in enumerate(atoms):
            columns = align(name, element or "").ljust(4)[:4]
            x, y, z = n % 100, n // 100 % 100, n // 10000
            out.write(
                f"ATOM  {(n + 1) % 100000:5} {columns} {residue[:4]:<4} {number % 10000:4}    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00\n"
            )

    return write


def gro(atoms, out):
    out.write(f"names\n{len(atoms)}\n")
    for n, (name, residue, number, _) in enumerate(atoms):
        x, y, z = n % 100 / 10, n // 100 % 100 / 10, n // 10000 / 10
        out.write(f"{number % 100000:5}{residue[:5]:<5}{name[:5]:>5}{(n + 1) % 100000:5}{x:8.3f}{y:8.3f}{z:8.3f}\n")
    out.write("   0.00000   0.00000   0.00000\n")


def standard(name, element):
    two = len(element) == 2 and name.upper().startswith(element.upper())
    return name if len(name) >= 4 or two else " " + name


LAYOUTS = {
    "PDB, all names from the first column": pdb(lambda name, _: name),
    "PDB, all names from the second column": pdb(lambda name, _: name if len(name) >= 4 else " " + name),
    "PDB, as the format says": pdb(standard),
    "GRO": gro,
}


def topologies(binary, folders, differences):
    rows, refused, read = {}, [], {}
    with tempfile.TemporaryDirectory() as folder:
        for path in files(folders, TOPOLOGIES):
            try:
                read[path] = [atom for atom in topology(unpacked(path, folder)) if atom[0]]
            except BaseException as error:  # Some of these files are broken on purpose.
                refused.append((path, "the reader of topologies", f"{type(error).__name__}: {error}"))
        for layout, write in LAYOUTS.items():
            row = rows.setdefault(layout, collections.Counter())
            ending = ".gro" if write is gro else ".pdb"
            for n, (path, atoms) in enumerate(read.items()):
                there = os.path.join(folder, f"{n}{ending}")
                with open(there, "w") as out:
                    write(atoms, out)
                found = halfline(binary, [there])[0]
                row["files"] += 1
                if "error" in found:
                    refused.append((path, f"halfline, {layout}", found["error"]))
                    continue
                drawn = {}
                for (x, y, z), symbol in zip(found["positions"], found["symbols"]):
                    drawn[round(x) + 100 * round(y) + 10000 * round(z)] = normal(symbol)
                for index, (name, residue, _, element) in enumerate(atoms):
                    if element is None:
                        row["unknown"] += 1
                        continue
                    row["atoms"] += 1
                    # Neither a site that is left out nor one of unknown element is an atom.
                    ours = drawn.get(index, "")
                    if ours != element:
                        difference = (layout, os.path.basename(path), residue, name, ours, element)
                        differences[difference] += 1
                        row["different"] += 1
                        row["explained"] += explanation(difference) is not None
                os.remove(there)
    return rows, refused


def crystals(binary, folders):
    """Small-molecule CIF: the atoms in the cell against gemmi's sites and ASE's."""
    try:
        import ase.io
    except ImportError:
        ase = None
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for path in files(folders, (".cif",)):
            try:
                there = unpacked(path, folder)
                small = gemmi.cif.read(there)[0]
            except (OSError, ValueError, IndexError):
                continue
            if not small.find_loop("_atom_site_fract_x"):
                continue
            small = gemmi.make_small_structure_from_block(small)
            found = halfline(binary, [path])[0]
            name = os.path.basename(path)
            if "error" in found:
                rows.append([name, found["error"], 0, 0, 0, 1])
                continue
            cell = small.cell
            places = [cell.fractionalize(gemmi.Position(*place)) for place in found["positions"]]
            ours = list(zip(map(normal, found["symbols"]), places))
            sites = [(normal(site.element.name), site.fract) for site in small.get_all_unit_cell_sites()]
            alone = unpaired(ours, sites, cell)
            row = [name, small.spacegroup_hm, len(small.sites), len(ours), len(sites), alone]
            if ase is not None:
                try:
                    atoms = ase.io.read(there)
                    places = [gemmi.Fractional(*place) for place in atoms.get_scaled_positions()]
                    theirs = list(zip(atoms.get_chemical_symbols(), places))
                    row += [len(theirs), unpaired(ours, theirs, cell)]
                except Exception as error:  # Mixed occupancies, and unknown space groups.
                    row += [type(error).__name__, ""]
            rows.append(row)
    return rows


def unpaired(ours, theirs, cell):
    """Atoms of either that have no partner of their element within 0.37 ångström, half a bond of H2, in the other."""
    left = list(theirs)
    alone = 0
    for symbol, place in ours:
        distances = [
            (cell.find_nearest_image(cell.orthogonalize(place), cell.orthogonalize(other), gemmi.Asu.Any).dist(), n)
            for n, (known, other) in enumerate(left)
            if known == symbol
        ]
        distance, n = min(distances, default=(9.0, -1))
        if distance < 0.37:
            left.pop(n)
        else:
            alone += 1
    return alone + len(left)


def main():
    binary, *folders = sys.argv[1:]
    folders.insert(0, os.path.join(os.path.dirname(MDAnalysisTests.__file__), "data"))
    versions = f"gemmi {gemmi.__version__}, MDAnalysis {MDAnalysis.__version__}, ParmEd {parmed.__version__}"
    print(f"{versions}; {', '.join(os.path.basename(os.path.dirname(f + '/')) for f in folders)}\n")
    differences = collections.Counter()
    rows, sites, refused = structures(binary, folders, differences)
    print("| of | files | elements | against | files | atoms | different | of them explained |")
    print("|---|---|---|---|---|---|---|---|")
    for key, row in sorted(rows.items()):
        counts = [f"{row[of]:,}" for of in ("files", "atoms", "different", "explained")]
        print("| " + " | ".join([*key, *counts]) + " |")
    made, more = topologies(binary, folders, differences)
    print("\n| names of topologies, written as | topologies | atoms | different | of them explained | of unknown mass |")
    print("|---|---|---|---|---|---|")
    for layout, row in made.items():
        counts = [f"{row[of]:,}" for of in ("files", "atoms", "different", "explained", "unknown")]
        print("| " + " | ".join([layout, *counts]) + " |")
    print("\n| crystal | space group | listed | halfline | gemmi | without partner | ASE | without partner |")
    print("|---|---|---|---|---|---|---|---|")
    for row in crystals(binary, folders):
        print("| " + " | ".join(map(str, row)) + " |")
    wrong = report(differences, sites)
    print("\nNot read:\n")
    for path, program, why in refused + more:
        print(f"{os.path.basename(path)} by {program}: {' '.join(why.split())[:160]}")
    print(f"\n{sum(differences.values())} differences; {wrong} of them, or atoms of one program alone, unexplained")
    return 1 if wrong else 0


def report(differences, sites):
    """Prints the differences, explained and not, and the atoms of one program only. Returns the number unexplained."""
    reasons, wrong = collections.defaultdict(list), []
    for key, count in differences.most_common():
        why = explanation(key)
        (wrong if why is None else reasons[why]).append((count, key))
    print("\n| atoms | against | in | for example: halfline, the other | why |\n|---|---|---|---|---|")
    for why, those in sorted(reasons.items(), key=lambda item: -sum(count for count, _ in item[1])):
        programs, names = (", ".join(sorted({key[part] for _, key in those})) for part in (0, 1))
        residue, name, ours, other = (part or "none" for part in those[0][1][2:])
        total = sum(count for count, _ in those)
        print(f"| {total:,} | {programs} | {names} | {residue} {name}: {ours}, {other} | {why} |")
    print("\nDifferences that nothing explains: times, program or layout, file, residue, atom, halfline, the other.\n")
    for count, key in wrong:
        print(f"{count:6} {' '.join(part or '-' for part in key)}")
    print("\nIn one program alone: times, program, file, name.\n")
    for key, count in sites.most_common():
        known = re.fullmatch(VIRTUAL, key[2])
        print(f"{count:6} {' '.join(key)}{' (virtual site)' if known else ''}")
        if not known:
            wrong.append((count, key))
    return sum(count for count, _ in wrong)


if __name__ == "__main__":
    sys.exit(main())
