//! Text in XML.

use crate::canvas::plain;

/// Text between tags.
pub(super) fn text(text: &str) -> String {
    plain(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The value of an attribute, in double quotes.
pub(super) fn attribute(value: &str) -> String {
    text(value).replace('"', "&quot;")
}

/// A name of letters, digits and hyphens, for ids and names of attributes.
pub(super) fn name(of: &str) -> String {
    of.chars().map(|c| if c.is_ascii_alphanumeric() || matches!(c, '_' | '.') { c } else { '-' }).collect()
}
