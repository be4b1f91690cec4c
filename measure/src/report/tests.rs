use super::*;
use crate::plot::sample;
use crate::record::Run;

fn page_of(record: &Record) -> String {
    page(record, &plots(record).expect("plots"))
}

#[test]
fn the_page_loads_no_other_file() {
    for record in [sample::ladder(), sample::scene(), sample::families(), Record::default()] {
        let page = page_of(&record);
        for resource in ["http", "src=", "<script", "@import", "url(", "<link", "href="] {
            assert!(!page.contains(resource), "{resource} in the report of {}", record.subject);
        }
    }
}

#[test]
fn the_page_names_every_method_and_place_and_escapes_them() {
    let mut record = sample::families();
    record.runs[0].method = "<i>&\"'".into();
    let page = page_of(&record);
    record.runs.iter().for_each(|run| assert!(page.contains(&escaped(&run.method)), "{}", run.method));
    assert!(page.contains("&lt;i&gt;&amp;&quot;&#39;"));
    assert!(page.contains("SYNTHETIC H200 &lt;not measured&gt;"));
    assert!(page.contains("refused: no &lt;reason&gt;"));
    assert!(page.contains("--out &lt;dir&gt;"), "the command");
    assert!(!page.contains("<not measured>") && !page.contains("<i>") && !page.contains("<dir>"));
}

#[test]
fn a_wrong_run_has_a_warning_and_a_right_one_has_none() {
    let sound = sample::ladder();
    // A plot is of no run's promise, so one drawing of them is enough.
    let drawn = plots(&sound).expect("plots");
    assert!(!page(&sound, &drawn).contains("BROKEN"));
    type Plant = fn(&mut Run);
    let planted: [(&str, Plant); 4] = [
        ("certified", |run| run.errors.false_miss = 1),
        ("certified", |run| run.of_bound = Some(1.25)),
        ("unit", |run| run.predicted.distance = Some(1e-9)),
        ("unit", |run| (run.errors.outline, run.predicted.outline) = (None, Some(1e9))),
    ];
    for (method, plant) in planted {
        let mut record = sound.clone();
        plant(record.runs.iter_mut().find(|run| run.method == method).expect("a run"));
        let page = page(&record, &drawn);
        assert!(page.contains("<p class=\"shout\"><strong class=\"broken\">BROKEN</strong>"), "{method}");
        assert!(page.contains("1 run broke a promise"), "{method}");
    }
}

#[test]
fn the_files_are_flat_in_the_folder() {
    let dir = tempfile::tempdir().expect("a folder");
    let paths = write(&sample::scene(), dir.path()).expect("a report");
    let mut names: Vec<_> = paths.iter().map(|path| path.file_name().expect("a name").to_owned()).collect();
    let mut found: Vec<_> =
        std::fs::read_dir(dir.path()).expect("a folder").map(|file| file.expect("a file").file_name()).collect();
    names.sort();
    found.sort();
    assert_eq!(names, found);
    assert_eq!(
        found,
        [
            "heat.png",
            "heat.svg",
            "report.html",
            "speed-distance.png",
            "speed-distance.svg",
            "speed-error.png",
            "speed-error.svg"
        ]
    );
    let again = std::fs::read(dir.path().join("report.html")).expect("the report");
    assert_eq!(again, page_of(&sample::scene()).into_bytes(), "the same record, the same bytes");
}

#[test]
fn the_summary_names_the_best_methods_and_those_outside_the_chart() {
    let page = page_of(&sample::ladder());
    let says = |words: &str| assert!(page.contains(words), "{words}");
    says("the fastest method without a wrong pixel is stable at");
    says("off the chart (more than 1 % wrong) at 1e4: textbook, unit, geometric.");
    says("Right in every pixel at every distance: stable, f64, double-float, certified, exact.");
    says("no error exceeded its bound or its prediction");
}
