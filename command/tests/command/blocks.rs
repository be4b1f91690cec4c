//! The promise of `--stream`: the files have the bytes of those without it, whatever format the spheres come from.

use crate::numpy::npy_of;
use crate::rng::Rng;
use crate::test_dir::{Output, TestDir};
use std::fmt::Write as _;

/// The factor by which the blocks of readers are smaller, so that short files have many.
const PARTS: usize = 64;
/// More than two blocks of a reader.
const COUNT: usize = 600_000 / PARTS;

/// A camera that does not depend on the spheres.
const CAMERA: &str = "--eye 3,2,4 --at 0,0,0 --vfov 40";

/// Every buffer of camera rays, as options; the files' names begin with `name`.
fn outputs(name: &str) -> String {
    let aovs = ["id", "distance", "normal", "position", "certainty"];
    let mut options = format!("-o {name}.png --look plain");
    for aov in aovs {
        write!(options, " --aov {aov}={name}-{aov}.npy").expect("text");
    }
    options
}

/// The words of options in which `~` stands for a space within one of them.
fn words(options: &str) -> Vec<String> {
    options.split_whitespace().map(|word| word.replace('~', " ")).collect()
}

/// Renders with these options; see [`words`].
fn render(dir: &TestDir, options: &str) -> Output {
    dir.render(&words(options).iter().map(String::as_str).collect::<Vec<_>>()[..])
}

/// Renders with and without `--stream` and compares all files; returns what the stream said.
fn same(dir: &TestDir, file: &str, options: &str) -> String {
    let size = "--size 64x48";
    render(dir, &format!("{file} {size} {options} {}", outputs("memory")));
    let legend = dir.files().remove("l.svg");
    let streamed = render(dir, &format!("{file} {size} --stream {options} {}", outputs("stream")));
    let files = dir.files();
    assert!(legend == files.get("l.svg").cloned(), "{file} {options}: the legends differ");
    let mut compared = 0;
    for (name, bytes) in files.iter().filter(|(name, _)| name.starts_with("memory")) {
        let other = name.replacen("memory", "stream", 1);
        assert!(files[&other] == *bytes, "{file} {options}: {other} differs from {name}");
        compared += 1;
    }
    assert_eq!(compared, 6, "{file} {options}");
    streamed.err
}

/// Rows of x, y, z in a cube, with radius, colour and a value.
fn rows() -> Vec<([f64; 3], f64, [f64; 3], f64)> {
    let mut rng = Rng::new(12);
    let row = |_| (rng.cube(), 0.01 * (1.0 + rng.unit()), rng.cube().map(|c| 0.5 + 0.5 * c), rng.unit());
    (0..COUNT).map(row).collect()
}

/// A NumPy array of float32 x, y, z, radius.
fn array(rows: &[([f64; 3], f64, [f64; 3], f64)]) -> Vec<u8> {
    let numbers = rows.iter().flat_map(|([x, y, z], radius, ..)| [*x, *y, *z, *radius]);
    let data: Vec<u8> = numbers.flat_map(|number| (number as f32).to_le_bytes()).collect();
    npy_of("<f4", "False", &format!("({}, 4)", rows.len()), &data)
}

/// LAS 1.2, point format 2, with colours up to `top`.
fn las(rows: &[([f64; 3], f64, [f64; 3], f64)], top: f64) -> Vec<u8> {
    let mut bytes = vec![0; 227];
    let mut put = |at: usize, new: &[u8]| bytes[at..at + new.len()].copy_from_slice(new);
    put(0, b"LASF");
    put(24, &[1, 2]);
    put(94, &227u16.to_le_bytes());
    put(96, &227u32.to_le_bytes());
    put(104, &[2]);
    put(105, &26u16.to_le_bytes());
    put(107, &(rows.len() as u32).to_le_bytes());
    (0..3).for_each(|k| put(131 + 8 * k, &1e-6f64.to_le_bytes()));
    for (at, _, color, _) in rows {
        bytes.extend(at.iter().flat_map(|x| ((x * 1e6) as i32).to_le_bytes()));
        bytes.extend([0; 8]);
        bytes.extend(color.iter().flat_map(|c| ((c * top) as u16).to_le_bytes()));
    }
    bytes
}

