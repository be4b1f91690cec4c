//! The promise: a reader returns a scene or an error for any file. It does not panic, its memory is bounded by the size
//! of the file, and it ends in bounded time. Seeds are fixed. `HALFLINE_FUZZ_RUNS=100000` runs longer than the suite
//! does, `HALFLINE_FUZZ_FORMAT=ply` only one format.

#![expect(unsafe_code, reason = "a global allocator needs it")]

#[path = "common/damage.rs"]
mod damage;
#[path = "common/data.rs"]
#[expect(dead_code, reason = "seeds are optional: no test is skipped without them")]
mod data;
#[path = "common/rng.rs"]
#[expect(dead_code, reason = "files need no real numbers")]
mod rng;
#[path = "common/skip.rs"]
mod skip;

use damage::damage;
use flate2::Compression;
use flate2::write::{DeflateEncoder, GzEncoder};
use halfline_files::read::style::{Coloring, Scale, Style};
use halfline_files::read::{Format, ReadOptions, Sequence};
use rng::Rng;
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Counts the bytes that are allocated, and their largest number.
struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(LIVE.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes that a reader may hold beyond [`PER_BYTE`] for every byte of the file: buffers and decompressors.
const FREE: usize = 64 << 20;
const PER_BYTE: usize = 64;
/// More time than any file of this size takes.
const SLOWEST: Duration = Duration::from_secs(10);

/// The compression of a file's content.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wrap {
    Plain,
    Gzip,
    Bzip2,
    Stored,
    Deflated,
}

impl Wrap {
    fn around(self, content: &[u8]) -> Vec<u8> {
        let deflate = |bytes: &[u8]| {
            let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
            encoder.write_all(bytes).expect("in memory");
            encoder.finish().expect("in memory")
        };
        match self {
            Self::Plain => content.to_vec(),
            Self::Gzip => {
                let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
                encoder.write_all(content).expect("in memory");
                encoder.finish().expect("in memory")
            }
            Self::Bzip2 => {
                let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
                encoder.write_all(content).expect("in memory");
                encoder.finish().expect("in memory")
            }
            Self::Stored => archive(&[("positions.npy", content, None), ("radii.npy", &radii(), None)]),
            Self::Deflated => {
                let (positions, radii) = (deflate(content), radii());
                let packed = deflate(&radii);
                archive(&[("positions.npy", &positions, Some(content)), ("radii.npy", &packed, Some(&radii))])
            }
        }
    }
}

/// A file of an archive: name, bytes, and the bytes before deflation.
type Member<'a> = (&'a str, &'a [u8], Option<&'a [u8]>);

/// A zip file of these members.
fn archive(members: &[Member<'_>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, packed, content) in members {
        let whole = content.unwrap_or(packed);
        let mut crc = flate2::Crc::new();
        crc.update(whole);
        bytes.extend(b"PK\x03\x04\x14\x00\x00\x00");
        bytes.extend([if content.is_some() { 8 } else { 0 }, 0, 0, 0, 0, 0]);
        [crc.sum(), packed.len() as u32, whole.len() as u32].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        bytes.extend((name.len() as u16).to_le_bytes());
        bytes.extend([0, 0]);
        bytes.extend(name.as_bytes());
        bytes.extend(*packed);
    }
    bytes.extend(b"PK\x05\x06");
    bytes
}

fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn radii() -> Vec<u8> {
    npy("'<f8'", "(2,)", &doubles(&[0.5, 1.5]))
}

fn ply(form: &str, vertices: &[u8]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {form} 1.0\ncomment small\nelement face 1\nproperty list uchar int i\nelement vertex 2\n\
         property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nproperty list uchar uchar l\nproperty float radius\nelement edge 1\nproperty int a\n\
         end_header\n"
    )
    .into_bytes();
    bytes.extend(vertices);
    bytes
}

const NATIVE: &str = "[camera]\neye = [0, 0, 5.5]\nat = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 20\n\
    [image]\nsize = [120, 67]\nbackground = [0.5, 0.25, 1.0]\n\
    [[sphere]]\ncenter = [0.1, 0x10, 3]\nradius = 2.5\ncolor = [1, 0.5, 0]\n";
