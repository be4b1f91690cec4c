//! The promise of echoes: they equal a brute force over all rays of a beam and all spheres in f64. They have seeded noise of
//! the requested distribution, and are the same in every format and whatever the blocks.

use crate::rng::Rng;
use crate::test_dir::TestDir;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

/// A sphere of the scene: centre, radius, colour.
type Sphere = (DVec3, f64, [f64; 3]);

/// A row of .csv: ring, column, return, returns, id, distance, intensity, x, y, z, certainty.
type Row = [f64; 11];

const HEADER: &str = "ring,column,return_number,number_of_returns,id,distance,intensity,x,y,z,certainty";

/// A camera at the origin that looks along -z, and these spheres.
fn scene(spheres: &[Sphere]) -> String {
    let mut text = "[camera]\neye = [0, 0, 0]\nview = [0, 0, -1]\nup = [0, 1, 0]\nvfov = 60\n".to_owned();
    for (center, radius, color) in spheres {
        let center = center.to_array();
        write!(text, "\n[[sphere]]\ncenter = {center:?}\nradius = {radius:?}\ncolor = {color:?}\n").expect("text");
    }
    text
}

fn trace(dir: &TestDir, words: &str) -> crate::test_dir::Output {
    dir.good(&format!("trace s.toml --backend cpu {words}"))
}

/// The rows of .csv.
fn rows(dir: &TestDir, pattern: &str) -> Vec<Row> {
    let text = trace(dir, &format!("--pattern {pattern} -o -")).text();
    let (header, rest) = text.split_once('\n').expect("a header");
    assert_eq!(header, HEADER);
    let row = |line: &str| line.split(',').map(|word| word.parse().expect("a number")).collect::<Vec<f64>>();
    rest.lines().map(|line| row(line).try_into().expect("11 numbers")).collect()
}

/// The rays of a cone by its definition in docs/trace.md: the axis, and 6 and 12 rays round it. Inside their circles
/// are 4 and 13 of 19 shares of the solid angle 2 pi (1 - cos(divergence/2)).
fn cone([elevation, azimuth, divergence]: [f64; 3]) -> Vec<DVec3> {
    let [e, a, d] = [elevation, azimuth, divergence].map(f64::to_radians);
    let axis = DVec3::new(e.cos() * a.sin(), e.sin(), -e.cos() * a.cos());
    let right = DVec3::new(a.cos(), 0.0, a.sin());
    let mut rays = vec![axis];
    for (count, shares, first) in [(6, 4.0, 0.0), (12, 13.0, PI / 12.0)] {
        let along = 1.0 - shares / 19.0 * (1.0 - (d / 2.0).cos());
        for n in 0..count {
            let turn = first + TAU * f64::from(n) / f64::from(count);
            let out = turn.cos() * right + turn.sin() * right.cross(axis);
            rays.push(along * axis + (1.0 - along * along).sqrt() * out);
        }
    }
    rays
}

