//! The table "Constants" of docs/certificate.md has each constant of the proof, its value, and the section that derives it.

use crate::text;

/// The constants that kernel and twin share: each of them has a row.
const SHARED: &str = "src/certify/constants.rs";

/// A row of the table.
struct Row {
    name: String,
    value: String,
    section: String,
    anchor: String,
    file: String,
}

impl Row {
    fn of(line: &str) -> Option<Self> {
        let cells: Vec<String> = line.replace("\\|", "/").split('|').map(|cell| cell.trim().to_owned()).collect();
        let [_, name, value, _, link, file, _] = &cells[..] else { return None };
        let (section, anchor) = link.strip_prefix('[')?.strip_suffix(')')?.split_once("](#")?;
        let [name, section, file] = [(name, '`'), (&section.to_owned(), '"'), (file, '`')]
            .map(|(cell, quote)| cell.trim_matches(quote).to_owned());
        Some(Self { name, value: value.clone(), section, anchor: anchor.to_owned(), file })
    }
}

/// A constant as its file declares it.
struct Constant<'a> {
    name: &'a str,
    is_f64: bool,
    value: &'a str,
    comment: String,
}

/// The constants of a file, each on a line below its comment.
fn constants(text: &str) -> Vec<Constant<'_>> {
    let (mut found, mut comment) = (Vec::new(), String::new());
    for line in text.lines().map(str::trim) {
        if let Some(more) = line.strip_prefix("//") {
            comment = format!("{comment} {}", more.trim_start_matches('/').trim());
            continue;
        }
        let declared = line.split_once("const ").filter(|(before, _)| before.is_empty() || before.starts_with("pub"));
        if let Some((head, value)) = declared.and_then(|(_, declared)| declared.split_once(" = ")) {
            let (name, number) = head.split_once(": ").unwrap_or((head, ""));
            let value = value.split(';').next().unwrap_or_default();
            if !number.starts_with('&') {
                found.push(Constant { name, is_f64: number.contains("f64"), value, comment: comment.clone() });
            }
        }
        if !line.starts_with("#[") {
            comment.clear();
        }
    }
    found
}

/// The sections that a comment names.
fn sections_of(comment: &str) -> Vec<String> {
    let name = |rest: &str| match rest.strip_prefix('"') {
        Some(title) => title.split('"').next().unwrap_or_default().to_owned(),
        None => rest.chars().take_while(|c| c.is_alphanumeric()).collect(),
    };
    comment.replace(" Section ", " section ").split(" section ").skip(1).map(name).collect()
}

/// The parts of an expression around the last of some operators outside of parentheses.
fn split<'a>(text: &'a str, operators: &[&str]) -> Option<(&'a str, &'a str, &'a str)> {
    let is_outside = |at: usize| text[..at].matches('(').count() == text[..at].matches(')').count();
    let last =
        |operator: &&str| Some((text.rmatch_indices(*operator).find(|(at, _)| is_outside(*at))?.0, operator.len()));
    let (at, len) = operators.iter().filter_map(last).max()?;
    Some((&text[..at], &text[at..at + len], &text[at + len..]))
}

/// The value of an expression of Rust, WGSL or the table: of numbers, powers of two, and names of the table.
fn number(text: &str, rows: &[Row]) -> Option<f64> {
    let power = |base: f64, exponent: f64| base.powi(exponent as i32);
    for operators in [&[" + "][..], &[" * ", " / "], &[" << "], &[" as "]] {
        if let Some((left, operator, right)) = split(text, operators) {
            let left = number(left, rows)?;
            return match operator {
                " + " => Some(left + number(right, rows)?),
                " * " => Some(left * number(right, rows)?),
                " / " => Some(left / number(right, rows)?),
                " << " => Some(left * power(2.0, number(right, rows)?)),
                _ => Some(left),
            };
        }
    }
    // 1u64 is 1.
    let literal = text.replace('_', "");
    if let Some(literal) = literal.split('u').next().and_then(|literal| literal.parse().ok()) {
        return Some(literal);
    }
    if let Some(positive) = text.strip_prefix('-') {
        return Some(-number(positive, rows)?);
    }
    if let Some((base, exponent)) = text.split_once('^') {
        return Some(power(number(base, rows)?, number(exponent, rows)?));
    }
    if let Some((function, rest)) = text.split_once('(') {
        let inner = number(rest.strip_suffix(')')?, rows)?;
        return match function {
            "" => Some(inner),
            "power_of_two" => Some(power(2.0, inner)),
            _ => None,
        };
    }
    match text {
        "f64::EPSILON" => Some(f64::EPSILON),
        name => rows.iter().find(|row| row.name == name).and_then(|row| number(&row.value, rows)),
    }
}

