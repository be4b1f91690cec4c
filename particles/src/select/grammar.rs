//! The grammar of selections.
//!
//! ```text
//! chain  = factor { ("and" | "or") factor }                        from left to right
//! factor = "not" factor | "(" chain ")" | test
//! test   = "all" | "none" | KIND
//!        | ("within" | "exwithin") R "of" factor | "around" R chain
//!        | "same" COLUMN "as" chain | "byres" chain
//!        | ["prop"] ["abs"] COLUMN SIGN VALUE | NUMBER SIGN COLUMN
//!        | COLUMN VALUE { VALUE }
//! ```

use super::expression::{Comparison, Kind, Near, Node, Operation, Sign, Value};
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::quote;
use winnow::ascii::multispace0;
use winnow::combinator::{alt, delimited, not, opt, preceded, repeat, terminated};
use winnow::error::{ContextError, ErrMode, StrContext, StrContextValue};
use winnow::prelude::*;
use winnow::stream::Stateful;
use winnow::token::{one_of, take_till};

/// The most bytes of an expression, and the most parts within each other: `not`, parentheses, `byres`, `within`.
const LONGEST: usize = 1 << 16;
const DEEPEST: usize = 128;

/// The most asterisks: the match of a pattern takes the stack for each of its own.
const MOST_STARS: usize = 1 << 10;

/// The text that is left, and the number of parts that the current one is within.
type Input<'a> = Stateful<&'a str, usize>;

/// Words that are not values.
const RESERVED: [&str; 11] = ["and", "or", "not", "within", "exwithin", "around", "of", "same", "as", "byres", "prop"];

/// Parses a whole expression.
///
/// # Errors
/// [`Error::Settings`] with the column of the first character that does not fit.
pub(super) fn parse(text: &str) -> Result<Node> {
    let mend =
        "write an expression such as `chain A and not water`, `type 2`, `bfactor < 30` or `within 5 of (resname HEM)`";
    let fail = |problem: String| Err(Error::settings(format!("{} is not a selection: {problem}", quote(text)), mend));
    if text.len() > LONGEST {
        return fail(format!("it has more than {LONGEST} bytes"));
    }
    if text.matches('*').count() > MOST_STARS {
        return fail(format!("it has more than {MOST_STARS} asterisks"));
    }
    match terminated(chain, multispace0).parse(Input { input: text, state: 0 }) {
        Ok(node) => Ok(node),
        Err(error) => {
            let column = text[..error.offset()].chars().count() + 1;
            let expected = error.inner().context().find_map(|context| match context {
                StrContext::Expected(StrContextValue::Description(what)) => Some(*what),
                _ => None,
            });
            let expected = expected.unwrap_or("`and`, `or` or the end");
            fail(format!("expected {expected} at column {column}"))
        }
    }
}

/// An error that names what was expected here.
fn expected<T>(what: &'static str) -> ModalResult<T> {
    let mut error = ContextError::new();
    error.push(StrContext::Expected(StrContextValue::Description(what)));
    Err(ErrMode::Cut(error))
}

fn chain(input: &mut Input<'_>) -> ModalResult<Node> {
    let first = factor(input)?;
    let operation = alt((
        alt((keyword("and"), symbol("&&"))).value(Operation::And),
        alt((keyword("or"), symbol("||"))).value(Operation::Or),
    ));
    let rest: Vec<(Operation, Node)> = repeat(0.., (operation, factor)).parse_next(input)?;
    Ok(if rest.is_empty() { first } else { Node::Chain(Box::new(first), rest) })
}

/// A part. All recursion of the grammar passes here, so this bounds the depth of the stack and of the tree.
fn factor(input: &mut Input<'_>) -> ModalResult<Node> {
    if input.state == DEEPEST {
        return expected("at most 128 parts within each other");
    }
    input.state += 1;
    let node = part(input);
    input.state -= 1;
    node
}

fn part(input: &mut Input<'_>) -> ModalResult<Node> {
    if opt(keyword("not")).parse_next(input)?.is_some() {
        return Ok(Node::Not(Box::new(factor(input)?)));
    }
    if opt(symbol("(")).parse_next(input)?.is_some() {
        let inner = chain(input)?;
        if opt(symbol(")")).parse_next(input)?.is_none() {
            return expected("`)`, `and` or `or`");
        }
        return Ok(Node::Group(Box::new(inner)));
    }
    test(input)
}

