//! The promise of the scripts in `farm/`: each makes the frame of a single process, here under stand-ins of its scheduler.

use crate::test_dir::TestDir;
use std::path::Path;
use std::process::{Command, Output};

/// As sbatch of Slurm 24.05: reads the options of the script too, runs its array in turn, and sends the signal of `B:` to the batch
/// process after a moment. It prints the number of a job.
const SBATCH: &str = r#"#!/usr/bin/env bash
set -u
array=1 wrap=
while [[ ${1:-} == -* ]]; do
    case "$1" in
        --array=*) array="${1#*=}" ;;
        --export=ALL,*) export "${1#*ALL,}" ;;
        --wrap) wrap="$2"; shift ;;
        --parsable | --dependency=afterok:*) ;;
        *) echo "sbatch: unrecognized option $1" >&2; exit 1 ;;
    esac
    shift
done
if [[ -n $wrap ]]; then exec bash -c "$wrap"; fi
export SLURM_ARRAY_TASK_MIN="${array%%-*}" SLURM_ARRAY_TASK_MAX="${array##*-}"
export SLURM_ARRAY_TASK_COUNT=$((SLURM_ARRAY_TASK_MAX - SLURM_ARRAY_TASK_MIN + 1))
for ((task = SLURM_ARRAY_TASK_MIN; task <= SLURM_ARRAY_TASK_MAX; task++)); do
    SLURM_ARRAY_TASK_ID=$task bash "$@" &
    if [[ -n ${ENDS_EARLY:-} ]]; then
        sleep 1
        if grep -q '^#SBATCH --signal=B:TERM@' "$1"; then kill -TERM $!; fi
    fi
    wait $! || exit
done
echo 42
"#;

/// As GNU parallel, for the options of the script.
const PARALLEL: &str = r#"#!/usr/bin/env bash
set -eu
while [[ $1 == --* ]]; do shift 2; done
words=()
while [[ $1 != ::: ]]; do words+=("$1"); shift; done
shift
for value; do "${words[@]//\{\}/$value}"; done
"#;

const SCENE: &str = "[camera]\neye = [0, 0, 5]\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [64, 48]\n\
                     [[spheres]]\nfile = \"a b.csv\"\n";

/// A scene, its picture by one process, and the stand-ins.
fn dir() -> TestDir {
    let dir = TestDir::new(&[("s.toml", SCENE), ("a b.csv", "x,y,z,radius\n0,0,0,1\n1,0,0,0.5\n")]);
    dir.put("b.csv", "x,y,z,radius\n-1,0.5,0,0.7\n");
    std::fs::create_dir(dir.path("bin")).expect("a folder");
    for (name, text) in [("sbatch", SBATCH), ("parallel", PARALLEL)] {
        dir.put(&format!("bin/{name}"), text);
        let status = Command::new("chmod").arg("+x").arg(dir.path(&format!("bin/{name}"))).status();
        assert!(status.expect("chmod").success());
    }
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_halfline"), dir.path("bin/halfline")).expect("a link");
    dir.good("render s.toml --backend cpu -o one.png");
    dir
}

fn script(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the root");
    root.join("farm").join(name).display().to_string()
}

/// Runs a line of a shell that finds the stand-ins.
fn shell(dir: &TestDir, line: &str) -> Output {
    let path = format!("{}:{}", dir.path("bin").display(), std::env::var("PATH").expect("PATH"));
    dir.program("bash").env("PATH", path).args(["-c", line]).output().expect("bash")
}

fn good(dir: &TestDir, line: &str) {
    let ran = shell(dir, line);
    assert!(ran.status.success(), "{line}: {}", String::from_utf8_lossy(&ran.stderr));
}

/// The message of a line that ends with this exit code.
fn refused(dir: &TestDir, code: i32, line: &str) -> String {
    let ran = shell(dir, line);
    let message = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(code), "{line}: {message}");
    message
}

