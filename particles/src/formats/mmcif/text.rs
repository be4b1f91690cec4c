//! The words of a CIF file (Hall, Allen and Brown, Acta Cryst. A47, 655 (1991);
//! iucr.org/resources/cif/spec/version1.1), independent of line breaks.

use super::token::Token;
use crate::input::Input;
use crate::lines::{Lines, Spot};
use halfline_ground::error::{Error, Place, Result};
use std::ops::Range;

/// The most bytes of a multi-line text that are stored.
const LONGEST: usize = 1 << 20;

/// A file's words.
pub(super) struct TextTokens {
    lines: Lines<Input>,
    /// The next byte of the line.
    at: usize,
    /// The word in its line, without quotes.
    span: Range<usize>,
    quoted: bool,
    /// Whether its quote is not closed.
    unclosed: bool,
    first_unclosed: Option<Spot>,
    /// A multi-line text, if the word is one, and where it begins.
    text: Option<Spot>,
    buffer: Vec<u8>,
    /// Whether the text is longer than the buffer.
    cut: bool,
    /// A word that was put back.
    kept: Option<Token>,
}

impl TextTokens {
    pub(super) fn new(lines: Lines<Input>) -> Self {
        Self {
            lines,
            at: 0,
            span: 0..0,
            quoted: false,
            unclosed: false,
            first_unclosed: None,
            text: None,
            buffer: Vec::new(),
            cut: false,
            kept: None,
        }
    }

    /// Moves to the next word.
    pub(super) fn next(&mut self) -> Result<Token> {
        if let Some(token) = self.kept.take() {
            return Ok(token);
        }
        (self.quoted, self.unclosed, self.text) = (false, false, None);
        loop {
            let line = self.lines.text().as_bytes();
            let rest = line.get(self.at..).unwrap_or_default();
            let start = self.at + rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            match line.get(start) {
                None | Some(b'#') => {
                    if !self.lines.advance()? {
                        return Ok(Token::End);
                    }
                    self.at = 0;
                    if self.lines.text().starts_with(';') {
                        return self.text();
                    }
                }
                Some(quote @ (b'"' | b'\'')) => {
                    let inside = &line[start + 1..];
                    // A quote within a word is part of it.
                    let ends =
                        |k: &usize| inside[*k] == *quote && inside.get(k + 1).is_none_or(u8::is_ascii_whitespace);
                    let end = (0..inside.len()).find(ends);
                    if end.is_none() {
                        self.unclosed = true;
                        self.first_unclosed.get_or_insert_with(|| self.lines.spot(start));
                    }
                    let end = end.unwrap_or(inside.len());
                    (self.span, self.at, self.quoted) = (start + 1..start + 1 + end, start + end + 2, true);
                    return Ok(Token::Value);
                }
                Some(first) => {
                    let word = &line[start..];
                    let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
                    (self.span, self.at) = (start..start + end, start + end);
                    return Ok(kind(*first, &word[..end]));
                }
            }
        }
    }

    /// Reads the text that begins with this line, up to a line that begins with a semicolon.
    fn text(&mut self) -> Result<Token> {
        let spot = self.lines.spot(0);
        (self.text, self.cut) = (Some(spot), false);
        self.buffer.clear();
        self.buffer.extend(&self.lines.text().as_bytes()[1..]);
        while self.lines.advance()? {
            if self.lines.text().starts_with(';') {
                self.at = 1;
                return Ok(Token::Value);
            }
            // Such texts may contain whole data files, which are not used here.
            let line = self.lines.text().as_bytes();
            self.cut |= self.buffer.len() + line.len() >= LONGEST;
            if !self.cut {
                self.buffer.push(b'\n');
                self.buffer.extend(line);
            }
        }
        let problem = "a text that begins with a semicolon has no end";
        Err(Error::scene(spot.of(self.lines.file()), problem, "end the text with a line that begins with a semicolon"))
    }

    /// Puts the current word back, to be returned again.
    pub(super) fn give_back(&mut self, token: Token) {
        self.kept = Some(token);
    }

    /// The current word; empty at the end.
    pub(super) fn word(&self) -> &[u8] {
        match self.text {
            Some(_) => &self.buffer,
            // After the last line there is none.
            None => self.lines.text().as_bytes().get(self.span.clone()).unwrap_or_default(),
        }
    }

    /// The current value; empty for `.` and `?`, which mean none.
    pub(super) fn value(&self) -> &[u8] {
        match self.word() {
            b"." | b"?" if !self.quoted && self.text.is_none() => b"",
            word => word,
        }
    }

