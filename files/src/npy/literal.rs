//! Python literals as far as a .npy header has them: texts, whole numbers, True and False, tuples, lists, dictionaries.

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

impl Literal {
    /// The literal that is the whole text.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut parser = Parser { rest: text };
        let literal = parser.literal(DEEPEST)?;
        parser.skip_space();
        parser.rest.is_empty().then_some(literal)
    }

    /// The value of a [`Literal::Number`].
    pub(super) fn number(&self) -> Option<u64> {
        if let Self::Number(number) = self { Some(*number) } else { None }
    }
}

struct Parser<'a> {
    rest: &'a str,
}

impl<'a> Parser<'a> {
    fn skip_space(&mut self) {
        self.rest = self.rest.trim_start_matches([' ', '\t', '\n', '\r']);
    }

    /// Takes `symbol` if it comes next.
    fn take(&mut self, symbol: &str) -> bool {
        self.skip_space();
        let rest = self.rest.strip_prefix(symbol);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn literal(&mut self, depth: usize) -> Option<Literal> {
        let depth = depth.checked_sub(1)?;
        self.skip_space();
        match self.rest.chars().next()? {
            '\'' | '"' => self.text().map(Literal::Text),
            '0'..='9' => self.number().map(Literal::Number),
            '(' => self.items("(", ")", |this| this.literal(depth)).map(Literal::List),
            '[' => self.items("[", "]", |this| this.literal(depth)).map(Literal::List),
            '{' => {
                let entry = |this: &mut Self| {
                    this.skip_space();
                    let key = this.text()?;
                    if this.take(":") { Some((key, this.literal(depth)?)) } else { None }
                };
                self.items("{", "}", entry).map(Literal::Dict)
            }
            _ if self.take("True") => Some(Literal::Bool(true)),
            _ if self.take("False") => Some(Literal::Bool(false)),
            _ => None,
        }
    }

    /// Items between brackets, with commas between them and perhaps one behind the last.
    fn items<T>(&mut self, open: &str, close: &str, mut item: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let mut items = Vec::new();
        let mut more = self.take(open);
        while !self.take(close) {
            if !more {
                return None;
            }
            items.push(item(self)?);
            more = self.take(",");
        }
        Some(items)
    }

    /// A text in quotes. Of the escapes only those of a quote and a backslash are read.
    fn text(&mut self) -> Option<String> {
        let quote = self.rest.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
        let mut text = String::new();
        let mut chars = self.rest[1..].char_indices();
        while let Some((at, c)) = chars.next() {
            match c {
                _ if c == quote => {
                    self.rest = &self.rest[1 + at + 1..];
                    return Some(text);
                }
                '\\' => text.push(chars.next().map(|(_, c)| c).filter(|c| matches!(c, '\'' | '"' | '\\'))?),
                _ => text.push(c),
            }
        }
        None
    }

    /// A whole number below 2^64; Python 2 ends it with an `L`.
    fn number(&mut self) -> Option<u64> {
        let end = self.rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(self.rest.len());
        let (digits, rest) = self.rest.split_at(end);
        self.rest = rest.strip_prefix('L').unwrap_or(rest);
        digits.parse().ok()
    }
}
