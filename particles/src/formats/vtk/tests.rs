//! Files of other programs, and files that are written here.

use crate::Frames;
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::request::Request;
use crate::particles::vectors::component;
use crate::source::Source;
use crate::{Format, ParticleOptions};
use halfline_ground::error::Result;
use serde_json::Value;
use std::path::Path;

fn frames(bytes: &[u8], columns: &[&str]) -> Result<Box<dyn ParticleFrames>> {
    let opened = Format::VTK.frames(Source::of_bytes(bytes), Request::of(columns), false)?;
    Ok(opened.unwrap_or_else(|_| panic!("VTK has frames")))
}

fn frame(bytes: &[u8], columns: &[&str]) -> Result<Particles> {
    Ok(frames(bytes, columns)?.next()?.expect("a frame"))
}

/// A number of JSON, which has no words for those that are not finite.
fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).expect("a number")
}

/// The files with the numbers that they were written from, by tests/independent/vtk.py.
macro_rules! samples {
    ($($name:literal)*) => {
        [$(($name, &include_bytes!(concat!("samples/", $name))[..], include_str!(concat!("samples/", $name, ".json"))),)*]
    };
}

#[test]
fn files_of_vtk_meshio_and_of_no_program_have_the_numbers_that_they_were_written_from() {
    let samples = samples!(
        "vtk_appraw_zlib_u32_le.vtp" "vtk_inline_lz4_u32_be.vtu" "vtk_appbase64_lzma_u64_be.vtu" "meshio_zlib_u64.vtu"
        "vtkleg_51_bin_poly.vtk" "hand_51_asc_metadata.vtk" "hand_trap_raw.vtp"
    );
    for (name, bytes, truth) in samples {
        let truth: Value = serde_json::from_str(truth).expect("JSON");
        let found = frame(bytes, &["*"]).unwrap_or_else(|error| panic!("{name}: {error}"));
        let points: Vec<Vec<f64>> = serde_json::from_value(truth["points"].clone()).expect("points");
        assert_eq!(found.positions.iter().map(|point| point.to_vec()).collect::<Vec<_>>(), points, "{name}");
        assert_eq!(found.when.time, truth["time"].as_f64(), "{name}");
        let arrays = truth["arrays"].as_object().expect("arrays");
        for (array, truth) in arrays {
            let components = truth["components"].as_u64().expect("a number") as usize;
            let values: Vec<f64> = truth["values"].as_array().expect("values").iter().map(number).collect();
            for k in 0..components {
                let own = if components == 1 { array.clone() } else { component(array, k) };
                // A colour of three or four numbers.
                let column = found.column(&own).or_else(|| found.column(["r", "g", "b"][k])).expect(&own);
                let expected: Vec<f64> = values.iter().skip(k).step_by(components).copied().collect();
                assert_eq!(column.values, expected, "{name}: {own}");
            }
        }
        assert!(!arrays.is_empty() || name.starts_with("hand"), "{name}");
    }
}

/// A file of one piece, in text.
fn ascii(points: &str, arrays: &str, count: usize) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n<PolyData>\n\
         <Piece NumberOfPoints=\"{count}\">\n<PointData>{arrays}</PointData>\n<CellData><DataArray Name=\"radius\" \
         type=\"Float32\" format=\"ascii\">7</DataArray></CellData>\n<Points><DataArray type=\"Float64\" \
         NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray></Points>\n</Piece>\n</PolyData>\n</VTKFile>\n"
    )
}

fn array(name: &str, kind: &str, components: usize, values: &str) -> String {
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">{values}</DataArray>"
    )
}

#[test]
fn radii_colours_and_columns_follow_from_names_and_points_are_the_coordinates() {
    let arrays = [
        array("Radius", "Float32", 1, "0.5 0.25"),
        array("rgb", "UInt8", 3, "255 0 0 0 0 255"),
        array("x", "Float32", 1, "9 9"),
        array("y", "Float32", 1, "9 9"),
        array("z", "Float32", 1, "9 9"),
        array("Velocity", "Float64", 3, "3 4 0 0 0 1"),
        array("unread", "Float64", 1, "no numbers"),
    ];
    let text = ascii("1 2 3 -1 -2 -3.5", &arrays.concat(), 2);
    let found = frame(text.as_bytes(), &["velocity"]).expect("a file").linearized();
    assert_eq!(found.positions, [[1.0, 2.0, 3.0], [-1.0, -2.0, -3.5]]);
    assert_eq!((found.radii, found.colors), (vec![0.5, 0.25], vec![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]));
    assert_eq!(found.columns.iter().find(|column| column.name == "velocity").expect("a length").values, [5.0, 1.0]);
}

