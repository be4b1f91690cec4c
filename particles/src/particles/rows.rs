//! Parses rows of particles on all cores. The file is read in blocks of lines; while the next block is read, the parts
//! of the previous one are parsed. At most two blocks are in memory, and the error is for the first invalid line.

use super::frame::Particles;
use super::layout::Layout;
use crate::input::Input;
use crate::lines::{Block, Lines};
use halfline_ground::error::{Error, Result};
use halfline_ground::parallel;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

/// Reads at most `most` lines into `particles`, which `layout` began; returns their number. `row` parses the current
/// line.
///
/// # Errors
/// As [`Particles::grow`], and errors of `row` and of reading.
pub(crate) fn rows(
    lines: &mut Lines<Input>,
    most: u64,
    layout: &Layout,
    particles: &mut Particles,
    row: impl Fn(&Lines<&[u8]>, &mut Particles) -> Result<()> + Sync,
) -> Result<u64> {
    let found = |part: &mut Lines<&[u8]>| -> Result<Particles> {
        let mut particles = layout.begin_part();
        while part.advance()? {
            row(part, &mut particles)?;
        }
        Ok(particles)
    };
    let (mut block, mut next) = (Block::default(), Block::default());
    lines.block(most, &mut block)?;
    let mut taken = block.len();
    while !block.is_empty() {
        let (mut some, mut parts) = (false, block.parts());
        let mut append = |part: Particles| {
            some |= !part.positions.is_empty() || !part.reading.left_out.is_empty();
            particles.append(part)
        };
        let read = if parts.len() == 1 {
            // A small frame does not pay for waking other threads.
            append(found(&mut parts[0])?)?;
            lines.block(most - taken, &mut next)
        } else {
            let all = || parallel::blocks(&mut parts[..], 1, &|_, part| found(&mut part[0]));
            let (read, all) = parallel::join(|| lines.block(most - taken, &mut next), all);
            all.into_iter().try_for_each(|part| append(part?))?;
            read
        };
        if some {
            lines.found();
        }
        lines.rest(if some { 0 } else { block.len() })?;
        read?;
        taken += next.len();
        std::mem::swap(&mut block, &mut next);
    }
    Ok(taken)
}

/// Reads `count` lines that are not blank into `particles`, which `layout` began; returns their number, which is lower where the
/// file ends before. `row` parses the current line.
///
/// # Errors
/// As [`rows`].
pub(crate) fn filled_rows(
    lines: &mut Lines<Input>,
    count: u64,
    layout: &Layout,
    particles: &mut Particles,
    row: impl Fn(&Lines<&[u8]>, &mut Particles) -> Result<()> + Sync,
) -> Result<u64> {
    let read = AtomicU64::new(0);
    loop {
        let left = count - read.load(Relaxed);
        let taken = rows(lines, left, layout, particles, |line, particles| {
            if line.text().trim_ascii().is_empty() {
                return Ok(());
            }
            read.fetch_add(1, Relaxed);
            row(line, particles)
        })?;
        if taken == 0 {
            return Ok(read.into_inner());
        }
    }
}

/// Checks that only blank lines follow the `announced` rows.
///
/// # Errors
/// As [`surplus`].
pub(crate) fn blank_rest(lines: &mut Lines<Input>, announced: u64, what: &str) -> Result<()> {
    let is_row = |lines: &Lines<Input>| !lines.text().trim_ascii().is_empty();
    while lines.advance()? {
        if is_row(lines) {
            return surplus(lines, announced, what, is_row);
        }
    }
    Ok(())
}

/// The most surplus rows that are counted; a file may have any number.
const COUNTED: u64 = 1 << 20;

