//! The report as a page of Markdown.

use serde_json::{Value, json};

/// The exit codes of a step that reached its limit of time, and for which none was left.
const NO_TIME: [i64; 3] = [124, 137, 125];

/// The steps that say whether answers are right.
const CHECKS: [&str; 6] = ["adapters", "compare", "lattice", "suite", "tests", "rays"];

/// The page of all lines.
pub(crate) fn page(all: &[Value]) -> String {
    let of = |step: &'static str| all.iter().filter(move |line| line["step"] == step && line["code"] == 0);
    let mut out = String::from("# halfline on this machine\n\n");
    for line in all.iter().filter(|line| line["step"] == "machine") {
        out += &format!("- {}\n", cell(&line["what"]));
    }
    let adapters = of("adapters").flat_map(|line| {
        let list = |name: &str| line["result"][name].as_array().cloned().unwrap_or_default();
        list("adapters").into_iter().zip(list("verdicts")).map(|(a, v)| json!({ "a": a, "v": v })).collect::<Vec<_>>()
    });
    let columns = [
        ("adapter", "/a/name"),
        ("kind", "/a/kind"),
        ("driver", "/a/driver"),
        ("certifies", "/v/f32"),
        ("places", "/v/places"),
        ("keeps bits", "/v/strict_twin"),
        ("division, ulp", "/v/div_ulp"),
        ("root, ulp", "/v/sqrt_ulp"),
        ("flushes", "/v/flushes_subnormals"),
        ("double-float", "/v/double_float/by"),
        ("f64", "/a/f64"),
        ("subgroups", "/a/subgroup"),
    ];
    table(&mut out, "Adapters", &columns, adapters);
    let bad = checks(&mut out, all);
    let frames = [
        ("spheres", "/result/spheres"),
        ("look", "/result/look"),
        ("side", "/result/side"),
        ("backend", "/result/backend"),
        ("shader cache", "/result/shader_cache"),
    ];
    let times = [
        ("first", "/result/first/frame_ms"),
        ("second", "/result/second_ms"),
        ("steady", "/result/steady/frame_ms"),
        ("host", "/result/steady/host_ms"),
        ("moving", "/result/moving/frame_ms"),
        ("host", "/result/moving/host_ms"),
        ("settled", "/result/last/settled"),
        ("light on device", "/result/last/light_on_device"),
        ("device MiB", "/result/device_mib"),
        ("host MiB", "/result/host_mib"),
    ];
    table(&mut out, "Frames, ms (medians)", &[&frames[..], &times].concat(), of("frames").cloned());
    let stages = [
        ("stages", "/result/last/stages_ms"),
        ("bytes up", "/result/last/bytes_up"),
        ("bytes down", "/result/last/bytes_down"),
        ("warnings", "/result/last/warnings"),
    ];
    table(&mut out, "Stages of the last steady frame, ms", &[&frames[..], &stages].concat(), of("frames").cloned());
    let columns = [
        ("step", "/words"),
        ("frame", "/result/times/frame_ms"),
        ("host", "/result/times/host_ms"),
        ("search", "/result/last/search"),
    ];
    let lines = of("inside").chain(of("film")).cloned();
    let title = "Eye inside the cloud, and spheres that move, ms";
    table(&mut out, title, &[&columns[..], &stages].concat(), lines);
    let columns = [
        ("spheres", "/of/spheres"),
        ("rays", "/of/rays"),
        ("backend", "/backend"),
        ("first", "/b/first_ms"),
        ("hits", "/b/hits_ms"),
        ("any hit", "/b/any_ms"),
        ("on the device", "/b/on_device"),
        ("left to f64", "/b/refined"),
    ];
    let rays = of("rays").map(|line| &line["result"]).flat_map(|of| {
        let backends = of["backends"].as_object().into_iter().flatten();
        backends.map(move |(name, b)| json!({ "of": of, "backend": name, "b": b }))
    });
    table(&mut out, "Given rays, ms", &columns, rays);
    let columns = [
        ("spheres", "/of/spheres"),
        ("side", "/of/side"),
        ("method", "/m/method"),
        ("frame", "/m/times/frame_ms"),
        ("kernel", "/m/times/kernel_ms"),
        ("CPU path", "/m/cpu_ms"),
        ("ids that differ", "/m/ids_differ"),
        ("refused", "/m/refused"),
    ];
    let methods = of("methods")
        .map(|line| &line["result"])
        .flat_map(|of| of["methods"].as_array().into_iter().flatten().map(move |m| json!({ "of": of, "m": m })));
    table(&mut out, "Methods, ms", &columns, methods);
    out += &format!("\n{bad} steps were not good.\n");
    out
}