const NFF: &str = "b 0.5 0.25 1\nv\nfrom 0 0 5.5\nat 0 0 0\nup 0 1 0\nangle 20\nhither 0.01\nresolution 120 67\n\
    l 4 3 2\ns 0 1 -1e-3 1\nf 1 0.5 0 0.8 0 100 0 1\np 3\n0 0 0\n1 0 0\n0 1 0\nc\n0 0 0 1\n1 1 1 0\ns 0.1 16 9 2.5\n";
const XYZ: &str = "2\nwater\nO 0 0 0\nH1 1 0 -1e-1\n1\nLattice=\"1 0 0 0 2 0 0 0 3\" \
    Properties=species:S:1:pos:R:3:vel:R:3:radius:R:1 pbc=\"T T F\"\nFe 1 2 3 4 5 6 0.5\n";
const PQR: &str = "REMARK   1 PQR\n\
    ATOM      1  N    MET     1     -11.921   26.307   10.410 -0.3000 1.8500\n\
    ATOM      2  CA  MET A   1     -11.500  26.000  10.000  0.2000 2.0000\n\
    HETATM99999  H1  WAT B  -7A   -100.123-200.456-300.789  0.4170 0.0000\nTER\nEND\n";

const PDBQT: &str = "REMARK  Name = ligand\nROOT\n\
    ATOM      1  C1  UNL A   1      31.770  31.020  29.720  0.00  0.00    +0.007 A \n\
    ENDROOT\nBRANCH   1   2\n\
    ATOM      2  O1  UNL A   1      32.630  34.390  30.940  0.00  0.00    -0.507 OA\n\
    ENDBRANCH   1   2\nTORSDOF 1\n";

const PDB: &str = "HEADER    SMALL\n\
    REMARK 350 BIOMOLECULE: 1\n\
    REMARK 350 APPLY THE FOLLOWING TO CHAINS: A, B\n\
    REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000\n\
    REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000\n\
    REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000\n\
    CRYST1   10.000   20.000   30.000  90.00 100.00  90.00 P 1           1\n\
    MODEL        1\n\
    ATOM      1  N  AMET A   1      27.340  24.430   2.614  0.50  9.67           N\n\
    ATOM      2  CA BMET A   1      26.266  25.413   2.842  0.50 10.38           C\n\
    HETATM    3 FE   HEM B   2      26.913  26.639  -3.531  1.00  9.62          FE\n\
    ENDMDL\nMODEL        2\n\
    ATOM      1  N   MET A   1      27.340  24.430   2.614  1.00  9.67           N\n\
    ENDMDL\nEND\n";
const CIF: &str = "data_SMALL\n_cell.length_a 10.0\n_cell.length_b 20\n_cell.length_c 30\n_cell.angle_alpha 90\n\
    _cell.angle_beta 100\n_cell.angle_gamma 90\n#\nloop_\n_atom_site.group_PDB\n_atom_site.id\n\
    _atom_site.type_symbol\n_atom_site.label_atom_id\n_atom_site.label_alt_id\n_atom_site.label_asym_id\n\
    _atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n_atom_site.occupancy\n_atom_site.B_iso_or_equiv\n\
    _atom_site.pdbx_PDB_model_num\nATOM 1 N N . A 1.5 2 -3 1.0 20.1 1\nATOM 2 C \"C'\" A A 4 5 6 0.5 ? 1\n\
    HETATM 3 FE FE B B 7 8 9 0.5 3 2\n#\n_pdbx_struct_assembly_gen.assembly_id 1\n\
    _pdbx_struct_assembly_gen.oper_expression '(1-2)(1,2)'\n_pdbx_struct_assembly_gen.asym_id_list A,B\n\
    loop_\n_pdbx_struct_oper_list.id\n\
    _pdbx_struct_oper_list.matrix[1][1]\n_pdbx_struct_oper_list.matrix[1][2]\n_pdbx_struct_oper_list.matrix[1][3]\n\
    _pdbx_struct_oper_list.vector[1]\n\
    _pdbx_struct_oper_list.matrix[2][1]\n_pdbx_struct_oper_list.matrix[2][2]\n_pdbx_struct_oper_list.matrix[2][3]\n\
    _pdbx_struct_oper_list.vector[2]\n\
    _pdbx_struct_oper_list.matrix[3][1]\n_pdbx_struct_oper_list.matrix[3][2]\n_pdbx_struct_oper_list.matrix[3][3]\n\
    _pdbx_struct_oper_list.vector[3]\n1 1 0 0 0 0 1 0 0 0 0 1 0\n2 -1 0 0 1 0 -1 0 2 0 0 1 3\n\
    _struct.title\n;a text\nof lines\n;\n";