#[test]
fn streamed_files_have_the_bytes_of_files_in_memory() {
    let rows = rows();
    let (mut csv, mut xyz, mut ply) =
        (String::from("x,y,z,radius,r,g,b,v,kind\n"), format!("{COUNT}\n\n"), String::new());
    let mut dump =
        format!("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{COUNT}\nITEM: BOX BOUNDS pp pp pp\n-1 1\n-1 1\n-1 1\n");
    dump += "ITEM: ATOMS id type x y z v\n";
    write!(ply, "ply\nformat ascii 1.0\nelement vertex {COUNT}\n").expect("text");
    ["x", "y", "z", "radius"].iter().for_each(|name| writeln!(ply, "property float {name}").expect("text"));
    ply += "end_header\n";
    for (n, ([x, y, z], radius, [r, g, b], v)) in rows.iter().enumerate() {
        // A block has other names than the one before it.
        let kind = [["a", "b"], ["late", "a"], ["b", "last"]][n / (COUNT / 3)][n % 2];
        writeln!(csv, "{x:.5},{y:.5},{z:.5},{radius:.4},{r:.3},{g:.3},{b:.3},{v:.4},{kind}").expect("text");
        writeln!(xyz, "{} {x:.5} {y:.5} {z:.5}", ["C", "O", "Fe"][n % 3]).expect("text");
        writeln!(dump, "{} {} {x:.5} {y:.5} {z:.5} {v:.4}", n + 1, n % 4 + 1).expect("text");
        writeln!(ply, "{x:.5} {y:.5} {z:.5} {radius:.4}").expect("text");
    }
    let dir = TestDir::new(&[("c.csv", &csv), ("c.xyz", &xyz), ("c.ply", &ply), ("c.dump", &dump)]).in_parts(PARTS);
    let [first, early, late, last] = [100_000, 350_000, 420_000, 599_990].map(|n| n / PARTS);
    dir.put("c.npy", array(&rows));
    // Colours of 16 and of 8 bits.
    dir.put("c16.las", las(&rows, 65535.0));
    dir.put("c8.las", las(&rows, 255.0));
    for (file, options) in [
        ("c16.las", format!("{CAMERA} --radius 0.012")),
        ("c8.las", format!("{CAMERA} --radius 0.012")),
        ("c.npy", CAMERA.to_owned()),
        ("c.npy", "--vfov 30".to_owned()),
        ("c.npy", "--ortho --crop 10,5,50,33".to_owned()),
        ("c.npy", format!("{CAMERA} --samples 4 --tile 2/4")),
        ("c.npy", "--eye 0.1,0.2,0.3 --radius-scale 0.5 --color teal".to_owned()),
        ("c.csv", CAMERA.to_owned()),
        ("c.csv", format!("{CAMERA} --color-by v --range 0,1")),
        ("c.xyz", format!("{CAMERA} --radius-scale 0.01")),
        ("c.dump", format!("{CAMERA} --radius 0.012 --color-by v --range 0.2,0.8")),
        // The range is over all blocks: found by the pass that frames the camera, or by one of its own.
        ("c.csv", "--color-by v --legend l.svg".to_owned()),
        ("c.csv", format!("{CAMERA} --color-by v --log --legend l.svg")),
        ("c.dump", "--radius 0.012 --color-by x,y,z --map magma".to_owned()),
        ("c.npy", format!("{CAMERA} --color-by z --clip 0,0,1,0.25")),
        ("c.xyz", "--radius-scale 0.01 --color-by z".to_owned()),
        ("c.ply", CAMERA.to_owned()),
        ("c.ply", format!("{CAMERA} --clip 1,2,3,0.5")),
        // Planes cut each sphere as it comes.
        ("c.npy", format!("{CAMERA} --cut 0,0,1,0.25")),
        ("c.npy", format!("{CAMERA} --cut-slab 1,2,3,-0.4,0.3 --cut 0,1,-1,0.5 --samples 4")),
        ("c.ply", "--view left --cut 1,0.2,0.1,0.001".to_owned()),
        ("c.csv", "--eye 0.1,0.2,0.3 --at 0,0,0 --cut 1,1,1,0.1 --color-by v --range 0,1".to_owned()),
        // Selections see a block at a time.
        (
            "c.csv",
            format!("{CAMERA} --select kind~late --select kind~last~and~v<0.8 --hide index~0:{first}~{early}:{late}"),
        ),
        (
            "c.csv",
            format!(
                "{CAMERA} --color kind~last=red --color v<0.2=#3060ff --radius kind~l*=0.02 --hide kind~a --legend l.svg"
            ),
        ),
        ("c.csv", "--select not~kind~a --color-by v --color kind~late=teal --legend l.svg".to_owned()),
        (
            "c.xyz",
            format!("{CAMERA} --radius-scale 0.01 --hide element~C --color element~Fe~and~x>0=gold --legend l.svg"),
        ),
        ("c.dump", format!("{CAMERA} --radius 0.012 --radius type~3=0.03 --select type~2:4 --clip 0,0,1,0.3")),
        ("c.npy", format!("--select radius<0.015~and~abs~z<0.7 --hide index~{first}")),
        // What is looked at is found by two passes.
        ("c.csv", "--at kind~late~and~x>0 --view left --color-by v".to_owned()),
        ("c.csv", "--eye 3,2,4 --at kind~last~and~v<0.1 --hide kind~late --clip 0,0,1,0.3".to_owned()),
        ("c.dump", format!("--radius 0.012 --at index~{last}:700000")),
    ] {
        let stderr = same(&dir, file, &options);
        let (kept, all) = stderr
            .lines()
            .find_map(|line| line.split_once(" may be hit first"))
            .and_then(|(stderr, _)| stderr.rsplit_once(" of "))
            .unwrap_or_else(|| panic!("{stderr}"));
        let kept: usize =
            kept.split_whitespace().rev().nth(1).and_then(|n| n.replace(',', "").parse().ok()).expect("a count");
        assert!(
            all.replace(',', "").parse::<usize>().is_ok_and(|all| all <= COUNT) && kept < COUNT / 3,
            "{file} {options}: {stderr}"
        );
    }
}