/// The nearest sphere of a ray from the origin, its distance and the cosine at the hit.
fn nearest(direction: DVec3, spheres: &[Sphere]) -> Option<(usize, f64, f64)> {
    let hit = |(id, (center, radius, _)): (usize, &Sphere)| {
        let along = center.dot(direction);
        let half = (radius * radius - center.length_squared() + along * along).sqrt();
        let t = [along - half, along + half].into_iter().find(|t| *t > 0.0)?;
        Some((id, t, ((t * direction - center) / radius).dot(direction).abs()))
    };
    spheres.iter().enumerate().filter_map(hit).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The echoes of a beam: sphere, distance and intensity.
fn echoes(rays: &[DVec3], spheres: &[Sphere], returns: usize) -> Vec<(usize, f64, f64)> {
    let hits: Vec<_> = rays.iter().filter_map(|ray| nearest(*ray, spheres)).collect();
    let echo = |id: usize| {
        let own: Vec<_> = hits.iter().filter(|hit| hit.0 == id).collect();
        let [red, green, blue] = spheres[id].2;
        let light = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        let [distance, cosines] = [own.iter().map(|hit| hit.1).sum::<f64>(), own.iter().map(|hit| hit.2).sum()];
        (!own.is_empty()).then(|| (id, distance / own.len() as f64, light * cosines / 19.0))
    };
    let mut all: Vec<_> = (0..spheres.len()).filter_map(echo).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all.truncate(returns);
    all
}

/// Spheres round the eye, some in front of others.
fn cloud() -> Vec<Sphere> {
    let mut rng = Rng::new(5);
    let sphere = |_| {
        let center = DVec3::from_array(rng.cube()).normalize() * (4.0 + 8.0 * rng.unit());
        (center, 0.5 + rng.unit(), rng.cube().map(|c| 0.5 + 0.5 * c))
    };
    (0..150).map(sphere).collect()
}

#[test]
fn echoes_are_those_of_every_ray_and_every_sphere() {
    let spheres = cloud();
    let dir = TestDir::new(&[("s.toml", &scene(&spheres))]);
    let mut most = 0;
    for returns in [15, 2] {
        let found = rows(&dir, &format!("lidar:rings=3,vfov=-40..50,step=20,divergence=15,returns={returns}"));
        let mut found = found.iter();
        for (ring, elevation) in [50.0, 5.0, -40.0].into_iter().enumerate() {
            for column in 0..18 {
                let rays = cone([elevation, -180.0 + 20.0 * f64::from(column), 15.0]);
                let expected = echoes(&rays, &spheres, returns);
                most = most.max(expected.len());
                for (n, (id, distance, intensity)) in expected.iter().enumerate() {
                    let row = found.next().expect("an echo");
                    let numbers = [ring, column as usize, n + 1, expected.len(), *id].map(|n| n as f64);
                    assert_eq!(row[..5], numbers, "{row:?}");
                    // Distances are promised to 1e-5 of themselves, normals to 1e-3 rad.
                    assert!((row[5] / distance - 1.0).abs() < 1e-5, "{row:?}, not {distance}");
                    assert!((row[6] - intensity).abs() < 1e-3, "{row:?}, not {intensity}");
                    // On the axis, to some roundings.
                    let position = DVec3::new(row[7], row[8], row[9]);
                    assert!(position.distance(rays[0] * row[5]) < 1e-14 * row[5], "{row:?}");
                    assert!(row[10] <= 1.0, "{row:?} is certified");
                }
            }
        }
        assert_eq!(found.next(), None);
    }
    assert!(most >= 4, "at most {most} echoes");
}

/// The beam passes the edge of a near sphere, whose rays are those that `--rays` finds on it.
#[test]
fn a_beam_on_an_edge_has_two_returns() {
    let spheres = [(DVec3::new(1.02, 0.0, -5.0), 1.0, [0.25; 3]), (DVec3::new(0.0, 0.0, -100.0), 10.0, [0.5; 3])];
    let dir = TestDir::new(&[("s.toml", &scene(&spheres))]);
    let pattern = "lidar:rings=1,step=1,azimuth=0,divergence=2";
    let two = rows(&dir, &format!("{pattern},returns=3"));
    trace(&dir, &format!("--pattern {pattern} --rays-out beam.npy -o scan.npz"));
    let text = trace(&dir, "--rays beam.npy -o -").text();
    let ids: Vec<_> = text.lines().skip(1).map(|line| line.split(',').next().expect("an id").to_owned()).collect();
    let far = ids.iter().filter(|id| *id == "1").count();
    assert!(ids.len() == 19 && (7..19).contains(&far) && !ids.contains(&"-1".to_owned()), "{ids:?}");
    assert_eq!(two.iter().map(|row| [row[2], row[3], row[4]]).collect::<Vec<_>>(), [[1.0, 2.0, 0.0], [2.0, 2.0, 1.0]]);
    // Between the nearest point of the near sphere and its tangents.
    let far_off = spheres[0].0.length();
    assert!((far_off - 1.0..(far_off * far_off - 1.0).sqrt()).contains(&two[0][5]), "{two:?}");
    // The rays pass the middle of the far sphere within 100 sin(1 degree), 0.175 of its radius, which is the sine of the
    // angle of incidence: its cosine is more than 0.98.
    assert!((90.0..90.2).contains(&two[1][5]), "{two:?}");
    let share = 0.5 * far as f64 / 19.0;
    assert!((0.98 * share..=share).contains(&two[1][6]), "{two:?}, not {share}");
    // The nearest is the only one of a scanner with one return.
    let one = rows(&dir, pattern);
    assert_eq!(one.len(), 1);
    assert_eq!((one[0][3], &one[0][4..]), (1.0, &two[0][4..]));
}

/// Inside of a sphere of radius 10 every distance is 10 without noise, and every beam has one echo.
#[test]
fn noise_has_its_distribution_and_its_seed() {
    let dir = TestDir::new(&[("s.toml", &scene(&[(DVec3::ZERO, 10.0, [0.5; 3])]))]);
    let distances = |keys: &str, certainty: f64| -> Vec<f64> {
        let rows = rows(&dir, &format!("lidar:rings=100,vfov=-90..90,step=1{keys}"));
        assert!(rows.len() == 36_000 && rows.iter().all(|row| row[4] == 0.0 && row[10] == certainty), "{keys}");
        // Lambert's intensity of rays along the normals.
        assert!(rows.iter().all(|row| (row[6] - 0.5).abs() < 1e-6), "{keys}");
        rows.iter().map(|row| row[5]).collect()
    };
    let noisy = distances(",noise=0.25,seed=3", 255.0);
    let (n, normal) = (noisy.len() as f64, noisy.iter().map(|x| (x - 10.0) / 0.25).collect::<Vec<_>>());
    let mean = normal.iter().sum::<f64>() / n;
    let square = normal.iter().map(|x| x * x).sum::<f64>() / n;
    let inside = normal.iter().filter(|x| x.abs() < 1.0).count() as f64 / n;
    let next = normal.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / (n - 1.0);
    // Five standard errors: of a mean, of a mean of squares, of the share within a deviation, of a correlation.
    let share: f64 = 0.682_689_492;
    for (found, expected, error) in [
        (mean, 0.0, 1.0),
        (square, 1.0, 2f64.sqrt()),
        (inside, share, (share * (1.0 - share)).sqrt()),
        (next, 0.0, 1.0),
    ] {
        assert!((found - expected).abs() < 5.0 * error / n.sqrt(), "{found}, not {expected}");
    }
    let differ = |other: &[f64]| noisy.iter().zip(other).filter(|(a, b)| a != b).count();
    assert_eq!(differ(&distances(",noise=0.25,seed=3", 255.0)), 0);
    assert!(differ(&distances(",noise=0.25,seed=4", 255.0)) > 35_900);
    assert_eq!(distances(",noise=0.25", 255.0), distances(",noise=0.25,seed=0", 255.0));
    // Never behind the scanner.
    let low = distances(",noise=100", 255.0);
    assert!(low.iter().all(|x| *x >= 0.0) && low.contains(&0.0));
    let exact = distances(",divergence=0.2,returns=2", 0.0);
    assert!(exact.iter().all(|x| (x / 10.0 - 1.0).abs() < 1e-5));
}

const SCAN: &str = "--pattern lidar:rings=9,vfov=-40..40,step=9,divergence=12,returns=4,noise=0.01,seed=8";

#[test]
fn every_format_has_the_numbers_of_the_rows_whatever_the_blocks() {
    let text = scene(&cloud());
    let make = || TestDir::new(&[("s.toml", &text)]);
    // Blocks of 105 rays, which are five beams.
    let (dir, parts) = (make(), make().in_parts(5000));
    for name in ["a.csv", "a.npz", "a.ply", "a.pcd", "a.las"] {
        let report = trace(&dir, &format!("{SCAN} -o {name} --json")).json();
        trace(&parts, &format!("{SCAN} -o {name}"));
        assert!(dir.get(name) == parts.get(name), "{name}: other bytes");
        let pattern = &report["pattern"];
        assert_eq!((&report["rays"], &pattern["rings"], &pattern["azimuths"]), (&6840.into(), &9.into(), &40.into()));
        assert_eq!(
            [&pattern["divergence"], &pattern["returns"], &pattern["noise"], &pattern["seed"]].map(|n| n.as_f64()),
            [12.0, 4.0, 0.01, 8.0].map(Some)
        );
    }
    let rows = rows(&dir, SCAN.trim_start_matches("--pattern "));
    let report = trace(&dir, &format!("{SCAN} -o a.las --json"));
    let beams = rows.iter().filter(|row| row[2] == 1.0).count();
    let (cloud, json) = (report.json()["cloud"].clone(), report.json());
    assert_eq!((&cloud["points"], &json["echoes"]), (&rows.len().into(), &rows.len().into()));
    assert_eq!(cloud["left_out"], 360 - beams);
    assert!(report.err.contains(&format!("{} beams without an echo left out", 360 - beams)), "{}", report.err);

    let (las, four) = (dir.get("a.las"), |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().expect("four bytes")));
    let eight = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
    for n in 0..15 {
        let count = rows.iter().filter(|row| row[2] == (n + 1) as f64).count() as u64;
        assert_eq!(las[255 + 8 * n..][..8], count.to_le_bytes(), "return {}", n + 1);
    }
    assert!(las[247..255] == (rows.len() as u64).to_le_bytes() && beams < rows.len());
    let after = |bytes: &[u8], end: &[u8]| {
        let start = bytes.windows(end.len()).position(|part| part == end).expect("an end") + end.len();
        (String::from_utf8_lossy(&bytes[..start]).into_owned(), bytes[start..].to_vec())
    };
    let (ply_head, ply) = after(&dir.get("a.ply"), b"end_header\n");
    let (pcd_head, pcd) = after(&dir.get("a.pcd"), b"DATA binary\n");
    let own = ["ring", "column", "return_number", "number_of_returns"].map(|name| format!("property uint {name}\n"));
    assert!(ply_head.contains(&(own.concat() + "property float intensity\nproperty uchar red\n")), "{ply_head}");
    let own = "id ring column return_number number_of_returns intensity rgb\nSIZE 4 4 4 4 4 4 4 4 4 4 4\n\
        TYPE F F F F I U U U U F F\nCOUNT 1 1 1 1 1 1 1 1 1 1 1\n";
    assert!(pcd_head.contains(own), "{pcd_head}");
    assert_eq!((ply.len(), pcd.len()), (59 * rows.len(), 44 * rows.len()));
    let las = &las[four(&las[96..100]) as usize..];
    for (n, row) in rows.iter().enumerate() {
        let (ply, pcd, las) = (&ply[59 * n..][..59], &pcd[44 * n..][..44], &las[56 * n..][..56]);
        let numbers = |bytes: &[u8]| -> Vec<f64> { bytes.chunks(4).map(|bytes| f64::from(four(bytes))).collect() };
        let single = |bytes: &[u8]| f64::from(f32::from_bits(four(bytes)));
        let places = [row[4], row[0], row[1], row[2], row[3]];
        let intensity = f64::from(row[6] as f32);
        let position: Vec<_> = [0, 8, 16, 24].map(|at| eight(&ply[at..at + 8])).into();
        assert_eq!(position, [row[7], row[8], row[9], row[5]]);
        assert_eq!((numbers(&ply[32..52]), single(&ply[52..56])), (places.to_vec(), intensity));
        assert_eq!((single(&pcd[12..16]), numbers(&pcd[16..36])), (f64::from(row[5] as f32), places.to_vec()));
        assert_eq!(single(&pcd[36..40]), intensity);
        // ASPRS, LAS 1.4 R15, table 13: intensity from byte 12, the return in the low and the returns in the high four bits.
        assert_eq!(f64::from(u16::from_le_bytes([las[12], las[13]])), (intensity * 65535.0).round());
        assert_eq!((f64::from(las[14] & 15), f64::from(las[14] >> 4)), (row[2], row[3]));
        assert_eq!((eight(&las[36..44]), numbers(&las[44..])), (row[5], places[..3].to_vec()));
    }
}

