//! Promises about what is computed, on the CPU path and on the adapter that the tests are pinned to.

#[path = "../common/adapter.rs"]
mod adapter;
#[path = "../common/amount.rs"]
mod amount;
#[path = "../common/bits.rs"]
mod bits;
#[path = "../common/data.rs"]
mod data;
#[path = "../common/given_families.rs"]
mod given_families;
#[path = "../common/home.rs"]
mod home;
#[path = "../common/nff.rs"]
#[expect(dead_code, reason = "the other test programs use more of it")]
mod nff;
#[path = "../common/planets.rs"]
mod planets;
#[path = "../common/rng.rs"]
#[expect(dead_code, reason = "the other test programs use more of it")]
mod rng;
#[path = "../common/skip.rs"]
mod skip;

mod by_method;
mod cloud;
mod crop;
mod curved;
mod cut_mirrors;
mod cuts;
mod depth_of_field;
mod eclipse;
mod extremes;
mod fast;
mod frames;
mod given;
mod instances;
mod layers;
mod lecture;
mod light;
mod light_on_device;
mod metamorphic;
mod oblique;
mod off_center;
mod ortho;
mod parts;
mod plan;
mod predict;
mod progress;
mod samples;
mod score;
mod selftest;
mod splat;
mod stream;
mod streams;
mod threads;
mod truth;
mod twins;
mod units;
mod weekend;
