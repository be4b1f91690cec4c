//! The rows of the walk over the options: for each a small scene in which it has an effect.

use crate::rng::Rng;
use crate::test_dir::TestDir;
use std::fmt::Write as _;

/// The effect of an option in memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Effect {
    /// Other numbers in some file.
    Numbers,
    /// Other bytes in some file.
    Bytes,
    /// The rendering succeeds, and fails without it.
    Allows,
    /// The rendering fails, and succeeds without it.
    Fails,
    /// The same bytes.
    Nothing,
    /// An effect of several options, which may exclude each other.
    Any,
}

/// An option, and a rendering without it and with it. In the words `~` stands for a space.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) option: &'static str,
    pub(crate) effect: Effect,
    pub(crate) file: &'static str,
    pub(crate) base: String,
    pub(crate) with: String,
    /// The output options, where they are not a picture and two buffers. Names of files begin with `p.`.
    pub(crate) files: Option<&'static str>,
    /// Words by which a refusal may name the option otherwise.
    pub(crate) also: Vec<&'static str>,
}

/// A camera that does not depend on the spheres.
pub(crate) const CAMERA: &str = "--eye 9,7,12 --at 2,2,2 --vfov 40";

const OUTPUTS: &str = "-o p.png --aov id=p.i.npy --aov distance=p.d.npy";

impl Row {
    pub(crate) fn outputs(&self) -> String {
        self.files.unwrap_or(OUTPUTS).to_owned()
    }

    /// Whether it writes to standard output.
    pub(crate) fn is_piped(&self) -> bool {
        self.files.is_some_and(|files| files.contains("=-"))
    }

    fn of(self, file: &'static str) -> Self {
        Self { file, ..self }
    }

    fn into(self, files: &'static str) -> Self {
        Self { files: Some(files), ..self }
    }

