//! Requests of HTTP/1.1, read from any reader within limits.

use std::io::{self, Read};

/// The most bytes of a request line and its headers.
pub(crate) const HEAD: usize = 16 << 10;

/// The most bytes of a body.
pub(crate) const BODY: usize = 64 << 10;

/// The most headers. Browsers send about 15.
const HEADERS: usize = 64;

/// A request that the server itself refuses.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Refused {
    pub(crate) status: u16,
    pub(crate) message: &'static str,
}

/// Shorthand for what functions here return.
pub(crate) fn refused<T>(status: u16, message: &'static str) -> Result<T, Refused> {
    Err(Refused { status, message })
}

/// Why there is no request.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    Refused(Refused),
    /// The other side has gone in the middle of it.
    Gone,
}

impl From<Refused> for Trouble {
    fn from(refused: Refused) -> Self {
        Self::Refused(refused)
    }
}

/// A request line and its headers.
#[derive(Debug)]
pub(crate) struct Head {
    pub(crate) method: String,
    pub(crate) target: String,
    /// The names in lower case.
    headers: Vec<(String, String)>,
    /// Whether it is HTTP/1.1 rather than 1.0.
    is_newer: bool,
}

impl Head {
    /// The head at the beginning of these bytes and its length; `None` if there are too few of them.
    fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, Refused> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        let length = match request.parse(bytes) {
            Ok(httparse::Status::Complete(length)) => length,
            Ok(httparse::Status::Partial) => return Ok(None),
            Err(httparse::Error::TooManyHeaders) => return refused(431, "the request has too many headers"),
            Err(_) => return refused(400, "this is not a request of HTTP/1.1"),
        };
        let headers = request.headers.iter().map(|header| {
            let value = std::str::from_utf8(header.value).ok().filter(|value| value.is_ascii());
            Some((header.name.to_ascii_lowercase(), value?.to_owned()))
        });
        let (Some(headers), Some(method), Some(target)) =
            (headers.collect::<Option<Vec<_>>>(), request.method, request.path)
        else {
            return refused(400, "the request has characters outside of ASCII");
        };
        let (method, target) = (method.to_owned(), target.to_owned());
        Ok(Some((Self { method, target, headers, is_newer: request.version == Some(1) }, length)))
    }

    /// The value of a header that may be there once.
    pub(crate) fn one(&self, name: &str) -> Result<Option<&str>, Refused> {
        let mut values = self.headers.iter().filter(|header| header.0 == name).map(|header| &*header.1);
        let first = values.next();
        if values.next().is_some() { refused(400, "a header is there twice") } else { Ok(first) }
    }

    /// The number of bytes of the body; `None` if nothing is said about one.
    pub(crate) fn length(&self) -> Result<Option<usize>, Refused> {
        let length = self.one("content-length")?;
        if self.one("transfer-encoding")?.is_some() {
            // Both together are an attempt to smuggle a request.
            let status = if length.is_some() { 400 } else { 411 };
            return refused(status, "a body is sent with Content-Length, not in chunks");
        }
        let Some(length) = length else { return Ok(None) };
        if length.is_empty() || !length.bytes().all(|digit| digit.is_ascii_digit()) {
            return refused(400, "Content-Length is not a number");
        }
        match length.parse() {
            Ok(length) if length <= BODY => Ok(Some(length)),
            _ => refused(413, "a body has at most 65,536 bytes"),
        }
    }

    /// Whether the connection stays open for another request.
    pub(crate) fn keeps_alive(&self) -> bool {
        let closes =
            |header: &(String, String)| header.0 == "connection" && header.1.to_ascii_lowercase().contains("close");
        self.is_newer && !self.headers.iter().any(closes)
    }
}

/// A reader, and the bytes of it that no request has used yet.
pub(crate) struct Input<R> {
    reader: R,
    bytes: Vec<u8>,
}

impl<R: Read> Input<R> {
    pub(crate) fn new(reader: R) -> Self {
        Self { reader, bytes: Vec::new() }
    }

    /// Waits for a byte; whether one came.
    pub(crate) fn wait(&mut self) -> bool {
        !self.bytes.is_empty() || self.more() == Ok(())
    }