/// A file with colours, and whether it is read as a stream.
type Colored = (String, Vec<u8>);

/// The same points in every format that is read as a stream, with colours of whole numbers `levels` or, times 1/1000, as floats.
fn colored(name: &str, points: &[[f64; 3]], levels: &[[u16; 3]]) -> Vec<Colored> {
    let count = points.len();
    let rows = || points.iter().zip(levels);
    let mut files: Vec<Colored> = Vec::new();
    let mut text = |ending: &str, head: &str, row: &dyn Fn(&[f64; 3], [String; 3]) -> String, scale: f64| {
        let rows = rows().map(|(at, color)| row(at, color.map(|c| (f64::from(c) * scale).to_string())));
        files.push((
            format!("{name}{}.{ending}", files.len()),
            (head.to_owned() + &rows.collect::<String>()).into_bytes(),
        ));
    };
    let box_of = "ITEM: BOX BOUNDS pp pp pp\n-1 1\n-1 1\n-1 1\n";
    for scale in [1.0, 0.001] {
        let csv = |[x, y, z]: &[f64; 3], [r, g, b]: [String; 3]| format!("{x},{y},{z},0.1,{r},{g},{b}\n");
        text("csv", "x,y,z,radius,red,green,blue\n", &csv, scale);
        let xyz = |[x, y, z]: &[f64; 3], [r, g, b]: [String; 3]| format!("C {x} {y} {z} {r} {g} {b} 0.1\n");
        for kind in ["R", "I"].iter().take(if scale < 1.0 { 1 } else { 2 }) {
            let head = format!("{count}\nProperties=species:S:1:pos:R:3:color:{kind}:3:radius:R:1\n");
            text("xyz", &head, &xyz, scale);
        }
        let dump = |[x, y, z]: &[f64; 3], [r, g, b]: [String; 3]| format!("{x} {y} {z} {r} {g} {b} 0.2\n");
        let head =
            format!("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{count}\n{box_of}ITEM: ATOMS x y z r g b diameter\n");
        text("dump", &head, &dump, scale);
        let ply = |[x, y, z]: &[f64; 3], [r, g, b]: [String; 3]| format!("{x} {y} {z} {r} {g} {b} 0.1\n");
        for (kind, names) in
            [("float", ["red", "green", "blue"]), ("ushort", ["diffuse_red", "diffuse_green", "diffuse_blue"])]
        {
            let colors = names.map(|name| format!("property {kind} {name}\n")).concat();
            let head = format!(
                "ply\nformat ascii 1.0\nelement vertex {count}\nproperty double x\nproperty double y\nproperty double z\n\
                 {colors}property float radius\nend_header\n"
            );
            if kind == "float" || scale == 1.0 {
                text("ply", &head, &ply, scale);
            }
        }
    }
    let mut las = vec![0; 227];
    let mut put = |at: usize, new: &[u8]| las[at..at + new.len()].copy_from_slice(new);
    put(0, b"LASF");
    put(24, &[1, 2]);
    [(94, 227u16), (105, 26)].iter().for_each(|(at, number)| put(*at, &number.to_le_bytes()));
    [(96, 227), (104, 2), (107, count as u32)].iter().for_each(|(at, number): &(usize, u32)| match at {
        104 => put(*at, &[*number as u8]),
        _ => put(*at, &number.to_le_bytes()),
    });
    (0..3).for_each(|k| put(131 + 8 * k, &1e-6f64.to_le_bytes()));
    let (mut ply, mut record) = (Vec::new(), Vec::new());
    for (at, color) in rows() {
        las.extend(at.iter().flat_map(|x| ((x * 1e6) as i32).to_le_bytes()));
        las.extend([0; 8]);
        las.extend(color.iter().flat_map(|c| c.to_le_bytes()));
        ply.extend(at.iter().flat_map(|x| x.to_le_bytes()));
        // Colours of 8 bits come from colours of 16.
        let [r, g, b] = color.map(|c| if c > 255 { (c / 257) as u8 } else { c as u8 });
        ply.extend(u32::from_be_bytes([0, r, g, b]).to_le_bytes());
        record.extend(at.iter().flat_map(|x| x.to_le_bytes()));
        record.extend(color.iter().flat_map(|c| c.to_le_bytes()));
        record.extend(0.1f64.to_le_bytes());
    }
    files.push((format!("{name}.las"), las));
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty double x\nproperty double y\nproperty double z\n\
         property uint rgb\nend_header\n"
    );
    files.push((format!("{name}-packed.ply"), [head.into_bytes(), ply].concat()));
    let fields = "[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('red', '<u2'), ('green', '<u2'), ('blue', '<u2'), ('radius', '<f8')]";
    let head = format!("{{'descr': {fields}, 'fortran_order': False, 'shape': ({count},), }}\n");
    let array = [&b"\x93NUMPY\x01\x00"[..], &(head.len() as u16).to_le_bytes(), head.as_bytes(), &record].concat();
    files.push((format!("{name}.npy"), array));
    files
}

