use super::*;
use crate::camera::{Camera, Lens};
use crate::testing::Rng;
use crate::window::Window;
use crate::{ImagePlane, Scene, Spheres};

/// A picture by parallel rays, a pixel being the unit of length.
struct Picture {
    width: usize,
    ids: Vec<u32>,
    depths: Vec<f64>,
    radii: Vec<f64>,
}

impl Picture {
    fn new(width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self { width, ids: vec![NONE; pixels], depths: vec![f64::INFINITY; pixels], radii: Vec::new() }
    }

    fn height(&self) -> usize {
        self.ids.len() / self.width
    }

    /// The distance of a pixel's centre from a point.
    fn distance_to(&self, pixel: usize, [x, y]: [f64; 2]) -> f64 {
        let [column, row] = [pixel % self.width, pixel / self.width].map(|n| n as f64 + 0.5);
        ((column - x).powi(2) + (row - y).powi(2)).sqrt()
    }

    fn sphere(&mut self, [x, y, depth]: [f64; 3], radius: f64) {
        let id = self.radii.len() as u32;
        self.radii.push(radius);
        let span = |x: f64, side: usize| {
            (x - radius - 1.0).max(0.0) as usize..(x + radius + 2.0).clamp(0.0, side as f64) as usize
        };
        for row in span(y, self.height()) {
            for pixel in span(x, self.width).map(|column| row * self.width + column) {
                let hit = depth - (radius.powi(2) - self.distance_to(pixel, [x, y]).powi(2)).sqrt();
                if hit < self.depths[pixel] {
                    (self.ids[pixel], self.depths[pixel]) = (id, hit);
                }
            }
        }
    }

    fn spheres(width: usize, height: usize, spheres: impl Iterator<Item = ([f64; 3], f64)>) -> Self {
        let mut picture = Self::new(width, height);
        spheres.for_each(|(center, radius)| picture.sphere(center, radius));
        picture
    }

    fn shown(&self, pixel: PixelSize) -> Shown<'_> {
        Shown {
            width: self.width,
            ids: &self.ids,
            depths: &self.depths,
            radii: &self.radii,
            materials: None,
            pixel,
            line: Line::new(Outline::default()),
        }
    }

    /// The darkness of each pixel, 0 to 1, drawn over white.
    fn lines(&self, between: bool) -> Vec<f32> {
        let mut color = vec![1.0; 3 * self.ids.len()];
        self.shown(PixelSize::Parallel(1.0)).draw(between, &mut color);
        assert!(color.chunks_exact(3).all(|rgb| rgb[0] == rgb[1] && rgb[1] == rgb[2]));
        color.chunks_exact(3).map(|rgb| 1.0 - rgb[0]).collect()
    }

    /// The mean darkness of hits.
    fn share(&self, between: bool) -> f64 {
        let hits = self.ids.iter().filter(|id| **id != NONE).count();
        total(&self.lines(between)) / hits as f64
    }
}

fn total(lines: &[f32]) -> f64 {
    lines.iter().map(|dark| f64::from(*dark)).sum()
}

/// Rows and columns at these depths, with the sphere of each.
fn planes(width: usize, height: usize, at: impl Fn(usize, usize) -> (u32, f64)) -> Picture {
    let mut picture = Picture::new(width, height);
    for pixel in 0..width * height {
        (picture.ids[pixel], picture.depths[pixel]) = at(pixel / width, pixel % width);
    }
    let spheres = picture.ids.iter().filter(|id| **id != NONE).max().map_or(0, |id| *id as usize + 1);
    picture.radii = vec![1e6; spheres];
    picture
}

/// The mean over the rim of a large sphere. Half of a pixel is the width of a row of neighbours that begins or ends to count.
#[test]
fn lines_have_the_width_of_the_outline() {
    let (center, radius) = ([110.3, 109.6], 90.0);
    let mut picture = Picture::new(220, 220);
    picture.sphere([center[0], center[1], 1e4], radius);
    for width in [0.2, 0.65, 1.3, 2.0, 2.6, 5.2, 10.4] {
        let ink = [0.25, 0.5, 1.0];
        let line = Line::new(Outline { width, color: ink });
        let mut color = vec![0.0; 3 * picture.ids.len()];
        Shown { line, ..picture.shown(PixelSize::Parallel(1.0)) }.draw(false, &mut color);
        assert!(color.chunks_exact(3).all(|rgb| rgb[0] == ink[0] * rgb[2] && rgb[1] == ink[1] * rgb[2]), "{width}");
        let covered: Vec<f32> = color.chunks_exact(3).map(|rgb| rgb[2]).collect();
        let found = total(&covered) / (2.0 * std::f64::consts::PI * radius);
        println!("width {width}: {found:.3}");
        assert!((found - width).abs() < (0.15 * width).max(if width > 1.3 { 0.5 } else { 0.0 }), "{width}: {found}");
        let farthest = covered.iter().enumerate().filter(|(_, dark)| **dark > 0.0);
        let farthest = farthest.map(|(pixel, _)| radius - picture.distance_to(pixel, center)).fold(0.0, f64::max);
        assert!(farthest < f64::from(line.margin()) * 2f64.sqrt(), "{width}: {farthest} of {}", line.margin());
    }
}

