//! Who may ask. Any page in the user's browser and every program and user of this machine can reach a port of 127.0.0.1, so a
//! request must name this host, come from the page itself, and show the token.

use crate::http::{Head, Refused, refused};
use crate::routes::Route;

/// The route of a request that may be answered.
pub(crate) fn admit(head: &Head, token: &str) -> Result<Route, Refused> {
    check_origin(head)?;
    let route = Route::of(&head.method, &head.target)?;
    if matches!(route, Route::Ask(_)) {
        check_token(head, token)?;
    }
    Ok(route)
}

/// Whether it names this host, and comes from the page itself or from no page.
fn check_origin(head: &Head) -> Result<(), Refused> {
    let Some(host) = head.one("host")? else { return refused(400, "the request has no Host") };
    // A name of somebody else that leads to 127.0.0.1 (DNS rebinding) makes his page and this server one origin.
    if !is_here(host) {
        return refused(403, "Host is not localhost, 127.0.0.1 or [::1]");
    }
    if head.one("origin")?.is_some_and(|origin| origin.strip_prefix("http://") != Some(host)) {
        return refused(403, "the request comes from another page");
    }
    match head.one("sec-fetch-site")? {
        None | Some("same-origin" | "none") => Ok(()),
        _ => refused(
            403,
            "the request comes from another page: put the address into the browser's address line yourself",
        ),
    }
}

/// Whether a Host is this machine, with any port or without.
fn is_here(host: &str) -> bool {
    ["localhost", "127.0.0.1", "[::1]"].iter().filter_map(|name| host.strip_prefix(name)).any(|port| {
        let is_number = |port: &str| port.bytes().all(|c| c.is_ascii_digit()) && port.parse::<u16>().is_ok();
        port.is_empty() || port.strip_prefix(':').is_some_and(is_number)
    })
}

/// Whether it shows the token.
fn check_token(head: &Head, token: &str) -> Result<(), Refused> {
    match head.one("authorization")? {
        None => refused(401, "the request has no token: open the address that halfline view printed"),
        Some(given) if given.strip_prefix("Bearer ").is_some_and(|given| is_same(given, token)) => Ok(()),
        Some(_) => refused(403, "this token is not valid: open the address that halfline view printed last"),
    }
}

/// Compares in a time that does not depend on the bytes.
fn is_same(given: &str, token: &str) -> bool {
    let differing = given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| std::hint::black_box(all | (a ^ b)));
    given.len() == token.len() && differing == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_exact() {
        for good in ["localhost", "127.0.0.1", "[::1]", "localhost:8642", "127.0.0.1:1", "[::1]:65535", "localhost:80"]
        {
            assert!(is_here(good), "{good}");
        }
        for bad in [
            "",
            "evil.com",
            "evil.com:8642",
            "localhost.evil.com",
            "localhost:",
            "localhost:x",
            "localhost:65536",
            "localhost:+1",
            "localhost:8642:1",
            "LOCALHOST",
            "127.0.0.1.",
            "127.0.0.2",
            "127.1",
            "2130706433",
            "0.0.0.0",
            "::1",
            "[::1",
            "[::]",
            "user@127.0.0.1",
            "127.0.0.1:8642@evil.com",
            "127.0.0.1 ",
            "127.0.0.1/",
            "127.0.0.1:80, localhost",
            "[::ffff:127.0.0.1]",
        ] {
            assert!(!is_here(bad), "{bad}");
        }
    }

    #[test]
    fn tokens_are_compared_whole() {
        assert!(is_same("abc", "abc"));
        for other in ["", "ab", "abcd", "abd", "ABC", "abc "] {
            assert!(!is_same(other, "abc"), "{other}");
        }
    }
}