/// Colours of every type and of all kinds of levels, in blocks of seven: what the numbers are follows from the whole file, however it is
/// read, and whatever is selected.
#[test]
fn colours_of_every_format_are_those_of_the_whole_file() {
    let mut rng = Rng::new(77);
    let points: Vec<[f64; 3]> = (0..40).map(|_| rng.cube()).collect();
    let mut levels = |most: u16| -> Vec<[u16; 3]> {
        (0..40).map(|_| [0; 3].map(|_: u16| (rng.unit() * f64::from(most)) as u16)).collect()
    };
    let (low, high) = (levels(256), levels(65535));
    let late = |late: &[[u16; 3]], before: &dyn Fn(usize) -> [u16; 3]| -> Vec<[u16; 3]> {
        (0..40).map(|n| if n < 30 { before(n) } else { late[n] }).collect()
    };
    let dir = TestDir::new(&[]).in_parts(37_450);
    let cases = [
        ("low", low.clone()),
        ("high", high.clone()),
        ("none", vec![[0; 3]; 40]),
        ("dark", late(&low, &|_| [0; 3])),
        ("late", late(&high, &|n| low[n])),
        ("black", late(&high, &|_| [0; 3])),
        ("bits", late(&low, &|n| low[n].map(|c| c % 2))),
    ];
    let camera = "--eye 3,2,4 --at 0,0,0 --vfov 40 --size 12x9 --look plain";
    let picture = |name: &str| dir.files().remove(name).unwrap_or_else(|| panic!("{name}"));
    let mut compared = 0;
    for (case, levels) in cases {
        for (name, content) in colored(case, &points, &levels) {
            dir.put(&name, content);
            let radius = if name.ends_with(".las") || name.contains("packed") { "--radius 0.1" } else { "" };
            for selected in
                ["", "--select index~0:19"].iter().take(if ["dark", "late"].contains(&case) { 2 } else { 1 })
            {
                let options = format!("{camera} {radius} {selected}");
                let stderr = render(&dir, &format!("{name} {options} -o memory.png")).err;
                let memory = picture("memory.png");
                let streamed = render(&dir, &format!("{name} {options} --stream -o stream.png")).err;
                assert!(memory == picture("stream.png"), "{name} {selected}: the stream differs");
                if ["low", "none", "late"].contains(&case) && selected.is_empty() {
                    dir.good(&format!(
                        "sift {name} --first-id 0 {radius} {} -o part.npz",
                        camera.replace("--look plain", "")
                    ));
                    dir.render("--visible part.npz -o parts.png");
                    assert!(memory == picture("parts.png"), "{name}: the part differs");
                }
                let color_lines = |stderr: &str| {
                    stderr.lines().filter(|line| line.contains("colour")).map(str::to_owned).collect::<Vec<_>>()
                };
                assert_eq!(color_lines(&stderr), color_lines(&streamed), "{name}");
                compared += 1;
                if case == "none" {
                    assert!(
                        color_lines(&stderr).iter().any(|line| line.contains("all 0") || line.contains("are 0")),
                        "{name}: {stderr}"
                    );
                    // The scenes differ, and the pixels do not.
                    render(&dir, &format!("{name} {options} -o grey.png --color 0.8,0.8,0.8"));
                    let is_black = color_lines(&stderr).iter().any(|line| line.contains("black; "));
                    assert_eq!(dir.run("compare grey.png memory.png").code, i32::from(is_black), "{name}");
                }
            }
            dir.remove(&name);
        }
    }
    assert!(compared >= 9 * 13, "{compared}");
}

