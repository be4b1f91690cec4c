//! Promises of the readers of scenes and of the files of frames.

#[path = "../common/damage.rs"]
mod damage;
#[path = "../common/data.rs"]
mod data;
#[path = "../common/nff.rs"]
mod nff;
#[path = "../common/numpy.rs"]
mod numpy;
#[path = "../common/random_frames.rs"]
mod random_frames;
#[path = "../common/rng.rs"]
mod rng;
#[path = "../common/skip.rs"]
mod skip;

mod added;
mod broken;
mod copies;
mod formats;
mod frames;
mod identity;
mod light_buffers;
mod mattes;
mod molecules;
mod people;
mod readers;
mod scenes;
