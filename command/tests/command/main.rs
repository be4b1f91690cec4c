//! Promises of the command line, on the CPU path.

#[path = "../../../tests/common/amount.rs"]
mod amount;
#[path = "../../../tests/common/data.rs"]
mod data;
#[path = "../../../tests/common/nff.rs"]
mod nff;
#[path = "../../../tests/common/numpy.rs"]
mod numpy;
#[path = "../common/page.rs"]
mod page;
#[path = "../../../tests/common/random_frames.rs"]
mod random_frames;
#[path = "../../../tests/common/rng.rs"]
mod rng;
#[path = "../../../tests/common/skip.rs"]
mod skip;
#[path = "../common/test_dir.rs"]
mod test_dir;

mod blocks;
mod cameras;
mod clash;
mod clouds;
mod compare;
mod controls;
mod curved;
mod cuts;
mod echoes;
mod exit_codes;
#[cfg(unix)]
mod farm;
#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod faults;
mod figures;
mod film;
mod films;
mod framing;
mod habits;
mod info;
mod insets;
#[cfg(target_os = "linux")]
mod lens;
mod lenses;
mod light;
mod limits;
mod looks;
mod marks;
mod materials;
mod mattes;
mod mends;
mod merge;
mod messages;
mod models;
mod one_look;
mod opacity;
mod options;
mod pages;
mod parts;
mod pictures;
mod provenance;
mod requests;
mod resume;
mod select;
mod shots;
mod sizes;
mod sky;
#[cfg(unix)]
mod streams;
mod tables;
mod trace;
mod types;
#[cfg(unix)]
mod view;
mod ways;
mod ways_table;
mod words;