/// Files are written in bands of rows.
#[test]
fn files_do_not_depend_on_the_size_of_bands() {
    let formats =
        ["exr", "npy", "npz", "pfm"].map(|format| format!("--aov depth=depth.{format} --aov normal=n.{format}"));
    let words = format!("s.toml --size 300x200 -o picture.png {}", formats.join(" "));
    let written = |dir: TestDir| {
        dir.render(&words);
        dir.files()
    };
    let dir = || TestDir::new(&[("s.toml", crate::test_dir::SCENE)]);
    let [whole, bands] = [written(dir()), written(dir().in_parts(PARTS))];
    assert_eq!(whole.len(), 10);
    for (name, bytes) in &whole {
        assert!(bands[name] == *bytes, "{name}");
    }
}

/// A note on a selection is printed if it holds for every block of the file, and not if it holds for some.
#[test]
fn a_word_that_selects_nothing_in_the_whole_file_is_reported() {
    let mut table = String::from("x,y,z,radius,kind\n");
    for n in 0..COUNT {
        let kind = if n < COUNT / 2 { "early" } else { "late" };
        writeln!(table, "{},{},0,0.4,{kind}", n % 100, n / 100).expect("text");
    }
    let dir = TestDir::new(&[("c.csv", &table)]).in_parts(PARTS);
    for (options, message) in [
        ("--hide kind~early", None),
        ("--select kind~late~or~index~0:9", None),
        ("--color kind~late=red --hide x>99", None),
        ("--hide kind~never", Some("`kind never` in the selection `kind never`: no particle has it")),
        ("--select kind~late~and~index~0:9", Some("the selections leave none of the 9375 particles")),
        ("--select kind~early~or~x<9~and~y<3", Some("from left to right")),
    ] {
        let stderr =
            render(&dir, &format!("c.csv --eye 50,40,80 --at 50,40,0 --size 9x9 --stream {options} -o p.png")).err;
        let warnings: Vec<&str> = stderr.lines().filter(|line| line.contains("select")).collect();
        assert_eq!(warnings.len(), usize::from(message.is_some()), "{options}: {stderr}");
        assert!(message.is_none_or(|message| warnings[0].contains(message)), "{options}: {stderr}");
    }
    // A part has the ids of the spheres that are left.
    let part =
        dir.good(
            &[
                "sift",
                "c.csv",
                "--first-id",
                "7",
                "--select",
                "kind late",
                "--eye",
                "50,40,80",
                "--json",
                "-o",
                "p.npz",
            ][..],
        );
    assert_eq!(part.json()["ids"], serde_json::json!([[7, 7 + COUNT.div_ceil(2)]]));
}

/// The reader names the row of a text or of an array, and the style the particle of other files, counted in the file and not
/// in its block.
#[test]
fn a_bad_row_in_a_late_block_is_refused_with_its_file_and_row() {
    const LATE: usize = 550_001 / PARTS;
    let good = rows();
    let mut text = String::from("x,y,z,radius\n");
    for (n, ([x, y, z], radius, ..)) in good.iter().enumerate() {
        let sign = if n == LATE { "-" } else { "" };
        writeln!(text, "{x:.3},{y:.3},{z:.3},{sign}{radius:.4}").expect("text");
    }
    let dir = TestDir::new(&[("radius.csv", &text)]).in_parts(PARTS);
    let (mut center, mut radius) = (good.clone(), good);
    center[LATE].0[1] = f64::NAN;
    radius[LATE].1 = -0.5;
    dir.put("center.npy", array(&center));
    dir.put("radius.npy", array(&radius));
    for (name, rows) in [("center.ply", &center), ("radius.ply", &radius)] {
        let mut ply = format!("ply\nformat binary_little_endian 1.0\nelement vertex {COUNT}\n").into_bytes();
        ["x", "y", "z", "radius"].iter().for_each(|name| ply.extend(format!("property float {name}\n").bytes()));
        ply.extend(b"end_header\n");
        let numbers = rows.iter().flat_map(|([x, y, z], radius, ..)| [*x, *y, *z, *radius]);
        numbers.for_each(|number| ply.extend((number as f32).to_le_bytes()));
        dir.put(name, ply);
    }
    for (file, place) in [
        // The first row is below the header, in line 2.
        ("radius.csv", &*format!("radius.csv:{}:", LATE + 2)),
        ("center.npy", &format!("center.npy: row {LATE} center")),
        ("radius.npy", &format!("radius.npy: row {LATE} radius")),
        ("center.ply", &format!("center.ply: vertex {LATE} ")),
        ("radius.ply", &format!("radius.ply: vertex {LATE} radius")),
    ] {
        for stream in ["--stream", ""] {
            let options = format!("{file} {CAMERA} --size 16x12 {stream} {}", outputs("bad"));
            dir.refused_render(3, &options, &[place]);
        }
    }
    // A radius of the file that is valid, and not once it is scaled.
    dir.put("small.npy", array(&rows()));
    let options = format!("small.npy {CAMERA} --size 16x12 --stream --radius-scale 1e-323 {}", outputs("bad"));
    dir.refused_render(3, &options, &["small.npy: particle 0 radius", "the radius is 0"]);
    assert!(!dir.files().keys().any(|name| name.starts_with("bad")), "no file is written");
}

