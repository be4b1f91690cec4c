//! Reading speed of text files: writes one of each format to a temporary folder, reads all its frames through the
//! library, each in a separate process, and prints a Markdown table. Processor time and peak memory come from
//! /proc/self on Linux; other load affects only the wall times.
//!
//! ```sh
//! cargo run --release --example read -- 1000            # megabytes a file
//! cargo run --release --example read -- 1000 csv xyz.gz # only these
//! ```

use flate2::{Compression, write::GzEncoder};
use halfline_files::read::{ParticleOptions, ReadOptions, Sequence};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

type Result<T = ()> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The file name extensions.
const FORMATS: [&str; 7] = ["xyz", "xyz.gz", "dump", "csv", "pdb", "cif", "gro"];

/// Atoms per frame; PDB and GRO number them with five digits.
const ATOMS: u32 = 200_000;
const NUMBERED: u32 = 99_999;

/// The beginning of a file, and the part that is repeated after it: a frame, or rows of its single frame.
fn text(ending: &str) -> Result<(String, String)> {
    // xorshift32, Marsaglia 2003: a number from -50 to 50.
    let mut state = 1_u32;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        f64::from(state) / f64::from(u32::MAX) * 100.0 - 50.0
    };
    let (mut head, mut body) = (String::new(), String::new());
    let count = if ["pdb", "gro"].contains(&ending) { NUMBERED } else { ATOMS };
    match ending {
        "xyz" | "xyz.gz" => write!(body, "{count}\nno properties\n")?,
        "dump" => write!(
            body,
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS pp pp pp\n-50 50\n-50 50\n-50 50\n\
             ITEM: ATOMS id type x y z\n"
        )?,
        "csv" => head.push_str("x,y,z,radius\n"),
        "pdb" => body.push_str("MODEL        1\n"),
        "gro" => write!(body, "atoms\n{count}\n")?,
        _ => {
            head.push_str("data_ATOMS\nloop_\n");
            let items = "group_PDB id type_symbol label_atom_id label_alt_id label_comp_id label_asym_id label_entity_id \
                         label_seq_id pdbx_PDB_ins_code Cartn_x Cartn_y Cartn_z occupancy B_iso_or_equiv pdbx_PDB_model_num";
            items.split(' ').try_for_each(|item| writeln!(head, "_atom_site.{item}"))?;
        }
    }
    for n in 1..=count {
        let [x, y, z] = [random(), random(), random()];
        let symbol = ["C", "N", "O", "H"][(n % 4) as usize];
        match ending {
            "xyz" | "xyz.gz" => writeln!(body, "{symbol} {x:.6} {y:.6} {z:.6}")?,
            "dump" => writeln!(body, "{n} 1 {x:.6} {y:.6} {z:.6}")?,
            "csv" => writeln!(body, "{x:.6},{y:.6},{z:.6},0.5")?,
            "pdb" => writeln!(
                body,
                "ATOM  {n:5}  {symbol:3} ALA A{:4}    {x:8.3}{y:8.3}{z:8.3}  1.00 20.00          {symbol:>2}  ",
                n % 10_000
            )?,
            "gro" => writeln!(body, "{n:5}SOL  {symbol:>5}{n:5}{x:8.3}{y:8.3}{z:8.3}")?,
            _ => writeln!(body, "ATOM {n} {symbol} {symbol} . ALA A 1 {n} ? {x:.3} {y:.3} {z:.3} 1.0 20.0 1")?,
        }
    }
    match ending {
        "pdb" => body.push_str("ENDMDL\n"),
        "gro" => body.push_str("  10.00000  10.00000  10.00000\n"),
        _ => {}
    }
    Ok((head, body))
}

/// Writes approximately `bytes` bytes of text in whole frames; returns the exact number.
fn generate(path: &Path, ending: &str, bytes: usize) -> Result<usize> {
    let (head, body) = text(ending)?;
    let file = BufWriter::new(File::create(path)?);
    let mut file: Box<dyn Write> = match ending {
        "xyz.gz" => Box::new(GzEncoder::new(file, Compression::fast())),
        _ => Box::new(file),
    };
    file.write_all(head.as_bytes())?;
    let times = bytes.div_ceil(body.len());
    (0..times).try_for_each(|_| file.write_all(body.as_bytes()))?;
    file.flush()?;
    Ok(head.len() + times * body.len())
}

/// Reads all frames and prints a row of the table; `bytes` is the length of the text.
fn read(path: &Path, ending: &str, bytes: f64) -> Result {
    let options = ReadOptions {
        particles: ParticleOptions { frames: "1-".parse()?, ..Default::default() },
        ..ReadOptions::default()
    };
    let began = Instant::now();
    let mut sequence = Sequence::open(path, &options)?;
    let (mut frames, mut atoms) = (0, 0);
    while let Some(shot) = sequence.next_scene()? {
        frames += 1;
        atoms += shot.scene.spheres.len();
    }
    let seconds = began.elapsed().as_secs_f64();
    // Processor time of all threads, user's and system's, in the hundredths of a second that Linux counts.
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let times = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    let busy = times.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
    let peak = peak.map_or("?".into(), |kib: f64| format!("{:.0}", kib / 1024.0));
    let megabytes = bytes / 1e6;
    let atoms = atoms as f64 / 1e6;
    println!(
        "| {ending} | {megabytes:.0} | {frames} | {atoms:.1} | {seconds:.2} | {:.0} | {busy:.2} | {:.0} | {peak} |",
        megabytes / seconds,
        megabytes / busy
    );
    Ok(())
}

fn main() -> Result {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [one, path, ending, bytes] = &arguments[..]
        && one == "--one"
    {
        return read(Path::new(path), ending, bytes.parse()?);
    }
    let megabytes: usize = arguments.first().map_or(Ok(100), |megabytes| megabytes.parse())?;
    let folder = tempfile::tempdir()?;
    println!("| format | MB of text | frames | 1e6 atoms | s | MB/s | processor s | MB a processor s | peak MiB |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for ending in FORMATS.iter().filter(|ending| arguments.len() < 2 || arguments[1..].iter().any(|a| a == *ending)) {
        let path = folder.path().join(format!("atoms.{ending}"));
        let bytes = generate(&path, ending, megabytes * 1_000_000)?;
        let mut child = Command::new(std::env::current_exe()?);
        if !child.arg("--one").arg(&path).arg(ending).arg(bytes.to_string()).status()?.success() {
            return Err(format!("{ending} was not read").into());
        }
        std::fs::remove_file(&path)?;
    }
    Ok(())
}