/// The table of what is right or wrong, and of all steps that failed; their number.
fn checks(out: &mut String, all: &[Value]) -> usize {
    let (mut bad, mut rows) = (0, Vec::new());
    for line in all.iter().filter(|line| line["step"] != "machine") {
        let skipped = line["code"].as_i64().is_some_and(|code| NO_TIME.contains(&code));
        let good = line["good"] == true;
        bad += usize::from(!good && !skipped);
        if !good || CHECKS.iter().any(|step| line["step"] == *step) {
            let word = match (good, skipped) {
                (true, _) => "yes",
                (false, true) => "no time",
                (false, false) => "**no**",
            };
            rows.push(json!({ "line": line, "good": word, "found": found(line) }));
        }
    }
    let columns = [
        ("step", "/line/words"),
        ("good", "/good"),
        ("code", "/line/code"),
        ("s", "/line/seconds"),
        ("found", "/found"),
    ];
    table(out, "Right or wrong", &columns, rows);
    bad
}

/// The result of a step in words: its error, the end of its output, or its main numbers; else empty.
fn found(line: &Value) -> String {
    let r = &line["result"];
    match line["step"].as_str().unwrap_or_default() {
        _ if r["error"].is_string() => cell(&r["error"]),
        _ if r.is_null() => cell(&line["tail"]),
        "adapters" => format!("{} adapters", r["adapters"].as_array().map_or(0, Vec::len)),
        "compare" => {
            let of = |(name, b): (&String, &Value)| match b["differ"].as_u64() {
                Some(0) => format!("{name}: equal"),
                _ => format!("{name}: {} of {} differ, by at most {}", b["differ"], b["values"], small(&b["most"])),
            };
            r["buffers"].as_object().into_iter().flatten().map(of).collect::<Vec<_>>().join("; ")
        }
        "lattice" => format!("{} of {} pixels wrong in {} frames", r["wrong"], r["pixels"], r["frames"]),
        "suite" => {
            let [distance, normal] = ["distance", "normal_degrees"].map(|name| small(&r[name]));
            let [wrong, pixels, runs] = ["wrong", "pixels", "runs"].map(|name| &r[name]);
            format!(
                "{wrong} of {pixels} pixels wrong in {runs} runs; distance within {distance}, normal within {normal} degrees"
            )
        }
        "rays" => format!("{} rays in {} spheres", r["rays"], r["spheres"]),
        _ => String::new(),
    }
}

fn small(value: &Value) -> String {
    value.as_f64().map_or_else(|| "-".into(), |x| format!("{x:.1e}"))
}

/// A value as a cell of a table: times and sizes with three digits, of stages those from a hundredth of a millisecond.
fn cell(value: &Value) -> String {
    let text = match value {
        Value::Null => "-".into(),
        Value::String(text) => text.clone(),
        Value::Number(n) if n.is_f64() => match value.as_f64().unwrap_or(f64::NAN) {
            x if x < 10.0 => format!("{x:.2}"),
            x if x < 100.0 => format!("{x:.1}"),
            x => format!("{x:.0}"),
        },
        Value::Array(all) => all.iter().map(cell).collect::<Vec<_>>().join("; "),
        Value::Object(all) => {
            let some = all.iter().filter(|(_, ms)| ms.as_f64().is_some_and(|ms| ms >= 0.01));
            some.map(|(name, ms)| format!("{name} {}", cell(ms))).collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    };
    text.replace('|', "/").replace('\n', " ")
}

/// A section with a table: names of columns with where their cells lie in a row. Without rows there is none.
fn table(out: &mut String, title: &str, columns: &[(&str, &str)], rows: impl IntoIterator<Item = Value>) {
    let mut rows = rows.into_iter().peekable();
    if rows.peek().is_none() {
        return;
    }
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    *out += &format!("\n## {title}\n\n");
    *out += &line(columns.iter().map(|(name, _)| (*name).to_owned()).collect());
    *out += &format!("|{}\n", "---|".repeat(columns.len()));
    for row in rows {
        *out += &line(columns.iter().map(|(_, at)| row.pointer(at).map_or_else(|| "-".into(), cell)).collect());
    }
}
