//! Python literals as far as a .npy header has them: texts, whole numbers, True and False, tuples, lists, dictionaries.

use winnow::ascii::{digit1, multispace0};
use winnow::combinator::{alt, delimited, opt, peek, preceded, repeat, separated_pair, terminated};
use winnow::error::EmptyError;
use winnow::prelude::*;
use winnow::token::{none_of, one_of};

/// A literal.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Literal {
    Text(String),
    Number(u64),
    Bool(bool),
    /// A tuple or a list.
    List(Vec<Literal>),
    /// A dictionary whose keys are texts.
    Dict(Vec<(String, Literal)>),
}

/// Deeper brackets are not read: the type of a record within records takes two a level.
const DEEPEST: usize = 16;

type Found<T> = winnow::Result<T, EmptyError>;

impl Literal {
    /// The literal that is the whole text.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let whole = |input: &mut &str| literal(input, DEEPEST);
        terminated(whole, multispace0).parse(text).ok()
    }

    /// The value of a [`Literal::Number`].
    pub(super) fn number(&self) -> Option<u64> {
        if let Self::Number(number) = self { Some(*number) } else { None }
    }
}

/// A literal with less than `depth` brackets around each other.
fn literal(input: &mut &str, depth: usize) -> Found<Literal> {
    let depth = depth.checked_sub(1).ok_or(EmptyError)?;
    let inner = |input: &mut &str| literal(input, depth);
    multispace0.parse_next(input)?;
    match input.chars().next() {
        Some('(') => items('(', inner, ')').map(Literal::List).parse_next(input),
        Some('[') => items('[', inner, ']').map(Literal::List).parse_next(input),
        Some('{') => {
            items('{', separated_pair(text, (multispace0, ':'), inner), '}').map(Literal::Dict).parse_next(input)
        }
        _ => alt((
            text.map(Literal::Text),
            number.map(Literal::Number),
            "True".value(Literal::Bool(true)),
            "False".value(Literal::Bool(false)),
        ))
        .parse_next(input),
    }
}

/// Items between brackets, with commas between them and perhaps one behind the last.
fn items<'a, T>(
    open: char,
    item: impl Parser<&'a str, T, EmptyError>,
    close: char,
) -> impl Parser<&'a str, Vec<T>, EmptyError> {
    let ends = preceded(multispace0, alt((',', peek(close))));
    delimited(open, repeat(0.., terminated(item, ends)), (multispace0, close))
}

/// A text in quotes, behind any blanks. Only the escapes of a quote and of a backslash are read.
fn text(input: &mut &str) -> Found<String> {
    let quote = preceded(multispace0, one_of(['\'', '"'])).parse_next(input)?;
    let letter = alt((none_of([quote, '\\']), preceded('\\', one_of(['\'', '"', '\\']))));
    terminated(repeat(0.., letter), quote).parse_next(input)
}

/// A whole number below 2^64; Python 2 ends it with an `L`.
fn number(input: &mut &str) -> Found<u64> {
    terminated(digit1.parse_to(), opt('L')).parse_next(input)
}
