//! The report of a measurement: a single HTML page without scripts, external files or network access.

mod html;
mod tables;

use super::plot::{Plot, plots};
use super::record::{PlaceRecord, Record};
use super::verdict::{broken, summary};
use halfline::error::Result;
use halfline_files::write::file;
use html::{BADGE, escaped};
use std::path::{Path, PathBuf};

/// Writes every plot that the record has data for, as SVG and PNG, and `report.html`, into an existing folder. Files
/// are written atomically. Returns their paths, the report last.
///
/// # Errors
/// [`halfline::Error::Io`] naming the file.
pub fn write(record: &Record, dir: &Path) -> Result<Vec<PathBuf>> {
    let plots = plots(record)?;
    let mut paths = Vec::new();
    for plot in &plots {
        paths.extend(plot.write(dir)?);
    }
    let path = dir.join("report.html");
    let page = page(record, &plots);
    file::write_atomically(&path, |out| out.write_all(page.as_bytes()))?;
    paths.push(path);
    Ok(paths)
}

/// The page with these plots.
#[must_use]
pub fn page(record: &Record, plots: &[Plot]) -> String {
    let subject = escaped(&record.subject);
    let badge = if record.runs.iter().any(|run| !broken(run).is_empty()) { BADGE } else { "" };
    let list = |class: &str, items: &[String]| match items {
        [] => String::new(),
        items => {
            let items: String = items.iter().map(|item| format!("<li>{}</li>\n", escaped(item))).collect();
            format!("<ul class=\"{class}\">\n{items}</ul>\n")
        }
    };
    let sections = [
        list("summary", &summary(record)),
        list("warnings", &record.warnings),
        section("Plots", &plots.iter().map(figure).collect::<String>()),
        section("Devices", &places(&record.places)),
        section("All scenes together", &tables::totals(record)),
        section("Results", &tables::results(record)),
        section("Command", &format!("<pre><code>{}</code></pre>\n", escaped(&record.command))),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>halfline measure: {subject}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <h1>Speed and error: {subject} {badge}</h1>\n{}\
         <footer>halfline {}, record {} version {}; plots and tables are drawn from the record alone, and \
         lie beside this page as .svg and .png.</footer>\n</main>\n</body>\n</html>\n",
        sections.concat(),
        escaped(&record.halfline),
        escaped(&record.schema),
        record.version,
    )
}

const STYLE: &str = include_str!("report/style.css");

/// A heading and its content; empty without content.
fn section(title: &str, body: &str) -> String {
    if body.is_empty() { String::new() } else { format!("<section>\n<h2>{title}</h2>\n{body}</section>\n") }
}

fn figure(plot: &Plot) -> String {
    // Inline SVG needs no namespace.
    let svg = plot.svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", " role=\"img\"", 1);
    format!(
        "<figure id=\"{}\">\n<div class=\"sheet\">{svg}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
        plot.name,
        escaped(plot.caption)
    )
}

fn places(places: &[PlaceRecord]) -> String {
    let rows = places.iter().map(|place| {
        let clock = if place.timestamps { "wall, and the device's own" } else { "wall" };
        let tested: String = place.self_test.iter().map(|line| format!("{}<br>", escaped(line))).collect();
        [escaped(&place.backend), escaped(&place.adapter), escaped(&place.driver), clock.into(), tested].to_vec()
    });
    tables::table(&["backend", "adapter", "driver", "clock", "self-test"], rows.collect())
}

#[cfg(test)]
mod tests;