    fn or(self, also: &[&'static str]) -> Self {
        Self { also: also.to_vec(), ..self }
    }

    fn does(self, effect: Effect) -> Self {
        Self { effect, ..self }
    }
}

/// A row whose rendering has these words without the option, and these more with it.
fn row(option: &'static str, base: &str, more: &str) -> Row {
    let base = format!("--size 12x9 --look plain {base}");
    let with = format!("{base} {more}");
    Row { option, effect: Effect::Numbers, file: "f.xyz", base, with, files: None, also: Vec::new() }
}

/// A row of the camera of the walk.
fn at(option: &'static str, more: &str) -> Row {
    row(option, CAMERA, more)
}

/// A row whose option takes the place of others.
fn instead(option: &'static str, base: &str, with: &str) -> Row {
    let size = |words: &str| format!("--size 12x9 --look plain {words}");
    Row { with: size(with), ..row(option, base, "") }.with_base(size(base))
}

impl Row {
    fn with_base(self, base: String) -> Self {
        Self { base, ..self }
    }
}

/// All rows.
pub(crate) fn rows() -> Vec<Row> {
    use Effect::{Allows, Bytes, Fails, Nothing};
    const FIGURE: &[&str] = &[
        "a figure without pixels needs all spheres in memory",
        "parts have pixels, and a figure has none",
        "is a figure, which is not read again",
        "a curved lens does not show spheres as ellipses",
    ];
    const LIGHT: &[&str] = &["lights and a sky need all spheres in memory"];
    const CUT: &[&str] = &["is chosen among all spheres in memory", "belongs to the parts"];
    const FORMAT: &[&str] = &["files are not read as a stream"];
    const PIXELS: &str = "--eye 9,7,12 --at 2,2,2 --lens opencv --intrinsics";
    vec![
        at("format", "--format csv --columns x=1,y=2,z=3,radius=4").of("bare.dat").does(Allows),
        at("columns", "--columns x=a,y=b,z=c,radius=d").of("named.csv").does(Allows),
        at("atom-style", "--atom-style sphere").of("lammps.data").does(Allows).or(FORMAT),
        at("frames", "--frames 2"),
        row("frames", "", "--frames 2").or(&["--hold"]),
        row("frames", &format!("{CAMERA} --color-by v"), "--frames 2").or(&["--hold", "--color-by"]),
        instead("hold", "--frames 2", "--frames 2 --hold none"),
        instead("hold", "--frames 2", "--frames 2 --hold all"),
        at("topology", "--topology top.pdb --radius-scale 0.4").of("f.dump"),
        at("add", "--add e.xyz --radius-scale 0.5").of("top.pdb").or(FORMAT),
        at("identity", "--identity row --frames 2").of("f.dump"),
        at("model", "--model 2").of("m.pdb").or(FORMAT),
        at("altloc", "--altloc A").of("m.pdb").or(FORMAT),
        at("assembly", "--assembly 1").of("m.pdb").or(FORMAT),
        at("as-listed", "--as-listed --radius 0.3").of("s.cif").or(FORMAT),
        at("strict", "--strict").of("mesh.ply").does(Fails),
        at("skip-invalid", "--skip-invalid").of("bad.csv").does(Allows),
        at("select", "--select kind~a"),
        at("hide", "--hide kind~a"),
        at("radii", "--radii covalent --radius-scale 0.5").of("e.xyz"),
        at("radius", "--radius 0.3"),
        at("radius-scale", "--radius-scale 1.5"),
        at("move", "--move v>0.3=0.5,0,1"),
        at("wrap", "--wrap"),
        at("unwrap", "--unwrap").of("f.dump"),
        at("copies", "--copies 2,1,1"),
        at("clip", "--clip 0,0,1,2"),
        at("cell", "--cell=0.3"),
        at("cut", "--cut 1,1,1,6").or(CUT),
        at("cut-slab", "--cut-slab 0,0,1,1.5,2.5").or(CUT),
        at("cut-at", "--cut-at kind~a").or(CUT),
        at("cut-at", "--cut-at all:1,0,1").or(CUT),
        row("cut-color", &format!("{CAMERA} --cut 1,1,1,6"), "--cut-color red").or(CUT),
        row("cut-color", &format!("{CAMERA} --cut 1,1,1,6"), "--cut-color kind~a=0.5,0,1").or(CUT),
        row("cut-only", &format!("{CAMERA} --cut 1,1,1,6"), "--cut-only kind~a").or(CUT),
        at("color", "--color teal"),
        at("material", "--material metal"),
        row("shine", &format!("{CAMERA} --sun 1,1,1 --material plastic"), "--shine 3")
            .or(&["--material", "lights and a sky"]),
        at("opacity", "--opacity 0.5"),
        at("color-by", "--color-by v"),
        at("color-by", "--color-by v --range 0,1"),
        at("color-by", "--color-by kind"),
        row("map", &format!("{CAMERA} --color-by v --range 0,1"), "--map magma"),
        row("range", &format!("{CAMERA} --color-by v"), "--range 0.2,0.4"),
        row("log", &format!("{CAMERA} --color-by v --range 0.1,1"), "--log"),
        row("nan-color", &format!("{CAMERA} --color-by u --range 0,1"), "--nan-color red"),
        row("legend", &format!("{CAMERA} --color-by v --range 0,1"), "--legend p.l.svg").does(Bytes),
        row("legend", &format!("{CAMERA} --color-by v"), "--legend p.l.svg").does(Bytes).or(&["--color-by"]),
        row("legend-title", &format!("{CAMERA} --color-by v --range 0,1 --legend-in=right"), "--legend-title w")
            .sized_all("220x150")
            .or(&["--legend-in"]),
        row("eye", "--at 2,2,2", "--eye 9,7,12"),
        row("at", "--eye 9,7,12", "--at 1,2,2"),
        row("view", "", "--view -1,-1,-1"),
        row("up", CAMERA, "--up 0,0,1"),
        row("focus", "", "--focus kind~a"),
        row("fit", "", "--fit").of("s.toml"),
        row("frame-share", "", "--frame-share 50%"),
        row("camera-from", "", "--camera-from s.toml"),
        instead("vfov", "--eye 9,7,12 --at 2,2,2 --vfov 40", "--eye 9,7,12 --at 2,2,2 --vfov 20"),
        instead("vfov", "--cameras bare.json --vfov 40", "--cameras bare.json --vfov 20").or(&["--cameras"]),
        instead("ortho", "--eye 9,7,12 --at 2,2,2", "--eye 9,7,12 --at 2,2,2 --ortho 7"),
        at("zoom", "--zoom 2"),
        at("aperture", "--aperture 2 --samples 4"),
        row("focus-distance", &format!("{CAMERA} --aperture 2 --samples 4"), "--focus-distance 5").or(&["--aperture"]),
        row("cameras", "", "--cameras one.json"),
        instead("cameras", "--frames 2", "--frames 2 --cameras two.json").or(&["--hold"]),
        instead("intrinsics", "--cameras bare.json --vfov 40", "--cameras bare.json --intrinsics 12,12,6,5"),
        at("lens", "--lens fisheye"),
        instead("lens", CAMERA, "--eye 9,7,12 --at 2,2,2 --lens equirectangular"),
        instead("intrinsics", &format!("{PIXELS} 12,12,6,5"), &format!("{PIXELS} 20,20,6,5")),
        row("lens-coefficients", &format!("{PIXELS} 12,12,6,5"), "--lens-coefficients -0.2,0.05,0,0").or(&["--lens"]),
        row("spin", "", "--spin 1"),
        instead("spin", &format!("{CAMERA} --frames 2"), &format!("{CAMERA} --frames 2 --spin 3")),
        instead("size", CAMERA, CAMERA).sized("11x9"),
        at("samples", "--samples 4"),
        row("seed", &format!("{CAMERA} --samples 4"), "--seed 3"),
        at("exposure", "--exposure 1"),
        row("tone", &format!("{CAMERA} --exposure 2"), "--tone soft"),
        at("least-size", "--least-size 3"),
        at("crop", "--crop 2,1,9,8"),
        at("tile", "--tile 2/3"),
        row("legend-in", &format!("{CAMERA} --color-by v"), "--legend-in=right")
            .sized_all("220x150")
            .or(&["--color-by"]),
        at("label", "--label {count}~{frame}~{time}").sized_all("120x90"),
        at("scale-bar", "--scale-bar=nm").sized_all("120x90"),
        at("mark", "--mark kind~a=x").sized_all("120x90"),
        at("mark-one", "--mark-one kind~a=x").sized_all("120x90"),
        row("mark-all", &format!("{CAMERA} --mark kind~a=x"), "--mark-all").sized_all("240x180").or(&["--mark"]),
        instead("look", CAMERA, CAMERA).looking("soft"),
        at("occlusion", "--occlusion 4"),
        row("reach", &format!("{CAMERA} --occlusion 4"), "--reach 0.5").or(LIGHT),
        at("sun", "--sun 1,1,1").or(LIGHT),
        row("shadows", &format!("{CAMERA} --sun 1,1,1"), "--shadows").or(LIGHT),
        row("bounces", &format!("{CAMERA} --material metal"), "--bounces 0").or(&["--material"]),
        at("silhouette", "--silhouette"),
        row("outline-width", &format!("{CAMERA} --silhouette"), "--outline-width 3").or(&["--silhouette"]),
        row("outline-color", &format!("{CAMERA} --silhouette"), "--outline-color red").or(&["--silhouette"]),
        at("depth-cue", "--depth-cue"),
        row("depth-cue-strength", &format!("{CAMERA} --depth-cue"), "--depth-cue-strength 0.9").or(&["--depth-cue"]),
        row("layers", &format!("{CAMERA} --opacity 0.5"), "--layers 3").or(&["--opacity"]),
        row("opacity-shadows", &format!("{CAMERA} --opacity 0.5 --sun 1,1,1 --shadows"), "--opacity-shadows")
            .or(&["--opacity", "lights and a sky need all spheres in memory"]),
        row("ghost-rim", &format!("{CAMERA} --opacity 0.5"), "--ghost-rim").or(&["--opacity"]),
        at("shade", "--shade normal"),
        at("background", "--background white"),
        at("transparent", "--transparent"),
        at("accuracy", "--accuracy exact").into("-o p.png --aov certainty=p.c.npy"),
        at("method", "--method textbook").into("-o p.png --aov certainty=p.c.npy"),
        at("tolerance", "--tolerance 3e-9").into("-o p.png --aov certainty=p.c.npy"),
        at("fps", "--fps 9").does(Fails),
        at("aov", "--aov normal=p.n.npy").does(Bytes),
        at("aov", "--aov shadow=p.s.npy --sun 1,1,1").does(Bytes),
        at("cryptomatte", "--cryptomatte kind --samples 4").into("-o p.exr").does(Bytes),
        at("group", "--group kind --shade flat").into("-o p.svg").does(Bytes).or(FIGURE),
        at("detail", "--detail 30").into("-o p.svg").does(Bytes).or(FIGURE),
        at("bits", "--bits 16").does(Bytes),
        at("dpi", "--dpi 300").does(Bytes),
        at("trim", "--trim").into("-o p.png --aov id=p.i.npy").does(Bytes),
        at("unit", "--unit 0.1").into("--aov depth=p.z.png"),
        at("no-return", "--no-return nan"),
        at("raw", "--raw").into("--aov id=-"),
        at("json", "--json").does(Nothing),
        at("progress", "--progress json").does(Nothing),
        at("preview", "--preview=blocks").does(Nothing),
        at("repeat", "--repeat 2").does(Nothing),
        at("quiet", "--quiet").does(Nothing),
    ]
}

impl Row {
    /// The option is the size.
    fn sized(mut self, size: &str) -> Self {
        self.with = self.with.replace("12x9", size);
        self
    }