/// The error for rows beyond the number that a file declares: a count that is too low would silently drop particles.
/// The current line is the first of them; `is_row` recognises the following ones.
///
/// # Errors
/// This error, with both numbers, and errors of reading.
pub(crate) fn surplus<T>(
    lines: &mut Lines<Input>,
    announced: u64,
    what: &str,
    is_row: impl Fn(&Lines<Input>) -> bool,
) -> Result<T> {
    let (place, mut more) = (lines.place(0).named("count"), 1);
    while more < COUNTED && lines.advance()? && is_row(lines) {
        more += 1;
        lines.found();
    }
    let all = announced.saturating_add(more);
    let all = if more < COUNTED { all.to_string() } else { format!("at least {all}") };
    let problem = format!("expected {announced} {what}, found {all}");
    Err(Error::scene(place, problem, "correct the count"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::table::Table;
    use crate::formats::xyz::Xyz;
    use crate::particles::frame::ParticleFrames;
    use crate::particles::frame::all;
    use crate::particles::request::Request;
    use crate::source::Source;

    /// Several blocks of 2 MiB.
    const COUNT: usize = 200_000;

    /// Two frames, the second small; line `n` of `changed` is replaced.
    fn xyz(changed: &[(usize, &str)]) -> String {
        let mut atoms: Vec<String> = (0..COUNT).map(|n| format!("X{} {n}.125 -{n} 1e-3", n % 3)).collect();
        changed.iter().for_each(|(n, line)| atoms[*n] = (*line).to_owned());
        format!("{COUNT}\nmany\n{}\n1\nfew\nFe 1 2 3\n", atoms.join("\n"))
    }

    #[test]
    fn blocks_are_put_together_in_the_order_of_the_file() {
        let frames =
            all(Xyz::new(Source::of_text(&xyz(&[(7, "Fe 1 2 3 more")])), Request::of(&["z"]))).expect("two frames");
        let [many, few] = &frames[..] else { panic!("{} frames", frames.len()) };
        assert_eq!(
            (many.positions.len(), many.columns[0].values.len(), few.positions[0]),
            (COUNT, COUNT, [1.0, 2.0, 3.0])
        );
        assert_eq!(many.elements.iter().position(|number| *number == 26), Some(7));
        let at = |n: usize| if n == 7 { [1.0, 2.0, 3.0] } else { [n as f64 + 0.125, -(n as f64), 1e-3] };
        assert!(many.positions.iter().enumerate().all(|(n, position)| *position == at(n)));
        // 7 is 1 of 3.
        let known = [("X0", 66_667), ("X1", 66_666), ("X2", 66_666)].map(|(name, n)| (name.to_owned(), n));
        assert_eq!(many.unknown, known.into());
    }

    #[test]
    fn the_first_bad_line_is_reported() {
        for (changed, place) in [
            (&[(150_000, "H 1 2"), (149_999, "H 0 b 0"), (199_999, "")][..], "text:150002:5: y: `b`"),
            (&[(199_999, "H 1 2 \u{e9}")], "text:200002:7: z"),
        ] {
            let error =
                all(Xyz::new(Source::of_text(&xyz(changed)), Request::of(&[]))).map(drop).expect_err(place).to_string();
            assert!(error.contains(place), "{error}");
        }
        let cut = xyz(&[]).lines().take(COUNT).collect::<Vec<_>>().join("\n") + "  ";
        let error = all(Xyz::new(Source::of_text(&cut), Request::of(&[]))).map(drop).expect_err("an end").to_string();
        assert!(error.contains("text:200000:29: atom: the file ends"), "{error}");
    }

    #[test]
    fn rows_that_are_left_out_are_counted_over_all_blocks() {
        let text = xyz(&[(7, "H 1 nan 2"), (150_000, "H one 1 2"), (199_999, "H 1 2 -inf")]);
        let options = Request { skip_invalid: true, ..Request::default() };
        let mut frames = Xyz::new(Source::of_text(&text), options.clone());
        let many = frames.next().expect("valid rows").expect("a frame");
        assert_eq!((many.positions.len(), many.elements.len()), (COUNT - 3, COUNT - 3));
        // The rows before the first, between it and the second, and behind.
        assert_eq!([6, 7, 149_998, 149_999].map(|n| many.positions[n][0]), [6.125, 8.125, 149_999.125, 150_001.125]);
        assert_eq!(many.skipped.assumed, ["3 rows left out, the first in line 10: y: `nan` is not finite"]);
        assert_eq!(frames.next().expect("the second").expect("a frame").positions, [[1.0, 2.0, 3.0]]);
    }

    #[test]
    fn tables_keep_their_comments_and_blank_lines() {
        let read = |text: &str| Table::open(Source::of_text(text), &Request::default())?.all();
        let rows: String = (0..COUNT).map(|n| format!("{n},2,3\n{}", ["", "\n", "# no row\n"][n % 3])).collect();
        let table = read(&format!("x,y,z\n{rows}")).expect("a table");
        assert!(table.positions.len() == COUNT && table.positions.iter().enumerate().all(|(n, p)| p[0] == n as f64));
        let error = read(&format!("x,y,z\n{rows}1,2,3,4\n")).map(drop).expect_err("a row");
        // The header, the rows, and two lines for every three rows.
        let line = 1 + COUNT + COUNT / 3 * 2 + 1 + 1;
        assert!(error.to_string().contains(&format!("text:{line}:7: row")), "{error}");
    }

    /// A line that a reader looked at and gave back is the first of the block.
    #[test]
    fn a_line_that_was_given_back_is_a_row() {
        let Source { reader, path, .. } = Source::of_text("one\ntwo\nthree\nfour\n");
        let mut lines = Lines::new(reader, &path);
        assert!(lines.advance().expect("one") && lines.advance().expect("two"));
        lines.give_back();
        let (layout, found) = (Layout::default(), std::sync::Mutex::new(Vec::new()));
        let row = |line: &Lines<&[u8]>, _: &mut Particles| {
            found.lock().expect("one thread").push((line.place(0).line, line.text().to_owned()));
            Ok(())
        };
        let mut particles = layout.begin();
        assert_eq!(rows(&mut lines, 2, &layout, &mut particles, row).expect("two rows"), 2);
        let expected = [(Some(2), "two".to_owned()), (Some(3), "three".to_owned())];
        assert_eq!(found.into_inner().expect("one thread"), expected);
        assert!(lines.advance().expect("four") && lines.text() == "four" && lines.place(0).line == Some(4));
    }
}