#[test]
fn what_is_wrong_is_named() {
    let good = ascii("1 2 3 4 5 6", &array("a", "Int32", 1, "1 2"), 2);
    let legacy = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n1 2 3 4 5 6\nPOINT_DATA 2\n\
        SCALARS a float 1\nLOOKUP_TABLE default\n1 2\n";
    assert_eq!(frame(good.as_bytes(), &["a"]).expect("good").column("a").expect("a").values, [1.0, 2.0]);
    assert_eq!(frame(legacy.as_bytes(), &["a"]).expect("good").column("a").expect("a").values, [1.0, 2.0]);
    for (old, new, problem) in [
        ("1 2 3 4 5 6", "1 2 3 4 5", "there are 5 of 6 numbers"),
        ("1 2 3 4 5 6", "1 2 3 4 5 6 7", "there are more than 6 numbers"),
        ("1 2 3 4 5 6", "1 2 3 4 five 6", "`five` is not a number"),
        ("1 2 3 4 5 6", "1 2 3 4 inf 6", "point 1 y"),
        ("type=\"PolyData\"", "type=\"ImageData\"", "has no points of its own"),
        ("NumberOfPoints=\"2\"", "NumberOfPoints=\"-2\"", "is not a number of points"),
        (
            "NumberOfPoints=\"2\"",
            "NumberOfPoints=\"99999999999\"",
            "99999999999 spheres are more than 32-bit ids can number",
        ),
        ("format=\"ascii\">1 2 3", "format=\"appended\" offset=\"0\">1 2 3", "the file has no appended data"),
        ("format=\"ascii\">1 2 3", "format=\"binary\">1 2 3", "bytes do not match 6 numbers"),
        ("byte_order", "compressor=\"vtkBrotli\" byte_order", "the compressor `vtkBrotli` is not known"),
        ("</PolyData>", "</Poly>", "expected `</PolyData>`"),
        ("</VTKFile>", "", "the file ends within `VTKFile`"),
    ] {
        let error = frame(good.replacen(old, new, 1).as_bytes(), &["a"]).map(drop).expect_err(new).to_string();
        assert!(error.contains(problem), "{new}: {error}");
    }
    for (old, new, problem) in [
        ("POLYDATA", "STRUCTURED_POINTS", "has no points of its own"),
        ("ASCII", "TEXT", "expected ASCII or BINARY, found `TEXT`"),
        ("POINT_DATA 2", "POINT_DATA 3", "data of 3 points for 2"),
        ("SCALARS a float", "SCALARS a complex", "the type `complex` is not known"),
        ("SCALARS", "SCALES", "`SCALES` is not a section"),
        ("\n1 2\n", "\n1\n", "the file ends after 1 of 2 numbers"),
        ("POINTS 2 float\n1 2 3 4 5 6\n", "", "data of 2 points for 0"),
    ] {
        let error = frame(legacy.replacen(old, new, 1).as_bytes(), &["a"]).map(drop).expect_err(new).to_string();
        assert!(error.contains(problem), "{new}: {error}");
    }
}

#[test]
fn a_collection_has_a_frame_for_each_time_and_parts_are_one_frame() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    for (n, x) in ["1 0 0", "2 0 0", "3 0 0"].iter().enumerate() {
        put(&format!("{n}.vtp"), &ascii(x, "", 1));
    }
    put(
        "whole.pvtp",
        "<VTKFile type=\"PPolyData\"><PPolyData><Piece Source=\"0.vtp\"/><Piece Source=\"1.vtp\"/></PPolyData></VTKFile>",
    );
    put(
        "film.pvd",
        "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"2\" file=\"2.vtp\"/><DataSet timestep=\"0.5\" \
         part=\"0\" file=\"0.vtp\"/><DataSet timestep=\"0.5\" part=\"1\" file=\"1.vtp\"/><DataSet timestep=\"3\" \
         file=\"whole.pvtp\"/></Collection></VTKFile>",
    );
    put("self.pvd", "<VTKFile type=\"Collection\"><Collection><DataSet file=\"self.pvd\"/></Collection></VTKFile>");
    put("pipe.pvtp", "<VTKFile type=\"PPolyData\"><PPolyData><Piece Source=\"/dev/stdin\"/></PPolyData></VTKFile>");
    let read = |name: &str| -> Result<Vec<(Option<f64>, Vec<f64>)>> {
        let options = ParticleOptions { frames: "1-".parse().expect("frames"), ..ParticleOptions::default() };
        let frames = Frames::open(&folder.path().join(Path::new(name)), &options)?;
        frames
            .map(|frame| frame.map(|frame| (frame.when.time, frame.positions.iter().map(|p| p[0]).collect())))
            .collect()
    };
    assert_eq!(read("whole.pvtp").expect("two parts"), [(None, vec![1.0, 2.0])]);
    let film = [(Some(0.5), vec![1.0, 2.0]), (Some(2.0), vec![3.0]), (Some(3.0), vec![1.0, 2.0])];
    assert_eq!(read("film.pvd").expect("three times"), film);
    assert!(read("self.pvd").expect_err("a circle").to_string().contains("a collection names a collection"));
    assert!(read("pipe.pvtp").expect_err("no file").to_string().contains("not a file"));
}