const CRYSTAL: &str = "data_x\n_chemical_formula_sum 'Ca O'\n_symmetry_space_group_name_H-M 'P -1'\n_cell_length_a 4.0(1)\n\
    _cell_length_b 4\n_cell_length_c 5\n_cell_angle_alpha 90\n_cell_angle_beta 100\n_cell_angle_gamma 120\nloop_\n\
    _symmetry_equiv_pos_as_xyz\nx,y,z\n'-x, 1/2-y, z+.5'\nloop_\n_atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n\
    _atom_site_fract_z\n_atom_site_calc_flag\nCA1 0 0 0.333 d\nO1 0.25(2) 0.25 -0.25 d\nCg 0.1 0.1 0.1 dum\n";
const GRO: &str = "Water t= 0.0\n    3\n    1SOL    OW1    1   0.126   1.624   1.679  0.1227 -0.0580  0.0434\n    \
    1SOL    HW2    2   0.190   1.661   1.747  0.8085  0.3191 -0.7791\n    \
    1SOL    HW3    3   0.177   1.568   1.613 -0.9045 -2.6469  1.3180\n   1.82060   1.82060   1.82060\n";
const DUMP: &str = "ITEM: UNITS\nlj\nITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n-1 1\n0 4\n\
    0 8\nITEM: ATOMS id type x y z vx radius\n2 1 0 1 2 -5 0.5\n1 2 3 4 5 6e1 1.5\nITEM: TIMESTEP\n8\n\
    ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS xy xz yz pp pp pp\n-3 4 -3\n0 7 2\n0 5 1\nITEM: ATOMS xs ys zs element\n\
    0.5 0.5 0.25 Fe\n";
const DATA: &str = "by hand\n\n2 atoms\n2 atom types\n0 2 xlo xhi\n-1 3 ylo yhi\n0 5 zlo zhi\n0.5 0 -1 xy xz yz\n\n\
    Masses\n\n1 1.008\n2 15.9994\n\nPair Coeffs\n\n1 1 1\n\nAtoms # full\n\n7 1 2 -0.8 1 2 3 0 0 1\n3 1 1 0.4 4 5 6 0 0 0\n\n\
    Velocities\n\n3 0 0 9\n7 0 0 8\n";
const CSV: &str =
    "# a table\nname,x_km,y_km,z_km,radius_km,vx,red,green,blue\n\"a, b\",1,2,3,0.5,7,1,0.5,0\nc,4,5,6,1.5,8,0,0,1\n";