    /// Reads some bytes more.
    fn more(&mut self) -> Result<(), Trouble> {
        let mut block = [0; 4096];
        loop {
            match self.reader.read(&mut block) {
                Ok(0) => return Err(Trouble::Gone),
                Ok(count) => {
                    self.bytes.extend_from_slice(&block[..count]);
                    return Ok(());
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) => {
                    return Ok(refused(408, "the request took too long to arrive")?);
                }
                Err(_) => return Err(Trouble::Gone),
            }
        }
    }

    /// The next head.
    pub(crate) fn head(&mut self) -> Result<Head, Trouble> {
        loop {
            // The same bytes have the same fate, however they are cut into pieces.
            let within = &self.bytes[..self.bytes.len().min(HEAD)];
            if let Some((head, length)) = Head::parse(within)? {
                self.bytes.drain(..length);
                return Ok(head);
            }
            if within.len() == HEAD {
                return Ok(refused(431, "the head of a request has at most 16,384 bytes")?);
            }
            self.more()?;
        }
    }

    /// The body that follows a head.
    pub(crate) fn body(&mut self, length: usize) -> Result<Vec<u8>, Trouble> {
        while self.bytes.len() < length {
            self.more()?;
        }
        let rest = self.bytes.split_off(length);
        Ok(std::mem::replace(&mut self.bytes, rest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(text: &str) -> Result<Head, Trouble> {
        Input::new(text.as_bytes()).head()
    }

    fn status<T: std::fmt::Debug>(result: Result<T, Trouble>) -> u16 {
        match result {
            Ok(_) => 200,
            Err(Trouble::Refused(refused)) => refused.status,
            Err(Trouble::Gone) => 0,
        }
    }

    #[test]
    fn requests_follow_each_other() {
        let mut input = Input::new(&b"POST /a HTTP/1.1\r\nContent-Length: 2\r\n\r\n{}GET /b HTTP/1.0\r\n\r\n"[..]);
        let first = input.head().expect("a head");
        assert_eq!(
            (&*first.method, &*first.target, first.length(), first.keeps_alive()),
            ("POST", "/a", Ok(Some(2)), true)
        );
        assert_eq!(input.body(2), Ok(b"{}".to_vec()));
        let second = input.head().expect("another");
        assert_eq!((&*second.target, second.length(), second.keeps_alive()), ("/b", Ok(None), false));
        assert!(!input.wait());
    }

    #[test]
    fn heads_have_limits() {
        let of = |size: usize| format!("GET / HTTP/1.1\r\nA: {}\r\n\r\n", "x".repeat(size - 23));
        assert_eq!(status(head(&of(HEAD))), 200);
        assert_eq!(status(head(&of(HEAD + 1))), 431);
        let many = |count: usize| format!("GET / HTTP/1.1\r\n{}\r\n", "A: x\r\n".repeat(count));
        assert_eq!(status(head(&many(HEADERS))), 200);
        assert_eq!(status(head(&many(HEADERS + 1))), 431);
        assert_eq!(status(head("GET / HTTP/1.1\r\nHost: a")), 0);
        for bad in [
            "GET / HTTP/2.0\r\n\r\n",
            "GET /\r\n\r\n",
            "\u{16}\u{3}\u{1}",
            "GET / HTTP/1.1\r\nA : b\r\n\r\n",
            "GET / HTTP/1.1\r\nA: é\r\n\r\n",
        ] {
            assert_eq!(status(head(bad)), 400, "{bad:?}");
        }
    }

    #[test]
    fn a_length_is_a_plain_number() {
        let of = |headers: &str| {
            let head = head(&format!("POST / HTTP/1.1\r\n{headers}\r\n\r\n")).expect("a head");
            head.length().map_err(|refused| refused.status)
        };
        assert_eq!(of("Content-Length: 65536"), Ok(Some(BODY)));
        assert_eq!(of("Content-Length: 65537"), Err(413));
        assert_eq!(of("Content-Length: 99999999999999999999999"), Err(413));
        for bad in ["-1", "+1", "1, 1", "0x1", "1 ", "1.0", ""].map(|value| format!("Content-Length: {value}")) {
            let expected = if bad.ends_with("1 ") { Ok(Some(1)) } else { Err(400) };
            assert_eq!(of(&bad), expected, "{bad}");
        }
        assert_eq!(of("Content-Length: 1\r\nContent-Length: 1"), Err(400));
        assert_eq!(of("Transfer-Encoding: chunked"), Err(411));
        assert_eq!(of("Transfer-Encoding: identity\r\nContent-Length: 1"), Err(400));
    }
}