/// The numbers of an array, or of one expression.
fn numbers(text: &str, rows: &[Row]) -> Option<Vec<f64>> {
    text.trim_matches(['[', ']']).split(", ").map(|one| number(one, rows)).collect()
}

/// The anchor of a heading.
fn anchor(title: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || "-_".contains(*c);
    title.to_lowercase().replace(' ', "-").chars().filter(kept).collect()
}

/// The errors of the table on a page, by the files that it names.
fn faults(page: &str, read: &dyn Fn(&str) -> Option<String>) -> Vec<String> {
    let sections: Vec<(&str, &str)> = page.split("\n## ").skip(1).filter_map(|part| part.split_once('\n')).collect();
    let table = sections.iter().find(|(title, _)| *title == "Constants").map_or("", |(_, table)| *table);
    let lines: Vec<&str> = table.lines().filter(|line| line.starts_with("| `")).collect();
    let rows: Vec<Row> = lines.iter().filter_map(|line| Row::of(line)).collect();
    let mut faults = Vec::new();
    if rows.len() < lines.len() {
        faults.push("a row is not five cells with a link to a section".to_owned());
    }
    for row in &rows {
        let Row { name, value, section, file, .. } = row;
        let mut add = |fault: String| faults.push(format!("{name} of {file}: {fault}"));
        let text = read(file).unwrap_or_default();
        let Some(constant) = constants(&text).into_iter().find(|constant| constant.name == name) else {
            add("no such constant".to_owned());
            continue;
        };
        let bits = |x: &f64| if constant.is_f64 { x.to_bits() } else { u64::from((*x as f32).to_bits()) };
        let [claimed, declared] = [value.as_str(), constant.value]
            .map(|text| numbers(text, &rows).map(|all| all.iter().map(bits).collect::<Vec<_>>()));
        if claimed.is_none() || claimed != declared {
            add(format!("{value}, not {}", constant.value));
        }
        let in_comment = sections_of(&constant.comment);
        if file.ends_with(".rs") && in_comment != [section.as_str()] {
            add(format!("its comment names the sections {in_comment:?}, the table {section}"));
        }
        match sections.iter().find(|(title, _)| anchor(title) == row.anchor) {
            Some((title, _)) if title.split(". ").next() != Some(section.as_str()) => {
                add(format!("{title} is not {section}"))
            }
            Some((title, body)) if !body.contains(&format!("`{name}`")) => add(format!("{title} does not name it")),
            Some(_) => {}
            None => add(format!("no section #{}", row.anchor)),
        }
        if rows.iter().filter(|other| other.name == *name && other.file == *file).count() > 1 {
            add("two rows".to_owned());
        }
    }
    let has_row = |constant: &Constant<'_>| rows.iter().any(|row| row.name == constant.name && row.file == SHARED);
    let shared = read(SHARED).unwrap_or_default();
    let missing = constants(&shared).into_iter().filter(|constant| !has_row(constant));
    faults.extend(missing.map(|constant| format!("{} of {SHARED}: no row", constant.name)));
    faults
}

fn page() -> String {
    text("docs/certificate.md").expect("docs/certificate.md")
}

#[test]
fn every_constant_of_the_proof_names_the_section_that_derives_it() {
    let shared = text(SHARED).expect(SHARED);
    assert!(constants(&shared).len() > 40, "{} constants", constants(&shared).len());
    let faults = faults(&page(), &text);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_wrong_row_of_a_constant_is_found() {
    let (page, shared) = (page(), text(SHARED).expect(SHARED));
    let row = page.lines().find(|line| line.starts_with("| `RHO2` ")).expect("the row of RHO2");
    let with_row = |other: &str| faults(&page.replace(row, other), &text).len();
    assert_eq!(with_row(row), 0);
    assert_eq!(with_row(""), 1);
    assert_eq!(with_row(&format!("{row}\n{row}")), 2);
    assert_eq!(with_row(&row.replace("`RHO2`", "`RHO3`")), 2);
    assert_eq!(with_row(&row.replace("| 9 |", "| 10 |")), 1);
    assert_eq!(with_row(&row.replace("[2](", "[3](")), 2);
    assert_eq!(with_row(&row.replace("#2-", "#3-")), 1);
    assert_eq!(with_row(&row.replace("](#", "#")), 2);
    assert_eq!(faults(&page.replace("(`RHO2`, ", "("), &text).len(), 1);
    let with_code = |old: &str, new: &str| {
        let changed = shared.replace(old, new);
        faults(&page, &|file: &str| if file == SHARED { Some(changed.clone()) } else { text(file) }).len()
    };
    assert_eq!(with_code("RHO2 = 9.0", "RHO2 = 9.5"), 1);
    assert_eq!(with_code("discriminant. Section 2.", "discriminant. Section 3."), 2);
    assert_eq!(with_code("const RHO2 =", "const RHO_2 ="), 2);
}