/// A test of particles, without operators.
fn test(input: &mut Input<'_>) -> ModalResult<Node> {
    multispace0.parse_next(input)?;
    for (word, itself) in [("within", true), ("exwithin", false)] {
        if opt(keyword(word)).parse_next(input)?.is_some() {
            let reach = reach(input)?;
            if opt(keyword("of")).parse_next(input)?.is_none() {
                return expected("`of`");
            }
            return Ok(Node::Near(Near { reach, of: Box::new(factor(input)?), itself }));
        }
    }
    if opt(keyword("around")).parse_next(input)?.is_some() {
        let reach = reach(input)?;
        return Ok(Node::Near(Near { reach, of: Box::new(chain(input)?), itself: false }));
    }
    if opt(keyword("byres")).parse_next(input)?.is_some() {
        return Ok(Node::Same("residue".into(), Box::new(chain(input)?)));
    }
    if opt(keyword("same")).parse_next(input)?.is_some() {
        let Some(column) = opt(word).parse_next(input)? else { return expected("a column") };
        if opt(keyword("as")).parse_next(input)?.is_none() {
            return expected("`as`");
        }
        return Ok(Node::Same(column, Box::new(chain(input)?)));
    }
    let property = opt(keyword("prop")).parse_next(input)?.is_some();
    let absolute = opt(keyword("abs")).parse_next(input)?.is_some();
    let start = *input;
    // A name between quotes is a column, whatever it says.
    let column = opt(quoted).parse_next(input)?;
    let is_column = column.is_some();
    let Some(name) = column.map_or_else(|| opt(word).parse_next(input), |name| Ok(Some(name)))? else {
        return expected("a column or a word such as `protein`");
    };
    if let Some(sign) = opt(sign).parse_next(input)? {
        let Some(value) = opt(alt((quoted, word))).parse_next(input)? else { return expected("a number or a name") };
        let flipped = name.parse::<f64>().is_ok() && value.parse::<f64>().is_err();
        let (column, value, sign) = if flipped { (value, name, sign.flipped()) } else { (name, value, sign) };
        return Ok(Node::Compare(Comparison { column, absolute, sign, value }));
    }
    if property || absolute {
        return expected("a comparison such as `x < 5`");
    }
    if let Some(node) = single(&name).filter(|_| !is_column) {
        return Ok(node);
    }
    let values: Vec<Value> = repeat(0.., value).parse_next(input)?;
    if values.is_empty() {
        // The word itself is at fault if nothing follows it.
        if input.trim_start().is_empty() || input.trim_start().starts_with(')') {
            *input = start;
            return expected("a word such as `protein`, or a column with its values or a comparison");
        }
        return expected("values or a comparison such as `< 5`");
    }
    Ok(Node::Values(name, values))
}

/// A word that is a test of its own.
fn single(word: &str) -> Option<Node> {
    match word {
        "all" => Some(Node::All),
        "none" => Some(Node::None),
        word => Kind::WORDS.iter().find(|(known, _)| *known == word).map(|(_, kind)| Node::Kind(*kind)),
    }
}

fn reach(input: &mut Input<'_>) -> ModalResult<f64> {
    let start = *input;
    let number = opt(word).parse_next(input)?.and_then(|text| text.parse().ok());
    match number.filter(|reach: &f64| *reach >= 0.0 && reach.is_finite()) {
        Some(reach) => Ok(reach),
        None => {
            *input = start;
            expected("a distance of 0 or more")
        }
    }
}

/// A value in a list, or a range whose ends are separate words.
fn value(input: &mut Input<'_>) -> ModalResult<Value> {
    let first = alt((quoted, plain)).parse_next(input)?;
    match opt(range_end).parse_next(input)? {
        Some(last) if first.parse::<f64>().is_ok() => Ok(Value::Range(first, last)),
        Some(_) => expected("a range of numbers such as `10 to 20`"),
        None => Ok(Value::Word(first)),
    }
}

/// The end of a range after a word or a sign of its own: `to 20`, `: 20`, `- 20`.
fn range_end(input: &mut Input<'_>) -> ModalResult<String> {
    preceded(alt((keyword("to"), keyword(":"), keyword("-"))), plain).parse_next(input)
}

fn sign(input: &mut Input<'_>) -> ModalResult<Sign> {
    preceded(
        multispace0,
        alt((
            "<=".value(Sign::AtMost),
            ">=".value(Sign::AtLeast),
            "==".value(Sign::Equal),
            "!=".value(Sign::Other),
            "<".value(Sign::Less),
            ">".value(Sign::More),
            "=".value(Sign::Equal),
        )),
    )
    .parse_next(input)
}

/// Text between quotes, which may contain anything else.
fn quoted(input: &mut Input<'_>) -> ModalResult<String> {
    let between = |mark: char| delimited(mark, take_till(0.., mark), mark);
    preceded(multispace0, alt((between('"'), between('\'')))).map(str::to_owned).parse_next(input)
}

/// A word that may be a value: not reserved.
fn plain(input: &mut Input<'_>) -> ModalResult<String> {
    word.verify(|word: &String| !is_reserved(word)).parse_next(input)
}

fn is_reserved(word: &str) -> bool {
    RESERVED.contains(&word) || single(word).is_some()
}

/// A word: quotes and apostrophes may follow its first character (`O5'`).
fn word(input: &mut Input<'_>) -> ModalResult<String> {
    let ends = |c: char| c.is_whitespace() || "()<>=!".contains(c);
    // `!` belongs to a pattern such as `[!C]*`, but not to `!=`.
    let letters = alt((take_till(1.., ends), terminated("!", not(one_of(['=', ' '])))));
    let bare = preceded(not(one_of(['"', '\''])), repeat::<_, _, (), _, _>(1.., letters).take()).map(str::to_owned);
    preceded(multispace0, bare).verify(|word: &String| word != "&&" && word != "||").parse_next(input)
}

/// A word of the grammar, in small letters as in other programs: `OF` may be a residue.
fn keyword<'a>(expected: &'static str) -> impl Parser<Input<'a>, (), ErrMode<ContextError>> {
    word.verify(move |word: &String| word == expected).void()
}

fn symbol<'a>(expected: &'static str) -> impl Parser<Input<'a>, (), ErrMode<ContextError>> {
    preceded(multispace0, expected).void()
}