#[test]
fn an_archive_has_a_row_for_each_echo() {
    let dir = TestDir::new(&[("s.toml", &scene(&cloud()))]);
    trace(&dir, &format!("{SCAN} -o a.npz"));
    let rows = rows(&dir, SCAN.trim_start_matches("--pattern "));
    let file = std::fs::File::open(dir.path("a.npz")).expect("an archive");
    let mut zip = zip::ZipArchive::new(file).expect("an archive");
    for (name, first, width) in [
        ("ring", 0, 1),
        ("column", 1, 1),
        ("return_number", 2, 1),
        ("number_of_returns", 3, 1),
        ("id", 4, 1),
        ("distance", 5, 1),
        ("intensity", 6, 1),
        ("position", 7, 3),
        ("certainty", 10, 1),
    ] {
        let mut bytes = Vec::new();
        let mut member = zip.by_name(&format!("{name}.npy")).expect(name);
        std::io::Read::read_to_end(&mut member, &mut bytes).expect("its bytes");
        drop(member);
        dir.put("member.npy", bytes);
        let (values, shape) = dir.array("member.npy");
        assert_eq!(shape, if width == 3 { vec![rows.len(), 3] } else { vec![rows.len()] }, "{name}");
        // Text has the fewest digits that give an f32 again.
        let expected = rows.iter().flat_map(|row| &row[first..first + width]);
        let equal = |(a, b): (&f64, &f64)| a == b || name == "intensity" && *a == f64::from(*b as f32);
        assert!(values.iter().zip(expected).all(equal), "{name}");
    }
    assert_eq!(zip.len(), 9);
}

#[test]
fn echoes_that_cannot_be_are_refused() {
    let dir = TestDir::new(&[("s.toml", &scene(&cloud()))]);
    for (words, message) in [
        ("noise=0.1 -o a.csv --any", &["--any finds no echoes", "remove --any"][..]),
        ("divergence=1 --json --any", &["--any finds no echoes"]),
        ("divergence=0 -o a.csv", &["divergence of the pattern", "degrees"]),
        ("divergence=1,returns=16 -o a.csv", &["returns of the pattern", "between 1 and 15"]),
        ("returns=2 -o a.csv", &["returns of the pattern is without divergence"]),
        ("noise=nan -o a.csv", &["noise of the pattern", "positive"]),
        ("divergence=1,seed=2 -o a.csv", &["seed of the pattern is without noise"]),
    ] {
        dir.refused(2, &format!("trace s.toml --backend cpu --pattern lidar:rings=1,step=9,{words}"), message);
    }
}