/// Copies are operators over one set of atoms: only those that are seen are in memory.
#[test]
fn copies_have_the_bytes_of_copies_in_memory() {
    let mut rng = Rng::new(5);
    let mut text = String::from("3000\nLattice=\"8 0 0 1 7 0 0.5 -1 9\" Properties=species:S:1:pos:R:3\n");
    for n in 0..3000 {
        let [x, y, z] = rng.cube().map(|x| 4.0 + 4.0 * x);
        writeln!(text, "{} {x:.5} {y:.5} {z:.5}", ["C", "O", "Fe"][n % 3]).expect("text");
    }
    let dir = TestDir::new(&[("a.xyz", &text)]);
    for options in [
        "--copies 5,4,3 --radius-scale 0.2",
        "--copies 3,2,4 --eye 70,50,60 --vfov 30 --clip 0,0,1,20",
        "--copies 3,2,4 --eye 70,50,60 --vfov 30 --cut 1,1,1,40",
        "--copies 3,2,4 --at element~Fe~and~x>5 --view top --clip 0,0,1,20",
    ] {
        let stderr = same(&dir, "a.xyz", options);
        assert!(stderr.contains("may be hit first"), "{stderr}");
    }
    let focus = ["a.xyz", "--stream", "-o", "p.png", "--copies", "2,2,2", "--focus", "element C"];
    dir.refused_render(2, &focus[..], &["remove --focus"]);
    let all = "--copies 4294967295,4294967295,4294967295";
    dir.refused_render(5, &format!("a.xyz --stream --size 8x8 -o p.png {all}"), &["64-bit ids"]);
}

/// Ids of more spheres than 32 bits can number are int64 in the formats that say so, and refused by the others.
#[test]
fn ids_of_more_than_two_billion_copies_are_int64() {
    let text = "2\nLattice=\"3 0 0 0 3 0 0 0 3\" Properties=species:S:1:pos:R:3\nC 0.5 0.5 0.5\nFe 2 2 1.5\n";
    let dir = TestDir::new(&[("a.xyz", text)]);
    let options = "a.xyz --stream --copies 1500,1500,1500 --eye 4600,4590,4580 --at 2000,2000,2000 --vfov 1.3 --size 32x24 --samples 1";
    let done = dir.render(&format!("{options} -o p.png --aov id=id.npy --aov id,distance=both.npz --json"));
    assert!(done.err.contains("ids are int64: 6750000000 spheres"), "{}", done.err);
    assert_eq!(done.json()["spheres"], 6_750_000_000u64);
    let files = dir.files();
    let array = String::from_utf8_lossy(&files["id.npy"]).into_owned();
    assert!(array.contains("'<i8'") && array.contains("\"halfline:ids\":\"int64\""), "{array}");
    dir.good("compare id.npy both.npz --aov id");
    dir.render(&format!("{options} --tile 1/2 --aov id=1.npy"));
    dir.render(&format!("{options} --tile 2/2 --aov id=2.npy"));
    dir.good("merge 1.npy 2.npy -o merged.npy");
    assert!(dir.files()["merged.npy"] == files["id.npy"], "merged tiles");
    let again = dir.render(&format!("{options} --aov id=id.npy --resume"));
    assert!(again.err.contains("already there"), "{}", again.err);
    for name in ["id.exr", "id.png"] {
        dir.refused_render(2, &format!("{options} --aov id={name}"), &["int64", ".npy or .npz"]);
    }
    dir.refused_render(2, &format!("{options} --aov id=id.raw"), &["int64", ".npy or .npz"]);
}