    /// The current value as text.
    ///
    /// # Errors
    /// [`Error::Scene`] for a text too long to be a name or a list of names.
    pub(super) fn string(&self) -> Result<String> {
        if self.cut && self.text.is_some() {
            let problem = format!("expected a name or a list of names, found a text of more than {LONGEST} bytes");
            return Err(Error::scene(self.place(), problem, "use a shorter one"));
        }
        Ok(String::from_utf8_lossy(self.value()).trim().to_owned())
    }

    /// The error for a value whose quote is not closed: RASPA and others write it, and it then ends with its line. In a row it
    /// would take the values behind it.
    ///
    /// # Errors
    /// [`Error::Scene`] for such a value that others follow in its row.
    pub(super) fn check_quote(&self) -> Result<()> {
        if !self.unclosed {
            return Ok(());
        }
        let place = self.lines.place(self.span.start.saturating_sub(1));
        Err(Error::scene(place, "a quote is not closed in its line", "add the closing quote before a blank"))
    }

    /// The message about values whose quote is not closed.
    pub(super) fn quote_warning(&mut self) -> Option<String> {
        let place = self.first_unclosed.take()?.of(self.file());
        Some(format!("{place}: a quote is not closed, so its value ends with the line"))
    }

    /// Reports that the current line contains an atom.
    pub(super) fn found(&self) {
        self.lines.found();
    }

    /// The place of the current word.
    pub(super) fn place(&self) -> Place {
        self.spot().of(self.file())
    }

    /// The same, for a later error.
    pub(super) fn spot(&self) -> Spot {
        self.text.unwrap_or_else(|| self.lines.spot(self.span.start))
    }

    pub(super) fn file(&self) -> Place {
        self.lines.file()
    }
}

fn kind(first: u8, word: &[u8]) -> Token {
    let begins = |name: &[u8]| word.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name));
    match first {
        b'_' => Token::Tag,
        b'l' | b'L' if word.eq_ignore_ascii_case(b"loop_") => Token::Loop,
        b'd' | b'D' if begins(b"data_") => Token::Block,
        b's' | b'S' if begins(b"save_") || word.eq_ignore_ascii_case(b"stop_") => Token::Other,
        b'g' | b'G' if word.eq_ignore_ascii_case(b"global_") => Token::Other,
        _ => Token::Value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::mmcif::token::number;
    use crate::source::Source;

    fn words(text: &str) -> Result<Vec<(Token, String)>> {
        let source = Source::of_text(text);
        let mut tokens = TextTokens::new(Lines::new(source.reader, &source.path));
        let mut found = Vec::new();
        loop {
            match tokens.next()? {
                Token::End => return Ok(found),
                token => found.push((token, tokens.string()?)),
            }
        }
    }

    #[test]
    fn tokens_follow_the_specification() {
        let text = "# a comment\r\nDATA_1ABC _a.b 'it's' \"O5'\" # more\nloop_\n_c\n a#b ';' ; ?  '?'\n;first\nsecond\n; . loop_x\n\
            save_ stop_ 'a\"' '' ''' 1";
        let found = words(text).expect("words");
        let expected = [
            (Token::Block, "DATA_1ABC"),
            (Token::Tag, "_a.b"),
            (Token::Value, "it's"),
            (Token::Value, "O5'"),
            (Token::Loop, "loop_"),
            (Token::Tag, "_c"),
            (Token::Value, "a#b"),
            (Token::Value, ";"),
            (Token::Value, ";"),
            (Token::Value, ""),
            (Token::Value, "?"),
            (Token::Value, "first\nsecond"),
            (Token::Value, ""),
            (Token::Value, "loop_x"),
            (Token::Other, "save_"),
            (Token::Other, "stop_"),
            (Token::Value, "a\""),
            (Token::Value, ""),
            (Token::Value, "'"),
            (Token::Value, "1"),
        ];
        let found: Vec<(Token, &str)> = found.iter().map(|(token, word)| (*token, &word[..])).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn an_unterminated_value_is_refused() {
        let found = words("data_x\n_a  'open to its end\n_b 1\n").expect("a quote that ends with its line");
        assert_eq!(
            found[2..],
            [(Token::Value, "open to its end".into()), (Token::Tag, "_b".into()), (Token::Value, "1".into())]
        );
        let error = words("data_x\n_a\n;open\nstill\n").expect_err("a text").to_string();
        assert!(error.contains("text:3:1"), "{error}");
        assert_eq!(
            [number(b"1.25(3)"), number(b" -2 "), number(b"inf"), number(b"(")],
            [Some(1.25), Some(-2.0), None, None]
        );
    }
}
