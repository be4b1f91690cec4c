//! The promise of `halfline view` on the adapter: a still has the bytes of the copied command.

use crate::adapter::gpu_or_skip;
use crate::page::check_stills;
use crate::test_dir::{SCENE, TestDir};

#[test]
fn a_still_of_the_adapter_has_the_bytes_of_its_command() {
    if gpu_or_skip().is_none() {
        return;
    }
    let table = "x,y,z,radius,kind\n0,0,0,1,a\n2,0,0,0.7,b\n0,2,0,0.5,a\n1,1,1,0.6,c\n";
    let dir = TestDir::new(&[("s.toml", SCENE), ("t.csv", table)]);
    check_stills(&dir, "s.toml --backend gpu", None);
    check_stills(&dir, "t.csv --backend gpu --color-by kind", Some("kind a"));
}