/// Small valid files of a format.
fn seeds(format: Format) -> Vec<(Vec<u8>, Wrap)> {
    let text = |texts: &[&str]| texts.iter().map(|text| (text.as_bytes().to_vec(), Wrap::Plain)).collect::<Vec<_>>();
    let arrays = || {
        let records = "[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('v', '<i2', (3,)), ('n', '|S2')]";
        [
            npy("'<f8'", "(2, 3)", &doubles(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
            npy("'<f8'", "(1, 7)", &doubles(&[1.0, 2.0, 3.0, 4.0, 0.5, 0.6, 1.0])),
            npy("'>f8'", "(1, 4)", &doubles(&[1.0, 2.0, 3.0, 4.0])),
            npy(records, "(2,)", &[7; 40]),
        ]
    };
    match format {
        Format::Native => text(&[NATIVE]),
        Format::Nff => text(&[NFF]),
        Format::Xyz => text(&[XYZ]),
        Format::Pdb => text(&[PDB]),
        Format::Pqr => text(&[PQR]),
        Format::Pdbqt => text(&[PDBQT]),
        Format::Mmcif => text(&[CIF, CRYSTAL]),
        Format::Gro => text(&[GRO]),
        Format::Dump => text(&[DUMP]),
        Format::Data => text(&[DATA, &DATA.replace(" # full", "")]),
        Format::Ply => {
            let vertices = |big: bool| {
                let word = |x: f32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
                let mut bytes = vec![1, 0, 0, 0, 0];
                for _ in 0..2 {
                    [1.0, 2.0, 3.0].iter().for_each(|x| bytes.extend(word(*x)));
                    bytes.extend([255, 0, 7, 2, 1, 1]);
                    bytes.extend(word(0.5));
                }
                bytes
            };
            let ascii = b"1 0\n1 2 3 255 0 7 2 1 1 0.5\n4 5 6 0 0 0 0 1.5\n0\n";
            let forms = [
                ply("ascii", ascii),
                ply("binary_little_endian", &vertices(false)),
                ply("binary_big_endian", &vertices(true)),
            ];
            forms.into_iter().map(|bytes| (bytes, Wrap::Plain)).collect()
        }
        Format::Csv => text(&[CSV, &CSV.replace(',', "\t"), "# x y z t\n1 2 3 4\n5 6 7 nan\n"]),
        Format::Npy => arrays().into_iter().map(|bytes| (bytes, Wrap::Plain)).collect(),
        Format::Npz => {
            let [positions, ..] = arrays();
            vec![(positions.clone(), Wrap::Stored), (positions, Wrap::Deflated)]
        }
        Format::Xtc | Format::Trr | Format::Dcd | Format::Poscar | Format::Pcd | Format::Las | Format::Gsd => {
            corpus(format)
        }
        other => panic!("{other:?} has no seeds: write some"),
    }
}

/// The seeds of binary formats, which are in the corpus of the fuzzer; the first byte of an input selects options.
fn corpus(format: Format) -> Vec<(Vec<u8>, Wrap)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(format.name());
    let entries = std::fs::read_dir(folder).expect("a folder of inputs").map(|entry| entry.expect("an entry").path());
    let mut seeds: Vec<_> = entries.filter(|path| path.file_name().is_some_and(|name| name.len() < 40)).collect();
    seeds.sort();
    seeds.into_iter().map(|path| (std::fs::read(path).expect("an input")[1..].to_vec(), Wrap::Plain)).collect()
}

/// The beginnings of real files, if there are any.
fn real(format: Format) -> Vec<(Vec<u8>, Wrap)> {
    const NAMES: [&str; 9] = [
        "1IHM.pdb",
        "1tii.pdb",
        "3SN6.cif",
        "balls_s2.nff",
        "balls_s4.nff",
        "jacks.nff",
        "shells.nff",
        "solar_system.csv",
        "1hvr.pdb",
    ];
    let of_format = |name: &&str| name.ends_with(&format!(".{}", format.name()));
    let start = |name: &str| {
        let bytes = std::fs::read(data::real(name)?).ok()?;
        Some((bytes[..bytes.len().min(4096)].to_vec(), Wrap::Plain))
    };
    NAMES.into_iter().filter(of_format).filter_map(start).collect()
}

/// Options that select different paths of the readers.
fn options(format: Format, rng: &mut Rng) -> ReadOptions {
    let mut options = ReadOptions { frames: "1-".parse().expect("frames"), ..ReadOptions::default() };
    options.format = (rng.below(4) > 0).then_some(format);
    options.strict = rng.below(8) == 0;
    if rng.below(2) == 0 {
        let columns = ["vx", "vel", "radius", "z", "id", "red", "b_iso_or_equiv", "bfactor", "t", "x"];
        let columns = (0..=rng.below(3)).map(|_| rng.pick(&columns).to_owned()).collect();
        let scale = Scale { log: rng.below(2) == 0, ..Scale::of(columns) };
        options.style = Style { coloring: Coloring::Column(scale), ..Style::default() };
    }
    match rng.below(8) {
        0 => options.model = Some(rng.below(4) as i64),
        1 => options.altloc = ["highest", "A"][rng.below(2)].parse().expect("an alternate location"),
        2 => options.assembly = Some("1".into()),
        3 => options.frames = "2-".parse().expect("frames"),
        _ => {}
    }
    options
}

/// Reads a whole file; returns whether it has a frame.
fn read(path: &Path, options: &ReadOptions) -> bool {
    let Ok(mut sequence) = Sequence::open(path, options) else { return false };
    let mut found = false;
    while let Ok(Some(shot)) = sequence.next_scene() {
        shot.scene.check().expect("what is read can be rendered");
        found = true;
    }
    found
}

#[test]
fn no_file_makes_a_reader_panic_or_hold_too_much_memory() {
    let runs: usize = std::env::var("HALFLINE_FUZZ_RUNS").map_or(300, |runs| runs.parse().expect("a number of runs"));
    let only = std::env::var("HALFLINE_FUZZ_FORMAT").ok();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("fuzzed");
    let all: Vec<_> = Format::ALL.iter().flat_map(|format| seeds(*format)).collect();
    panic::set_hook(Box::new(|_| {}));
    let mut failures = Vec::new();
    for format in Format::ALL.iter().copied().filter(|format| only.as_deref().is_none_or(|only| only == format.name()))
    {
        let mut seeds = seeds(format);
        for (bytes, wrap) in seeds.clone() {
            std::fs::write(&path, wrap.around(&bytes)).expect("a temporary file");
            let options = ReadOptions { format: Some(format), ..ReadOptions::default() };
            assert!(read(&path, &options), "the seed of {format:?} is a file of it");
        }
        if seeds[0].1 == Wrap::Plain {
            seeds.extend([(seeds[0].0.clone(), Wrap::Gzip), (seeds[0].0.clone(), Wrap::Bzip2)]);
        }
        seeds.extend(real(format));
        let mut rng = Rng::new(0x9e37_79b9_7f4a_7c15 ^ format.name().len() as u64);
        let (begun, mut read_some, mut most) = (Instant::now(), 0, 0);
        for run in 0..runs {
            let (content, wrap) = &seeds[rng.below(seeds.len())];
            let mut content = content.clone();
            let inside = *wrap == Wrap::Plain || rng.below(2) == 0;
            let mut bytes = if inside { Vec::new() } else { wrap.around(&content) };
            let target = if inside { &mut content } else { &mut bytes };
            for _ in 0..=rng.below(4) {
                let other = &all[rng.below(all.len())].0;
                damage(target, other, &mut rng);
            }
            let bytes = if inside { wrap.around(&content) } else { bytes };
            std::fs::write(&path, &bytes).expect("a temporary file");
            let options = options(format, &mut rng);
            let (started, live) = (Instant::now(), LIVE.load(Relaxed));
            PEAK.store(live, Relaxed);
            let outcome = panic::catch_unwind(AssertUnwindSafe(|| read(&path, &options)));
            let grown = PEAK.load(Relaxed).saturating_sub(live);
            most = most.max(grown);
            read_some += usize::from(*outcome.as_ref().unwrap_or(&false));
            let fault = match outcome {
                Err(panic) => {
                    let text = panic.downcast_ref::<String>().cloned();
                    text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()))
                }
                Ok(_) if grown > FREE + PER_BYTE * bytes.len() => Some(format!("{grown} bytes were held")),
                Ok(_) if started.elapsed() > SLOWEST => Some(format!("it took {:?}", started.elapsed())),
                Ok(_) => None,
            };
            if let Some(fault) = fault {
                let hex: String = bytes.iter().take(8192).map(|byte| format!("{byte:02x}")).collect();
                failures.push(format!(
                    "{} run {run}: {fault}; {options:?}; {} bytes {hex}",
                    format.name(),
                    bytes.len()
                ));
            }
        }
        println!(
            "{:>5}: {runs} runs in {:.1} s, {read_some} of them read, at most {} KiB held",
            format.name(),
            begun.elapsed().as_secs_f64(),
            most >> 10
        );
    }
    drop(panic::take_hook());
    assert!(
        failures.is_empty(),
        "{} failures, the first:\n{}",
        failures.len(),
        failures[..failures.len().min(3)].join("\n")
    );
}
