//! Promises of the command line on the CPU path and on the adapter that the tests are pinned to.

#[path = "../../../tests/common/adapter.rs"]
#[expect(dead_code, reason = "the other test programs use more of it")]
mod adapter;
#[path = "../../../tests/common/data.rs"]
#[expect(dead_code, reason = "the other test programs use more of it")]
mod data;
#[cfg(unix)]
#[path = "../common/page.rs"]
#[expect(dead_code, reason = "the other test programs use more of it")]
mod page;
#[path = "../../../tests/common/rng.rs"]
#[expect(dead_code, reason = "the other test programs use more of it")]
mod rng;
#[path = "../../../tests/common/skip.rs"]
mod skip;
#[path = "../common/test_dir.rs"]
#[expect(dead_code, reason = "the other test programs use more of it")]
mod test_dir;

mod command;
mod measure;
mod selftest;
mod trace;
#[cfg(unix)]
mod view;