#[test]
fn a_large_sphere_has_one_closed_line_of_the_stated_width() {
    let (center, radius) = ([80.3, 79.6], 60.0);
    let mut picture = Picture::new(160, 160);
    picture.sphere([center[0], center[1], 1e4], radius);
    for between in [false, true] {
        let lines = picture.lines(between);
        let mut round = [0.0f32; 180];
        for (pixel, dark) in lines.iter().enumerate() {
            let inside = radius - picture.distance_to(pixel, center);
            assert!(*dark == 0.0 || (0.0..3.0).contains(&inside), "{dark} at {inside} inside the edge");
            let [x, y] = [pixel % 160, pixel / 160].map(|n| n as f64 + 0.5);
            let angle = (y - center[1]).atan2(x - center[0]).to_degrees();
            let angle = &mut round[(angle.rem_euclid(360.0) / 2.0) as usize];
            *angle = angle.max(*dark);
        }
        assert!(round.iter().all(|dark| *dark > 0.75), "a gap: {round:?}");
        let width = total(&lines) / (2.0 * std::f64::consts::PI * radius);
        println!("width {width:.3}");
        assert!((1.2..1.4).contains(&width), "{width}");
    }
    // Cut by the edge of the frame, it has no line there.
    let mut cut = Picture::new(160, 70);
    cut.sphere([center[0], center[1] - 60.0, 1e4], radius);
    let lines = cut.lines(true);
    assert!(lines[40..120].iter().all(|dark| *dark == 0.0), "no line at the edge of the frame");
    // The line of the sphere reaches it.
    let ends: Vec<_> = lines[..160].iter().enumerate().filter(|(_, dark)| **dark > 0.9).map(|(x, _)| x).collect();
    assert!(ends == [23, 136], "{ends:?}");
}

#[test]
fn spheres_at_equal_depths_have_lines_only_where_they_are_requested() {
    let cells = planes(96, 96, |row, column| ((row / 24 * 4 + column / 24) as u32, 50.0));
    assert_eq!(total(&cells.lines(false)), 0.0);
    let lines = cells.lines(true);
    // A border has one line, on the side of the lower id: full in one pixel and less in another.
    let row = &lines[96 * 12..96 * 12 + 40];
    assert!(row[23] == 1.0 && (0.2..0.6).contains(&row[22]), "{row:?}");
    assert!(row.iter().enumerate().all(|(column, dark)| *dark == 0.0 || column == 22 || column == 23), "{row:?}");
    // Six borders of 96 pixels.
    let width = total(&lines) / (6.0 * 96.0);
    assert!((1.2..1.5).contains(&width), "{width}");
    // A sphere far in front has its line once, whichever id is lower.
    for ids in [[0, 1], [1, 0]] {
        let step = planes(40, 20, |_, column| (ids[column / 20], if column < 20 { 50.0 } else { 90.0 }));
        assert_eq!(step.lines(true), step.lines(false));
        assert!(step.lines(true)[10 * 40 + 20..11 * 40].iter().all(|dark| *dark == 0.0), "on the nearer side");
    }
    // Whatever the gap, one of two spheres has a full line where lines are requested, and the other has none.
    for (gap, ids) in (0..60).flat_map(|gap| [[0, 1], [1, 0]].map(|ids| (gap, ids))) {
        let depth = [50.0, 50.0 + 0.5 * f64::from(gap)];
        let step = planes(40, 20, |_, column| (ids[column / 20], depth[column / 20])).lines(true);
        let mut sides = [step[10 * 40 + 19], step[10 * 40 + 20]];
        sides.sort_by(f32::total_cmp);
        assert_eq!(sides, [0.0, 1.0], "{gap} {ids:?}");
    }
}