/// A protein of chains A, B and C, with an assembly of two parts: A and B by 40 operators, C and A by 9 of them and 3 others.
fn assembly() -> String {
    let mut rng = Rng::new(9);
    let mut text = String::from("REMARK 350 BIOMOLECULE: 1\n");
    let mut operators = |chains: &str, numbers: &[usize]| {
        writeln!(text, "REMARK 350 APPLY THE FOLLOWING TO CHAINS: {chains}").expect("text");
        for number in numbers {
            let turn = *number as f64;
            let ((s, c), place) = (turn.sin_cos(), [turn % 5.0, (turn / 5.0).floor(), turn % 3.0].map(|n| 30.0 * n));
            let rows = [[c, -s, 0.0, place[0]], [s, c, 0.0, place[1]], [0.0, 0.0, 1.0, place[2]]];
            for (k, [a, b, d, shift]) in (1..).zip(rows) {
                writeln!(text, "REMARK 350   BIOMT{k} {number:3} {a:9.6} {b:9.6} {d:9.6} {shift:14.5}").expect("text");
            }
        }
    };
    operators("A, B", &(1..=40).collect::<Vec<_>>());
    operators("C, A", &(3..=11).chain(50..53).collect::<Vec<_>>());
    for n in 0..900 {
        let ([x, y, z], chain) = (rng.cube().map(|x| 15.0 * x), ["A", "B", "C", "D"][n / 10 % 4]);
        let (element, serial, bfactor) = (["C", "N", "O"][n % 3], n + 1, rng.unit() * 50.0);
        writeln!(
            text,
            "ATOM  {serial:5}  {element}   GLY {chain}{:4}    {x:8.3}{y:8.3}{z:8.3}  1.00{bfactor:6.2}           {element}",
            n / 10
        )
        .expect("text");
    }
    text
}

/// Operators of an assembly are kept as such, with ids, colours and legend as if multiplied out.
#[test]
fn assemblies_have_the_bytes_of_assemblies_in_memory() {
    let dir = TestDir::new(&[("a.pdb", &assembly())]);
    for options in [
        "",
        "--eye 300,200,250 --at 60,100,30 --vfov 30 --color-by copy --legend l.svg",
        "--eye 60,100,30 --at 200,100,40 --color-by chain --clip 0,0,1,60 --samples 4",
        "--ortho --color-by bfactor --radii covalent",
    ] {
        let stderr = same(&dir, "a.pdb", &format!("--assembly 1 {options}"));
        assert!(stderr.contains("may be hit first"), "{stderr}");
    }
    for (options, message) in [
        ("--select protein", "--select"),
        ("--color-by x", "coordinates"),
        ("--color-by copy,bfactor", "one column"),
        ("--copies 2,1,1", "needs a periodic cell"),
    ] {
        let options = format!("a.pdb --assembly 1 --stream --size 8x8 -o p.png {options}");
        dir.refused_render(2, &options, &[message]);
    }
}

#[test]
fn what_a_stream_cannot_do_is_an_error_with_its_mend() {
    let dir = TestDir::new(&[
        ("c.csv", "x,y,z,radius,kind\n0,0,0,1,a\n1,2,3,1,b\n"),
        ("bare.csv", "x,y,z\n0,0,0\n1,2,3\n"),
        ("m.pdb", "ATOM      1  CA  GLY A   1      11.104   6.134  -6.504  1.00  0.00           C\n"),
    ]);
    for (scene, message) in [
        ("c.csv --look soft", "--look plain"),
        ("c.csv --occlusion", "--look plain"),
        ("c.csv --accuracy fast", "--accuracy certified"),
        ("c.csv --select within~1~of~index~0", "`within` in the selection"),
        ("c.csv --hide same~kind~as~index~0", "`same` in the selection"),
        ("c.csv --color around~1~index~0=red", "`around` in the selection"),
        ("c.csv --hide ligand", "`ligand` in the selection"),
        ("c.csv --at kind~c", "selects none of the 2 spheres that are drawn; `kind c` in the selection"),
        ("c.csv --at within~1~of~index~0", "`within` in the selection"),
        ("c.csv --focus kind~a", "remove --focus"),
        ("c.csv --select colour<3", "the file has index, x, y, z, radius, kind"),
        ("c.csv --color-by kind", "the names in kind"),
        ("c.csv --copies 2,2,2", "needs a periodic cell"),
        ("c.csv --cell", "--cell"),
        ("c.csv --spin 4", "one by one"),
        ("bare.csv", "--radius"),
        ("m.pdb", "remove --stream"),
    ] {
        let name = if scene.contains("--spin") { "p.%d.png" } else { "p.png" };
        let words = words(&format!("{scene} --stream --size 8x8 -o {name}"));
        dir.refused_render(2, &words.iter().map(String::as_str).collect::<Vec<_>>()[..], &[message]);
    }
    assert!(!dir.files().keys().any(|name| name.ends_with(".png")), "no file is written");
}

