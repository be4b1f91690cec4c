//! Answers, and how they are written as HTTP.

use crate::http::Refused;
use crate::stage::Refusal;
use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, Write};

/// Headers of every answer. The page loads everything from this server and nothing from elsewhere. No other page may
/// embed it, read from it or open it with a handle on it. There is no Access-Control-Allow-Origin, so that browsers
/// keep other pages from asking.
const ALWAYS: &str = "\
Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r
X-Content-Type-Options: nosniff\r
Referrer-Policy: no-referrer\r
Cross-Origin-Resource-Policy: same-origin\r
Cross-Origin-Opener-Policy: same-origin\r
Cache-Control: no-store\r
";

/// The most bytes of the header `X-Halfline`.
const LONGEST: usize = 16 << 10;

/// An answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// The status of HTTP.
    pub status: u16,
    /// The kind of content; empty without a body.
    pub content_type: &'static str,
    /// The header `X-Halfline` of a frame: a JSON object in ASCII.
    pub halfline: Option<String>,
    /// The content.
    pub body: Cow<'static, [u8]>,
}

impl Reply {
    /// No content.
    pub(crate) const EMPTY: Self = Self { status: 204, content_type: "", halfline: None, body: Cow::Borrowed(&[]) };

    pub(crate) fn new(content_type: &'static str, body: impl Into<Cow<'static, [u8]>>) -> Self {
        Self { status: 200, content_type, halfline: None, body: body.into() }
    }

    pub(crate) fn json(value: &Value) -> Self {
        Self::new("application/json", value.to_string().into_bytes())
    }

    pub(crate) fn refusal(status: u16, refusal: &Refusal) -> Self {
        Self { status, ..Self::json(&refusal.json()) }
    }

    /// With the header `X-Halfline`.
    pub(crate) fn with(self, info: Value) -> Self {
        Self { halfline: Some(header(info)), ..self }
    }

    /// Writes it as HTTP.
    pub(crate) fn write(&self, writer: &mut impl Write, keeps_alive: bool) -> io::Result<()> {
        let connection = if keeps_alive { "keep-alive" } else { "close" };
        let mut head =
            format!("HTTP/1.1 {} {}\r\nConnection: {connection}\r\n{ALWAYS}", self.status, reason(self.status));
        match self.status {
            204 => {}
            _ => head += &format!("Content-Type: {}\r\nContent-Length: {}\r\n", self.content_type, self.body.len()),
        }
        match self.status {
            401 => head += "WWW-Authenticate: Bearer\r\n",
            405 => head += "Allow: GET, POST\r\n",
            _ => {}
        }
        if let Some(halfline) = &self.halfline {
            head += &format!("X-Halfline: {halfline}\r\n");
        }
        head += "\r\n";
        // One write, so that a small answer is one packet.
        let mut bytes = head.into_bytes();
        bytes.extend_from_slice(&self.body);
        writer.write_all(&bytes)?;
        writer.flush()
    }
}

impl From<Refused> for Reply {
    fn from(refused: Refused) -> Self {
        Self::refusal(refused.status, &Refusal::settings(refused.message))
    }
}

/// A JSON object as the value of a header: in ASCII, and of limited length.
fn header(mut info: Value) -> String {
    let ascii = |info: &Value| {
        let mut text = String::new();
        for c in info.to_string().chars() {
            if c.is_ascii_graphic() || c == ' ' {
                text.push(c);
            } else {
                c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| text += &format!("\\u{unit:04x}"));
            }
        }
        text
    };
    let text = ascii(&info);
    match info.as_object_mut() {
        Some(object) if text.len() > LONGEST => {
            object.insert("warnings".into(), serde_json::json!(["there are too many warnings to list"]));
            ascii(&info)
        }
        _ => text,
    }
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        204 => "No Content",
        400 => "Bad Request",
        401 => "Unauthorized",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        411 => "Length Required",
        413 => "Content Too Large",
        414 => "URI Too Long",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Internal Server Error",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_header_is_ascii_and_short() {
        let info = json!({ "adapter": "µ\n\u{1f600}\u{7f}", "ms": 1.5 });
        let text = header(info.clone());
        assert_eq!(text, r#"{"adapter":"\u00b5\n\ud83d\ude00\u007f","ms":1.5}"#);
        assert_eq!(serde_json::from_str::<Value>(&text).expect("JSON"), info);
        let long = header(json!({ "seq": 1, "warnings": ["é".repeat(5000)] }));
        assert!(long.len() < 100 && long.contains("\"seq\":1"), "{long}");
    }

    #[test]
    fn every_answer_has_the_headers() {
        let written = |reply: Reply, keeps_alive| {
            let mut bytes = Vec::new();
            reply.write(&mut bytes, keeps_alive).expect("written");
            String::from_utf8(bytes).expect("text")
        };
        let empty = written(Reply::EMPTY, true);
        assert!(empty.starts_with("HTTP/1.1 204 No Content\r\nConnection: keep-alive\r\n"), "{empty}");
        assert!(empty.ends_with("\r\n\r\n") && !empty.contains("Content-Length"), "{empty}");
        let refused = written(Refused { status: 403, message: "no" }.into(), false);
        assert!(
            refused.ends_with("\r\n\r\n{\"error\":{\"exit\":2,\"kind\":\"settings\",\"message\":\"no\"}}"),
            "{refused}"
        );
        for text in [empty, refused] {
            for name in ["frame-ancestors 'none'", "nosniff", "no-referrer", "no-store", "Opener-Policy: same-origin"] {
                assert!(text.contains(name), "{name}: {text}");
            }
            assert!(!text.contains("Access-Control"));
        }
    }
}
