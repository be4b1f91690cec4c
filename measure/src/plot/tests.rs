use super::axis::{Axis, Unit, number, rounded};
use super::growth::{Curve, Growth, Panel};
use super::plane::pareto;
use super::sample;
use super::*;
use crate::record::{Map, Run};
use halfline_drawing::canvas;
use halfline_drawing::cells::Cells;
use plotters::coord::ranged1d::{BoldPoints, Ranged, ValueFormatter};
use roxmltree::Document;
use std::sync::LazyLock;

fn samples() -> [Record; 3] {
    [sample::ladder(), sample::scene(), sample::families()]
}

fn drawn(record: &Record) -> Vec<Plot> {
    plots(record).expect("every plot can be drawn")
}

/// The samples with their plots, drawn once for all tests that only look at them.
fn shown() -> &'static [(Record, Vec<Plot>)] {
    static SHOWN: LazyLock<Vec<(Record, Vec<Plot>)>> =
        LazyLock::new(|| samples().into_iter().map(|record| (record.clone(), drawn(&record))).collect());
    &SHOWN
}

#[test]
fn a_record_has_the_plots_of_its_data() {
    let names = |record: &Record| drawn(record).iter().map(|plot| plot.name).collect::<Vec<_>>();
    let distances = ["error-distance", "error-distance-t", "error-distance-outline"];
    let timed = ["speed-error", "speed-distance"];
    assert_eq!(names(&sample::ladder()), [&timed[..], &distances, &["crops"]].concat());
    assert_eq!(names(&sample::scene()), [&timed[..], &["heat"]].concat());
    assert_eq!(names(&sample::families()), [&timed[..], &distances].concat());
    assert!(names(&Record::default()).is_empty());
}

#[test]
fn plots_are_well_formed_and_say_what_they_show() {
    let titles = [
        ("speed-error", ["time per ray (ns", "misclassified pixels (share of"]),
        ("speed-distance", ["time per ray (ns", "largest relative error |t"]),
        ("error-distance", ["farthest centre / radius", "misclassified pixels (share of"]),
        ("error-distance-t", ["farthest centre / radius", "largest relative error |t"]),
        ("error-distance-outline", ["farthest centre / radius", "outlines off by (radii)"]),
        ("heat", ["in a cell", "a wrong pixel in the cell"]),
        ("crops", ["distance / radius", "false miss"]),
    ];
    for (record, plots) in shown() {
        for plot in plots {
            let document = Document::parse(&plot.svg).unwrap_or_else(|error| panic!("{}: {error}", plot.name));
            let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
            let says = |words: &str| assert!(texts.iter().any(|text| text.contains(words)), "{}: {words}", plot.name);
            let (_, titles) = titles.iter().find(|(name, _)| *name == plot.name).expect("titles for every plot");
            titles.iter().for_each(|title| says(title));
            says(&record.subject);
            says("SYNTHETIC H200 <not measured>");
            // Every plot shows the first place.
            let shown = record.runs.iter().filter(|run| run.place == 0 && run.refused.is_none());
            shown.for_each(|run| says(&run.method));
        }
    }
}

#[test]
fn the_png_shows_the_plot() {
    for (_, plots) in shown() {
        for plot in plots {
            let picture = image::load_from_memory(&plot.png).expect("a readable PNG").to_rgb8();
            assert_eq!(picture.width(), 2000, "{}", plot.name);
            let inked = picture.pixels().filter(|pixel| pixel.0 != [255; 3]).count();
            let share = inked as f64 / f64::from(picture.width() * picture.height());
            assert!((0.01..0.9).contains(&share), "{}: {share} of it is drawn on", plot.name);
        }
    }
}

#[test]
fn text_is_drawn_without_system_fonts() {
    let word = |text: &str| {
        let drawing = canvas::drawing([2000, 100], |area| {
            canvas::text(area, text, &canvas::font(60), (20, 50))?;
            Ok(Vec::new())
        });
        drawing.expect("a drawing").levels
    };
    for letter in ["\u{207b}", "\u{2079}", "\u{b2}", "\u{2212}", "\u{2264}", "\u{d7}", "\u{b7}", "\u{2026}", "a"] {
        assert_ne!(word(letter), word(""), "{letter:?} is not in the font");
        assert_ne!(word(letter), word("\u{e000}"), "{letter:?} is not in the font");
    }
}

#[test]
fn the_same_record_gives_the_same_bytes() {
    for (record, plots) in shown() {
        assert_eq!(drawn(record), *plots);
    }
}

#[test]
fn an_invalid_record_causes_no_panic() {
    let mut record = sample::ladder();
    record.subject = "\u{1}\u{0} ]]> <b> & \"".into();
    record.runs[0].place = 99;
    record.runs[1].scene = 99;
    record.runs[2].steady_ms = vec![0.0];
    record.runs[3].method = "a new one <".into();
    record.runs[4].map = Some(Map { cell: 0, size: [9, 9], ..Map::default() });
    record.runs[5].crop = record.runs[5].crop.take().map(|crop| crate::record::Crop { size: [0, 7], ..crop });
    record.runs[6] = Run::default();
    for plot in drawn(&record) {
        Document::parse(&plot.svg).unwrap_or_else(|error| panic!("{}: {error}", plot.name));
    }
}