/// A scene file with spheres of its own, some with colours, and spheres of files, some with colours.
#[test]
fn a_scene_file_streams_with_the_files_that_it_names() {
    let rows = rows();
    let (plain, colored) = rows.split_at(6_000);
    let dir = TestDir::new(&[]).in_parts(PARTS);
    dir.put("plain.npy", array(plain));
    let table = colored.iter().map(|([x, y, z], radius, [r, g, b], _)| format!("{x},{y},{z},{radius},{r},{g},{b}\n"));
    dir.put("colored.csv", format!("x,y,z,radius,r,g,b\n{}", table.collect::<String>()));
    dir.put("atoms.xyz", "2\n\nC 0.1 0.2 0.3\nO 0.3 0.2 0.1\n");
    let scene = |more: &str| {
        format!(
            "[camera]\neye = [3.0, 2.0, 4.0]\nat = [0.0, 0.0, 0.0]\nvfov = 40.0\nup = [0.0, 1.0, 0.0]\n
[image]\nsize = [64, 48]\nsamples = 4\nbackground = \"#ddeeff\"\n
[[sphere]]\ncenter = [0.0, 0.0, -1.0]\nradius = 0.7\n
[[spheres]]\nfile = \"plain.npy\"\n\n{more}"
        )
    };
    let colored = "[[spheres]]\nfile = \"colored.csv\"\n\n[[spheres]]\nfile = \"atoms.xyz\"\n";
    let selected = "[[spheres]]\nfile = \"colored.csv\"\nselect = \"x > 0 or index 2000:2500\"\n
        [[spheres]]\nfile = \"plain.npy\"\nselect = \"radius > 5\"\n
        [[spheres]]\nfile = \"atoms.xyz\"\nselect = \"element O\"\n";
    for (more, options) in [
        ("", ""),
        (colored, ""),
        (selected, ""),
        (colored, "--color teal --radius-scale 0.5 --clip 0,0,1,0.4"),
        ("", "--fit"),
        (selected, "--at radius<0.015~and~index~100:9000"),
    ] {
        dir.put("s.toml", scene(more));
        let notes = |stderr: &str| stderr.matches("the selection `radius > 5` leaves none of 6000 spheres").count();
        let whole = render(&dir, &format!("s.toml {options} {}", outputs("memory"))).err;
        let stderr = render(&dir, &format!("s.toml --stream {options} {}", outputs("stream"))).err;
        assert_eq!([notes(&whole), notes(&stderr)], [usize::from(more == selected); 2], "{whole}{stderr}");
        let files = dir.files();
        for (name, bytes) in files.iter().filter(|(name, _)| name.starts_with("memory")) {
            let other = name.replacen("memory", "stream", 1);
            assert!(files[&other] == *bytes, "{more} {options}: {other} differs from {name}");
        }
        assert!(stderr.contains("may be hit first"), "{stderr}");
        if options.contains("--at") {
            continue;
        }
        dir.good(&format!("sift s.toml --first-id 0 {options} -o s.npz"));
        dir.render(&format!("--visible s.npz --background #ddeeff {}", outputs("parts")));
        assert!(dir.files()["parts.png"] == files["memory.png"], "{more} {options}");
    }
    for (more, options, words) in [
        ("[[spheres]]\nfile = \"colored.csv\"\nselect = \"within 1 of index 3\"\n", "", "`within` needs all spheres"),
        ("[[sphere]]\ncenter = [0.0, 0.0, 0.0]\nradius = 1.0\nmaterial = \"metal\"\n", "", "mirrors and glass"),
        ("[[light]]\nsphere = 7\n", "", "need all spheres in memory"),
        ("[occlusion]\nrays = 4\n", "", "need all spheres in memory"),
        ("", "--select all", "no columns to select by"),
        ("", "--aov depth=plain.npy", "plain.npy is an input"),
    ] {
        dir.put("s.toml", scene(more));
        let refused = dir.run(&format!("render s.toml --backend cpu --stream {options} -o x.png"));
        assert!(refused.code == 2 && refused.err.contains(words), "{more} {options}: {}", refused.err);
    }
}