#[test]
fn lines_grow_with_the_gap_and_not_with_the_unit() {
    let step = |gap: f64, unit: f64| {
        let mut step =
            planes(20, 9, |_, column| (column as u32 / 10, unit * if column < 10 { 64.0 } else { 64.0 + gap }));
        step.radii = vec![30.0 * unit; 2];
        let mut color = vec![1.0; 3 * 180];
        step.shown(PixelSize::Parallel(unit)).draw(false, &mut color);
        1.0 - color[3 * (4 * 20 + 9)]
    };
    let dark: Vec<f32> = (0..40).map(|gap| step(f64::from(gap), 1.0)).collect();
    assert!(dark.windows(2).all(|pair| pair[0] <= pair[1]), "{dark:?}");
    assert!(dark[14] == 0.0 && dark[15] > 0.0 && dark[20] < 1.0 && dark[21] == 1.0, "{dark:?}");
    for unit in [2f64.powi(-500), 2f64.powi(500)] {
        assert!((0..40).all(|gap| step(f64::from(gap), unit) == dark[gap as usize]), "{unit}");
    }
}

#[test]
fn small_spheres_stay_light_and_the_surface_that_they_make_up_has_a_line() {
    let mut rng = Rng(1);
    for (diameter, single, cloudy) in
        [(0.5, 0.0, 0.01), (1.0, 0.0, 0.01), (2.0, 0.0, 0.02), (4.0, 0.0, 0.05), (7.0, 0.0, 0.1)]
    {
        let radius = 0.5 * diameter;
        let single_share = Picture::spheres(64, 64, [([32.2, 31.7, 1e3], radius)].into_iter()).lines(true);
        assert!(total(&single_share) <= single, "{diameter}: a single sphere");
        // A deep cloud, which covers a fifth of the picture.
        let count = (160.0 * 160.0 * 0.25 / (diameter * diameter)) as usize;
        let mut place = |deep: f64| [rng.between(0.0, 160.0), rng.between(0.0, 160.0), 1e3 + rng.between(0.0, deep)];
        let cloud = (0..count).map(|_| (place(1e3), radius)).collect::<Vec<_>>();
        let cloud = Picture::spheres(160, 160, cloud.into_iter()).share(true);
        // A layer of several spheres on top of each other.
        let layer = (0..12 * count).map(|_| (place(3.0 * diameter), radius)).collect::<Vec<_>>();
        let layer = Picture::spheres(160, 160, layer.into_iter()).share(true);
        // A ball of them, of radius 60.
        let mut direction = || loop {
            let p: [f64; 3] = std::array::from_fn(|_| rng.between(-1.0, 1.0));
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length < 1.0 {
                return p.map(|x| x / length);
            }
        };
        let count = (200.0 * 60.0 * 60.0 / (diameter * diameter)) as usize;
        let ball: Vec<_> = (0..count).map(|_| (direction().map(|x| 60.0 * x + 80.0), radius)).collect();
        let picture = Picture::spheres(160, 160, ball.into_iter());
        let lines = picture.lines(true);
        let of = |range: std::ops::Range<f64>| {
            let inside = |(pixel, _): &(usize, &f32)| range.contains(&picture.distance_to(*pixel, [80.0; 2]));
            lines.iter().enumerate().filter(inside).map(|(_, dark)| f64::from(*dark)).sum::<f64>()
        };
        let around = of(50.0..70.0) / (2.0 * std::f64::consts::PI * (60.0 + radius));
        let within = of(0.0..45.0) / (std::f64::consts::PI * 45.0 * 45.0);
        println!(
            "diameter {diameter}: cloud {cloud:.3}, layer {layer:.3}, ball {around:.2} around, {within:.3} within"
        );
        assert!(cloud <= cloudy && layer < 0.08, "{diameter}: {cloud} {layer}");
        assert!((0.8..1.5).contains(&around) && within < 0.02, "{diameter}: {around} {within}");
    }
}

/// Points on a plane that ends at a horizon, 3 units below an eye that sees 0.001 units per pixel at depth 1.
#[test]
fn a_plain_at_a_grazing_angle_is_not_dark() {
    let slope = 1e-3;
    let plain = planes(64, 80, |row, column| match row {
        0..20 => (NONE, f64::INFINITY),
        _ => ((row * 64 + column) as u32, 3.0 / (slope * (row as f64 - 19.5))),
    });
    let mut color = vec![1.0; 3 * 64 * 80];
    plain.shown(PixelSize::Perspective(slope)).draw(false, &mut color);
    let dark = |row: usize| (0..64).map(|column| 1.0 - color[3 * (row * 64 + column)]).fold(0.0, f32::max);
    assert!((28..80).all(|row| dark(row) == 0.0), "{:?}", (20..80).map(dark).collect::<Vec<_>>());
    assert_eq!([dark(19), dark(20)], [0.0, 1.0], "the horizon");
}