    /// All renderings have another size.
    fn sized_all(mut self, size: &str) -> Self {
        (self.base, self.with) = (self.base.replace("12x9", size), self.with.replace("12x9", size));
        self
    }

    /// The option is the look.
    fn looking(mut self, look: &str) -> Self {
        self.with = self.with.replace("plain", look);
        self
    }
}

/// A sphere of the walk: centre, radius, kind and value.
type Sphere = ([f64; 3], f64, &'static str, f64);

/// The folder of the walk.
pub(crate) fn dir() -> TestDir {
    let mut rng = Rng::new(5);
    let (mut film, mut elements, mut dump, mut top) =
        (String::new(), String::from("150\n\n"), String::new(), String::new());
    let mut rows: Vec<Sphere> = Vec::new();
    for n in 0..150 {
        let [x, y, z] = rng.cube().map(|x| 2.0 + 2.6 * x);
        // Most are hidden by one in front of them.
        let at = if n == 7 { [4.0, 3.4, 4.8] } else { [x, y, z] };
        rows.push((at, if n == 7 { 1.3 } else { 0.1 + 0.2 * rng.unit() }, ["a", "b", "c"][n % 3], 0.1 + rng.unit()));
    }
    for frame in 0..2 {
        let columns = "species:S:1:pos:R:3:radius:R:1:kind:S:1:v:R:1:u:R:1";
        writeln!(film, "150\nLattice=\"4 0 0 0 4 0 0 0 4\" Time={frame}.5 Properties={columns}").expect("text");
        writeln!(dump, "ITEM: TIMESTEP\n{frame}\nITEM: NUMBER OF ATOMS\n150\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4")
            .expect("text");
        writeln!(dump, "ITEM: ATOMS id x y z radius ix iy iz").expect("text");
        for n in 0..150 {
            let k = if frame == 1 { (n + 40) % 150 } else { n };
            let ([x, y, z], radius, kind, v) = rows[k];
            let x = x + 0.4 * f64::from(frame);
            writeln!(
                film,
                "{} {x:.4} {y:.4} {z:.4} {radius:.4} {kind} {v:.4} {}",
                ["C", "O"][k % 2],
                if k % 4 == 3 { f64::NAN } else { v }
            )
            .expect("text");
            writeln!(dump, "{} {x:.4} {y:.4} {z:.4} {radius:.4} {} 0 0", k + 1, k % 2).expect("text");
        }
    }
    let mut pdb = String::from("REMARK 350 BIOMOLECULE: 1\nREMARK 350 APPLY THE FOLLOWING TO CHAINS: A\n");
    for (number, shift) in [(1, 0.0), (2, 3.0)] {
        for (k, row) in (1..).zip([[1.0, 0.0, 0.0, shift], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]) {
            let [a, b, c, d] = row;
            writeln!(pdb, "REMARK 350   BIOMT{k} {number:3} {a:9.6} {b:9.6} {c:9.6} {d:14.5}").expect("text");
        }
    }
    let atom = |text: &mut String, n: usize, alt: char, [x, y, z]: [f64; 3]| {
        let element = ["C", "O"][n % 2];
        writeln!(
            text,
            "ATOM  {:5}  {element}  {alt}GLY A{:4}    {x:8.3}{y:8.3}{z:8.3}  1.00  9.00           {element}",
            n + 1,
            n / 10 + 1
        )
        .expect("text");
    };
    for model in 1..=2 {
        writeln!(pdb, "MODEL     {model:4}").expect("text");
        for (n, (at, ..)) in rows.iter().enumerate() {
            atom(&mut pdb, n, ['A', 'B', ' '][n % 3], at.map(|x| x + 0.3 * f64::from(model)));
        }
        pdb += "ENDMDL\n";
    }
    for (n, (at, ..)) in rows.iter().enumerate() {
        atom(&mut top, n, ' ', *at);
        let [x, y, z] = at;
        writeln!(elements, "{} {x:.4} {y:.4} {z:.4}", ["C", "O", "Fe"][n % 3]).expect("text");
    }
    let list = |row: &dyn Fn(&Sphere) -> String| rows.iter().map(row).collect::<String>();
    let numbers = |([x, y, z], radius, ..): &Sphere| format!("{x:.4},{y:.4},{z:.4},{radius:.4}\n");
    let scene = "[camera]\neye = [9.0, 7.0, 12.0]\nat = [1.0, 2.0, 2.0]\nup = [0.0, 1.0, 0.0]\nvfov = 50.0\n[image]\nsize = [12, 9]\n\
                 [[spheres]]\nfile = \"t.csv\"\n";
    let data = list(&|([x, y, z], radius, ..)| format!("{x:.4} {y:.4} {z:.4} {radius:.4}\n"));
    let data: String = data
        .lines()
        .enumerate()
        .map(|(n, line)| {
            let (at, radius) = line.rsplit_once(' ').expect("a radius");
            format!("{} 1 {:.4} 1.0 {at}\n", n + 1, 2.0 * radius.parse::<f64>().expect("a number"))
        })
        .collect();
    let mesh = "ply\nformat ascii 1.0\nelement vertex 150\nproperty float x\nproperty float y\nproperty float z\nproperty float radius\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let camera = |eye: &str, lens: &str| format!("{{\"eye\":[{eye}],\"at\":[2,2,2],\"up\":[0,1,0]{lens}}}");
    let one = |lens: &str| format!("[{}]", camera("9,7,12", lens));
    let two = |lens: &str| format!("[{},{}]", camera("9,7,12", lens), camera("12,7,9", lens));
    let lens = ",\"w\":14,\"h\":10,\"K\":[[13,0,6],[0,14,5],[0,0,1]]";
    let curved = ",\"K\":[[12,0,6],[0,12,4],[0,0,1]],\"k1\":-0.2";
    let cif = "data_s\n_cell_length_a 4\n_cell_length_b 4\n_cell_length_c 4\n_cell_angle_alpha 90\n_cell_angle_beta 90\n_cell_angle_gamma 90\n\
               loop_\n_symmetry_equiv_pos_as_xyz\nx,y,z\n-x,-y,z\nloop_\n_atom_site_label\n_atom_site_type_symbol\n_atom_site_fract_x\n\
               _atom_site_fract_y\n_atom_site_fract_z\n";
    let sites = list(&|([x, y, z], ..)| format!("C1 C {:.4} {:.4} {:.4}\n", x / 5.0, y / 5.0, z / 5.0));
    let dir = in_blocks(&[
        ("f.xyz", &film),
        ("e.xyz", &elements),
        ("f.dump", &dump),
        ("m.pdb", &pdb),
        ("top.pdb", &top),
        ("t.csv", &format!("x,y,z,radius\n{}", list(&numbers))),
        ("bare.dat", &list(&numbers)),
        ("named.csv", &format!("a,b,c,d\n{}", list(&numbers))),
        ("bad.csv", &format!("x,y,z,radius\n{}nan,0,0,1\n", list(&numbers))),
        ("mesh.ply", &format!("{mesh}{}3 0 1 2\n", list(&numbers).replace(',', " "))),
        (
            "lammps.data",
            &format!("LAMMPS\n\n150 atoms\n1 atom types\n\n0 4 xlo xhi\n0 4 ylo yhi\n0 4 zlo zhi\n\nAtoms\n\n{data}"),
        ),
        ("s.cif", &format!("{cif}{sites}")),
        ("s.toml", scene),
        ("one.json", &one(lens)),
        ("two.json", &two(lens)),
        ("bare.json", &one("")),
        ("curved.json", &one(curved)),
        ("curved2.json", &two(curved)),
    ]);
    program(&dir);
    dir
}

/// A folder with these files, which are read in blocks of a few rows.
fn in_blocks(files: &[(&str, &str)]) -> TestDir {
    TestDir::new(files).in_parts(20_000)
}

/// A picture with some options of drawn rows together, by a drawn camera.
pub(crate) fn drawn(rng: &mut Rng, rows: &[Row]) -> Row {
    let base = format!("--size 12x9 --look plain {CAMERA}");
    let fit: Vec<&Row> =
        rows.iter().filter(|row| row.file == "f.xyz" && row.base == base && row.files.is_none()).collect();
    let camera = ["", CAMERA, CAMERA, "--cameras one.json", "--camera-from s.toml"][rng.below(5)];
    let mut all = row("", camera, "").does(Effect::Any);
    for _ in 0..2 + rng.below(2) {
        let one = fit[rng.below(fit.len())];
        all.with += one.with.strip_prefix(&base).unwrap_or_default();
    }
    all
}

/// A program that keeps the pictures of a film as they are, in place of one that encodes them.
fn program(dir: &TestDir) {
    std::fs::create_dir(dir.path("bin")).expect("a folder");
    dir.put("bin/ffmpeg", "#!/bin/sh\nfor last; do :; done\nexec /bin/cat > \"$last\"\n");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(dir.path("bin/ffmpeg"), std::fs::Permissions::from_mode(0o755)).expect("a program");
    }
}
