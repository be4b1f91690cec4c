//! The promise of tables: columns are found by the names that other programs give them.

use crate::test_dir::TestDir;
use serde_json::json;

/// Three points with radii; the coordinates are exact in f32.
const PLAIN: &str = "radius,x,y,z\n0.5,1,2,3\n0.25,-1,2.5,3\n1,1,4,-3\n";

/// The same from ParaView's writer of CSV, and from its spreadsheet.
const PARAVIEW: &str = "\"radius\",\"Points:0\",\"Points:1\",\"Points:2\"\n0.5,1,2,3\n0.25,-1,2.5,3\n1,1,4,-3\n";
const SPREADSHEET: &str = "Point ID,radius,Points_0,Points_1,Points_2,Points_Magnitude\n\
    0,0.5,1,2,3,3.74166\n1,0.25,-1,2.5,3,4.03113\n2,1,1,4,-3,5.09902\n";

fn dir() -> TestDir {
    TestDir::new(&[("plain.csv", PLAIN), ("paraview.csv", PARAVIEW), ("spreadsheet.dat", SPREADSHEET)])
}

/// The ids and the distances of a small picture of a file.
fn picture(dir: &TestDir, file: &str, options: &[&str]) -> [Vec<f64>; 2] {
    let buffers = ["--size", "24x24", "--aov", "id=id.npy", "--aov", "distance=d.npy"];
    dir.render(&[&[file], options, &buffers[..]].concat());
    ["id.npy", "d.npy"].map(|name| dir.array(name).0)
}

#[test]
fn points_of_paraview_are_coordinates() {
    let dir = dir();
    for file in ["paraview.csv", "spreadsheet.dat"] {
        let info = dir.good(&["info", file, "--json"]).json();
        assert_eq!((&info["format"], &info["spheres"]), (&json!("csv"), &json!(3)), "{file}");
        assert_eq!(info["extent"], json!({"min": [-1.0, 2.0, -3.0], "max": [1.0, 4.0, 3.0]}), "{file}");
        let plain = picture(&dir, "plain.csv", &[]);
        assert!(plain[0].contains(&0.0) && plain[0].contains(&-1.0));
        assert_eq!(picture(&dir, file, &[]), plain, "{file}");
    }
}
