//! Fields in quotes, which may have line breaks (RFC 4180).

/// The bytes that may separate fields, the most certain first. Blanks are the last.
pub(crate) const DELIMITERS: [u8; 5] = [b'\t', b';', b',', b'|', b' '];

/// The quotes of a record whose lines arrive one by one.
pub(crate) struct Quotes {
    delimiter: u8,
    state: Quoting,
}

/// The place in a field.
#[derive(Clone, Copy, PartialEq)]
enum Quoting {
    /// Before it.
    Begin,
    Plain,
    Quoted,
    /// Behind a quote, which ends the quoted text or is doubled.
    Quote,
    /// Behind the quoted text.
    Closed,
}

impl Quotes {
    /// No lines yet of a record whose fields are separated by `delimiter`, or for 0 by any.
    pub(crate) fn of(delimiter: u8) -> Self {
        Self { delimiter, state: Quoting::Begin }
    }

    /// Whether the record ends within quotes after a line more; `None` where text follows a quote that closes a field, so that
    /// quotes mean something else.
    pub(crate) fn are_open(&mut self, line: &[u8]) -> Option<bool> {
        for byte in line {
            let ends = if self.delimiter == 0 { DELIMITERS.contains(byte) } else { ends(*byte, self.delimiter) };
            self.state = match self.state {
                Quoting::Quoted if *byte == b'"' => Quoting::Quote,
                Quoting::Quote if *byte == b'"' => Quoting::Quoted,
                Quoting::Quoted => Quoting::Quoted,
                _ if ends => Quoting::Begin,
                Quoting::Plain => Quoting::Plain,
                Quoting::Begin if byte.is_ascii_whitespace() => Quoting::Begin,
                Quoting::Begin if *byte == b'"' => Quoting::Quoted,
                Quoting::Begin => Quoting::Plain,
                Quoting::Quote | Quoting::Closed if byte.is_ascii_whitespace() => Quoting::Closed,
                Quoting::Quote | Quoting::Closed => return None,
            };
        }
        Some(self.state == Quoting::Quoted)
    }
}

/// Whether a byte ends a field without quotes.
pub(crate) fn ends(byte: u8, delimiter: u8) -> bool {
    if delimiter == b' ' { byte.is_ascii_whitespace() } else { byte == delimiter }
}
