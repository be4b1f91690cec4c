use crate::formats::dump::Dump;
use crate::formats::table::Table;
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::request::Request;
use crate::particles::survey::Survey;
use crate::source::Source;
use halfline_ground::error::Result;

/// Numbers that differ from seed to seed.
struct Draw(u64);

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }

    fn pick<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len())]
    }
}

const NUMBERS: [&str; 8] = ["1", "1.50", "007", "-2e3", "nan", "inf", "0.1", "+4"];
const WORDS: [&str; 6] = ["NA", "n/a", "null", "-", "?", "None"];
const TEXTS: [&str; 5] = ["zz", "1abc", "2024-01-02", "a b", "\u{e9}"];

/// A column of so many rows, whose texts are drawn from `of` besides `late`, and whether it is one of texts.
fn column(
    draw: &mut Draw,
    rows: usize,
    of: &[&[&'static str]],
    late: Option<&'static str>,
) -> (Vec<&'static str>, bool) {
    let mut values: Vec<&str> = (0..rows)
        .map(|_| {
            let kind = of[draw.below(of.len())];
            kind[draw.below(kind.len())]
        })
        .collect();
    if let Some(text) = late {
        let at = [0, 1, rows / 2, rows - 1][draw.below(4)];
        values[at] = text;
    }
    let is_number = |text: &&str| text.parse::<f64>().is_ok();
    let is_text = values.iter().any(|text| TEXTS.contains(text))
        || values.iter().any(|text| WORDS.contains(text)) && !values.iter().any(is_number);
    (values, is_text)
}

fn columns(draw: &mut Draw, rows: usize) -> Vec<(Vec<&'static str>, bool)> {
    let blank = &[""][..];
    let late = draw.pick(&TEXTS);
    vec![
        column(draw, rows, &[&NUMBERS], None),
        column(draw, rows, &[&NUMBERS, blank, &WORDS], None),
        column(draw, rows, &[blank], None),
        column(draw, rows, &[&WORDS, blank], None),
        column(draw, rows, &[blank], Some(late)),
        column(draw, rows, &[&NUMBERS], Some(late)),
        column(draw, rows, &[&NUMBERS, &WORDS, blank], Some(late)),
        column(draw, rows, &[&TEXTS, &NUMBERS], None),
    ]
}

/// The column of the particles has these texts, or else their numbers.
fn check(found: &Particles, name: &str, (texts, is_text): &(Vec<&'static str>, bool), message: &str) {
    let column = found.columns.iter().find(|column| column.name == name).expect(name);
    let labels = found.labels.get(name);
    assert_eq!(labels.is_some(), *is_text, "{message} {name}");
    for (n, (text, value)) in texts.iter().zip(&column.values).enumerate() {
        let is_same = match labels {
            Some(labels) => labels[*value as usize] == *text,
            None => value.to_bits() == text.parse().unwrap_or(f64::NAN).to_bits(),
        };
        assert!(is_same, "{message} {name} row {n}: {text} is {value}");
    }
}

fn table(columns: &[(Vec<&str>, bool)], delimiter: &str, filler: usize) -> String {
    let names: Vec<String> = (0..columns.len()).map(|k| format!("c{k}")).collect();
    let mut text = format!("x{delimiter}y{delimiter}z{delimiter}{}{delimiter}f\n", names.join(delimiter));
    for row in 0..columns[0].0.len() {
        let values: Vec<&str> = columns.iter().map(|(values, _)| values[row]).collect();
        let filler = "-".repeat(filler);
        text += &format!("{row}{delimiter}0{delimiter}0{delimiter}{}{delimiter}k{filler}\n", values.join(delimiter));
    }
    text
}

/// In files of one part of a block and of many, by every delimiter.
#[test]
fn a_text_in_any_row_makes_a_column_of_texts() {
    for seed in 0..60 {
        let mut draw = Draw(seed);
        let (rows, filler) = if seed % 30 == 0 { (1500, 200) } else { (1 + draw.below(12), 0) };
        let columns = columns(&mut draw, rows);
        let delimiter = draw.pick(&[",", ";", "\t", "|"]);
        let text = table(&columns, delimiter, filler);
        let message = format!("seed {seed}");
        let read = || -> Result<Particles> { Table::open(Source::of_text(&text), &Request::of(&["*"]))?.all() };
        let found = read().unwrap_or_else(|error| panic!("{message}: {error}"));
        columns.iter().enumerate().for_each(|(k, column)| check(&found, &format!("c{k}"), column, &message));

        // What is counted in parts is of the same type.
        let survey = Survey::with_part(1 + draw.below(5));
        let request = Request { survey: Some(survey.clone()), ..Request::of(&["*"]) };
        let rest = Table::open(Source::of_text(&text), &request).and_then(Table::all).expect("a table");
        let counts = rest.counted(&survey);
        for (k, (texts, is_text)) in columns.iter().enumerate() {
            let counted = &counts.columns[&format!("c{k}")];
            assert_eq!(counted.is_text(), *is_text, "{message} c{k}");
            // A text in the first row makes a column of names at once.
            if TEXTS.contains(&texts[0]) {
                continue;
            }
            let missing = texts.iter().filter(|text| !text.parse::<f64>().is_ok_and(|x| !x.is_nan())).count() as u64;
            let words = texts.iter().filter(|text| WORDS.contains(text)).count() as u64;
            let named: u64 = counted.texts.values().sum();
            let all = texts.iter().filter(|text| !text.is_empty() && text.parse::<f64>().is_err()).count() as u64;
            assert!(named == all && words <= named && counted.missing == missing, "{message} c{k}");
        }

        // A dump has no blank fields.
        let dumped: Vec<_> = columns
            .iter()
            .filter(|(texts, _)| !texts.iter().any(|text| text.is_empty() || text.contains(' ')))
            .collect();
        let names: String = (0..dumped.len()).map(|k| format!(" c{k}")).collect();
        let mut text = format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{rows}\nITEM: BOX BOUNDS\n0 1\n0 1\n0 1\nITEM: ATOMS x y z{names}\n"
        );
        for row in 0..rows {
            let values: String = dumped.iter().map(|(texts, _)| format!(" {}", texts[row])).collect();
            text += &format!("{row} 0 0{values}\n");
        }
        let found = Dump::new(Source::of_text(&text), Request::of(&["*"])).next().expect(&text).expect("a frame");
        dumped.iter().enumerate().for_each(|(k, column)| check(&found, &format!("c{k}"), column, &message));
    }
}

/// RFC 4180: fields in quotes with delimiters, line breaks and doubled quotes, in rows and in names.
#[test]
fn quoted_fields_are_those_of_rfc_4180() {
    let pieces = ["a", "\"", "\"\"", ",", ";", "|", "\t", "\n", " b ", "\u{e9}", "5", "'", "x"];
    for seed in 0..200 {
        let mut draw = Draw(seed);
        let delimiter = draw.pick(&[",", ";", "\t", "|"]);
        let field = |draw: &mut Draw, has_quotes: bool| -> String {
            let text: String = (0..draw.below(6)).map(|_| draw.pick(&pieces)).collect();
            // Blanks around a text are not kept, and only quotes hold other marks.
            let text = text.trim().to_owned();
            if has_quotes { text } else { text.replace(|c: char| "\",;|\t\n".contains(c), "_") }
        };
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let rows = 1 + draw.below(if seed % 100 == 0 { 3000 } else { 5 });
        let name = format!("n{}", field(&mut draw, true).to_lowercase());
        let ends = draw.pick(&["\n", "\r\n"]);
        let mut text = [&quoted("x"), "y", "z", &quoted(&name), "last"].join(delimiter) + ends;
        let mut texts = Vec::new();
        for row in 0..rows {
            let has_quotes = draw.below(3) > 0;
            let own = format!("t{}", field(&mut draw, has_quotes));
            let shown = if has_quotes { quoted(&own) } else { own.clone() };
            text += &(["1", "2", &row.to_string(), &shown, "k"].join(delimiter) + ends);
            texts.push(own);
        }
        let read = || -> Result<Particles> { Table::open(Source::of_text(&text), &Request::of(&["*"]))?.all() };
        let found = read().unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        let labels = &found.labels.get(&name).unwrap_or_else(|| panic!("seed {seed}: {name:?} in {:?}", found.has));
        let column = found.columns.iter().find(|column| column.name == name).expect("a column");
        let found_texts: Vec<&String> = column.values.iter().map(|value| &labels[*value as usize]).collect();
        assert!(found_texts.into_iter().eq(&texts), "seed {seed}:\n{text}");
        assert!(found.positions.iter().enumerate().all(|(row, at)| *at == [1.0, 2.0, row as f64]), "seed {seed}");
    }
}