/// Ids and depths without any order, some of them not numbers.
fn wild(rng: &mut Rng, width: usize, height: usize) -> Picture {
    let smooth = rng.below(2) == 0;
    let mut picture = planes(width, height, |row, column| {
        let id = if smooth { (row / 5 * 3 + column / 7) as u32 } else { rng_id(row, column) };
        (id, 0.0)
    });
    for (id, depth) in picture.ids.iter_mut().zip(&mut picture.depths) {
        *depth = match rng.below(40) {
            0 => f64::INFINITY,
            1 => f64::NAN,
            2 => 0.0,
            3 => f64::MAX,
            _ => f64::from(*id % 9) * 20.0 + rng.between(0.0, 10.0),
        };
        if rng.below(12) == 0 {
            (*id, *depth) = (NONE, if rng.below(2) == 0 { f64::INFINITY } else { 1.0 });
        }
    }
    picture.radii.iter_mut().for_each(|radius| *radius = rng.decade(-1.0, 3.0));
    picture
}

fn rng_id(row: usize, column: usize) -> u32 {
    ((row * 7 + column * 3) % 11) as u32
}

#[test]
fn a_window_with_its_margin_has_the_bits_of_the_whole_on_any_number_of_threads() {
    let mut rng = Rng(3);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for round in 0..300 {
        let (width, height) = (1 + rng.below(40), 1 + rng.below(40));
        let picture = wild(&mut rng, width as usize, height as usize);
        let own: Vec<f32> = (0..3 * width * height).map(|_| rng.unit() as f32).collect();
        let between = rng.below(2) == 0;
        let pixel = [PixelSize::Parallel(1.0), PixelSize::Perspective(0.01)][rng.below(2) as usize];
        let mut whole = own.clone();
        one.install(|| picture.shown(pixel).draw(between, &mut whole));
        assert!(whole.iter().zip(&own).all(|(new, old)| (0.0..=*old).contains(new)));
        assert!(width * height < 100 || whole != own, "some lines");
        let mut cut = |side: u32| {
            let (a, b) = (rng.below(side), rng.below(side));
            (a.min(b), a.max(b) + 1)
        };
        let ((x0, x1), (y0, y1)) = (cut(width), cut(height));
        let window = Window { x0, y0, x1, y1 };
        let crop = |from: &[f32], w: Window| -> Vec<f32> {
            let row = |y: u32| &from[3 * (y * width + w.x0) as usize..3 * (y * width + w.x1) as usize];
            (w.y0..w.y1).flat_map(row).copied().collect()
        };
        let wide = window.grown(Line::new(Outline::default()).margin(), width, height);
        let part = window.inside(wide);
        let pixels = || (wide.y0..wide.y1).flat_map(|y| (wide.x0..wide.x1).map(move |x| (y * width + x) as usize));
        let piece = Picture {
            width: wide.width() as usize,
            ids: pixels().map(|pixel| picture.ids[pixel]).collect(),
            depths: pixels().map(|pixel| picture.depths[pixel]).collect(),
            radii: picture.radii.clone(),
        };
        let mut color = crop(&own, wide);
        piece.shown(pixel).draw(between, &mut color);
        let rows = color.chunks_exact(3 * wide.width() as usize).skip(part.y0 as usize).take(part.height() as usize);
        let color: Vec<f32> = rows.flat_map(|row| &row[3 * part.x0 as usize..3 * part.x1 as usize]).copied().collect();
        assert_eq!(color, crop(&whole, window), "{round}: {window} of {width} x {height}");
    }
}

#[test]
fn the_size_of_a_pixel_is_the_cameras() {
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -3e5], 1.0, None);
    let image = ImagePlane { width: 100, height: 40, background: [0.0; 3] };
    let mut scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
    scene.camera.lens = Lens::Viewport { vw: 8.0, vh: 3.2, distance: 5.0 };
    let size = |scene: &Scene| PixelSize::of(&View::without_spheres(scene).expect("a view")).at(10.0);
    assert!((size(&scene) - 0.16).abs() < 1e-15, "{}", size(&scene));
    scene.camera.lens = Lens::Orthographic { height: 3.2 };
    assert!((size(&scene) - 0.08).abs() < 1e-15, "{}", size(&scene));
    // Of a frame with samples too, whose own pixels are finer.
    let raster = crate::view::raster::Raster::samples(Window::full(100, 40), 4, 0, &scene.image);
    let raster = raster.expect("room").expect("samples");
    let view = View::for_rays(&scene, raster, crate::view::Records::None).expect("a view");
    assert!((PixelSize::of(&view).at(10.0) - 0.08).abs() < 1e-15);
}