#[test]
fn growth_is_fitted_over_its_last_two_decades() {
    // Flat up to 1e4, then 3e-7 n^1.5.
    let time = |n: f64| if n < 1e4 { 0.3 } else { 3e-7 * n.powf(1.5) };
    let points = |last: i32| (2..=last).map(|e| 10f64.powi(e)).map(|n| [n, time(n)]).collect();
    let curve = |place, last| Curve { name: "cloud <of>".into(), place, points: points(last) };
    let [exponent, factor] = curve(0, 6).fit().expect("three points");
    assert!((exponent - 1.5).abs() < 1e-9 && (factor / 3e-7 - 1.0).abs() < 1e-6, "{factor} n^{exponent}");
    assert_eq!(curve(0, 3).fit(), None, "two points are not enough for a fit");
    let places = sample::scene().places;
    let panel = Panel {
        over: "spheres".into(),
        measured: "ms".into(),
        curves: (0..places.len()).map(|place| curve(place, 6)).collect(),
    };
    let empty = Panel::default();
    let plot = Growth { title: "Growth".into(), subject: "a test".into(), places, panels: vec![panel, empty] }
        .plot()
        .expect("a plot");
    let document = Document::parse(&plot.svg).expect("SVG");
    let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
    for words in ["n^1.50", "cloud <of>", "spheres", "a test"] {
        assert!(texts.iter().any(|text| text.contains(words)), "{words}");
    }
}

#[test]
fn the_pareto_front_has_no_faster_method_as_accurate() {
    assert_eq!(pareto(&[(3.0, 0.0), (1.0, 0.5), (2.0, 0.5), (1.5, 0.1), (9.0, 0.0)]), [1, 3, 0]);
    assert_eq!(pareto(&[(1.0, 0.5), (1.0, 0.2)]), [1], "of two that take as long the more exact one");
    assert!(pareto(&[]).is_empty());
}

#[test]
fn axis_labels_are_short() {
    let plain = [
        (1, -2, "0.01"),
        (5, -1, "0.5"),
        (2, 3, "2000"),
        (1, -12, "10\u{207b}\u{b9}\u{b2}"),
        (2, 5, "2\u{b7}10\u{2075}"),
    ];
    for (factor, decade, words) in plain {
        assert_eq!(number(factor, decade, Unit::Plain), words);
    }
    for (factor, decade, words) in [(1, 0, "100 %"), (5, -1, "50 %"), (2, -2, "2 %"), (1, -6, "0.0001 %")] {
        assert_eq!(number(factor, decade, Unit::Percent), words);
    }
    assert_eq!(rounded(9.7e5), "10\u{2076}");
    assert_eq!(rounded(1000.0), "1000");
}

#[test]
fn ticks_have_their_values() {
    for (low, high) in [(330.0, 48_000.0), (1e-14, 3.0), (0.2, 0.9), (2.0, 2.0), (1e-3, 2e5)] {
        let axis = Axis::new("", Unit::Plain, [Some(low), Some(high)].into_iter());
        let ticks = axis.key_points(BoldPoints(99));
        assert!(ticks.len() > 1 || high / low < 2.0, "{low} to {high}: {ticks:?}");
        for tick in ticks {
            let label = axis.format_ext(&tick);
            let digits = |c: char| {
                "\u{2070}\u{b9}\u{b2}\u{b3}\u{2074}\u{2075}\u{2076}\u{2077}\u{2078}\u{2079}"
                    .chars()
                    .position(|d| d == c)
            };
            let power: String = label
                .chars()
                .filter_map(|c| digits(c).map(|d| d.to_string()).or((c == '\u{207b}').then(|| "-".into())))
                .collect();
            let plain: String = label.chars().filter(|c| c.is_ascii_digit() || *c == '.').collect();
            let value = match (label.split_once('\u{b7}'), power.is_empty()) {
                (Some((factor, _)), _) => format!("{factor}e{power}"),
                (None, false) => format!("1e{power}"),
                (None, true) => plain,
            };
            let value: f64 = value.parse().expect("a number");
            assert!((value.log10() - tick).abs() < 1e-9, "{label} at {}", 10f64.powf(tick));
        }
    }
}

#[test]
fn cells_of_one_colour_are_one_path() {
    let svg = Cells::new((3, 4), 2.0, [3, 2], |cell| if cell == 1 { [255, 0, 0] } else { [0; 3] }).svg();
    assert!(svg.contains("translate(3 4) scale(2.00000)"), "{svg}");
    assert!(svg.contains(r##"<path fill="#000000" d="M0 0h3v2h-3z"/>"##), "{svg}");
    assert!(svg.contains(r##"<path fill="#ff0000" d="M1 0h1v1h-1z"/>"##), "{svg}");
}