#[test]
fn a_slurm_array_makes_the_tiles_of_one_picture() {
    let (dir, slurm) = (dir(), script("slurm.sh"));
    let tiles = format!("{slurm} s.toml out --backend cpu");
    let merge = "sbatch --dependency=afterok:$t --wrap 'halfline merge out/tile.*.png -o out/full.png'";
    good(&dir, &format!("t=$(sbatch --parsable --array=1-4 {tiles}) && {merge}"));
    assert!(dir.get("out/full.png") == dir.get("one.png"), "the bytes of one process");
    // One tile again, of four.
    let tile = dir.get("out/tile.3.png");
    dir.remove("out/tile.3.png");
    for array in ["3", "2-3", "0-3"] {
        let message = refused(&dir, 2, &format!("sbatch --array={array} {tiles}"));
        assert!(message.contains("TILES=N"), "{message}");
    }
    good(&dir, &format!("sbatch --export=ALL,TILES=4 --array=3 {tiles}"));
    assert!(dir.get("out/tile.3.png") == tile, "the same tile");
}

#[test]
fn the_signal_of_slurm_arrives_and_leaves_no_file() {
    let (dir, slurm) = (dir(), script("slurm.sh"));
    let long = "--size 4000x3000 --samples 400 --look figure --backend cpu";
    refused(&dir, 130, &format!("ENDS_EARLY=1 sbatch --array=1-1 {slurm} s.toml out {long}"));
    assert_eq!(std::fs::read_dir(dir.path("out")).expect("a folder").count(), 0);
}

#[test]
fn a_slurm_array_sifts_a_file_for_each_line() {
    let (dir, parts) = (dir(), script("parts_slurm.sh"));
    let camera = "--eye 0,0,5 --at 0,0,0 --vfov 40 --size 64x48";
    for (end, folder) in [("\n", "a"), ("", "b"), ("\r\n", "c")] {
        dir.put("files.txt", format!("a b.csv 0{}b.csv 2{end}", if end == "\r\n" { end } else { "\n" }));
        let render = format!(
            "sbatch --dependency=afterok:$p --wrap 'halfline render --visible {folder}/*.npz --backend cpu -o {folder}.png'"
        );
        good(&dir, &format!("p=$(sbatch --parsable --array=1-2 {parts} files.txt {folder} {camera}) && {render}"));
        assert!(dir.get(&format!("{folder}.png")) == dir.get("a.png"), "{end:?}");
    }
    for line in ["3", "4"] {
        dir.put("files.txt", "a b.csv 0\nb.csv 2\nb.csv\n");
        let message = refused(&dir, 2, &format!("sbatch --array={line} {parts} files.txt d {camera}"));
        assert!(message.contains(&format!("files.txt: line {line}")), "{message}");
    }
}

#[test]
fn gnu_parallel_makes_and_merges_the_tiles() {
    let dir = dir();
    good(&dir, &format!("bash {} s.toml out --backend cpu", script("parallel.sh")));
    assert!(dir.get("out/full.png") == dir.get("one.png"));
}

/// The command of the Job, for each index, with another scene and a smaller picture; the image is of this version.
#[test]
fn an_indexed_job_makes_the_tiles_of_one_picture() {
    let (dir, yaml) = (dir(), std::fs::read_to_string(script("kubernetes.yaml")).expect("a file"));
    let version = format!("image: halfline:{}\n", env!("CARGO_PKG_VERSION"));
    assert!(yaml.contains(&version), "{version}");
    let (_, rest) = yaml.split_once(">-\n").expect("a folded text");
    let (folded, _) = rest.split_once("volumeMounts:").expect("its end");
    let command = folded.split_whitespace().collect::<Vec<_>>().join(" ");
    let work = dir.path("").display().to_string();
    let command = command.replace("/work/scene.pdb", "s.toml").replace("--assembly 1", "--backend cpu");
    let command = command.replace("4096x4096", "64x48").replace("/work/", &format!("{}/", work.trim_end_matches('/')));
    for index in 0..16 {
        good(&dir, &format!("export JOB_COMPLETION_INDEX={index}; {command}"));
    }
    good(&dir, "halfline merge tiles/tile.*.png -o full.png");
    assert!(dir.get("full.png") == dir.get("one.png"));
}
