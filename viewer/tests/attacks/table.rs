//! The table of attacks, each a connection of its own: what is sent, and what comes.

use crate::client::{CALM, Request, get, post, start, statuses};

/// The name of a request, its bytes, and the statuses that are expected.
type Row = (&'static str, Vec<u8>, &'static str);

fn rows(all: &mut Vec<Row>, expected: &'static str, requests: Vec<(&'static str, Request)>) {
    all.extend(requests.into_iter().map(|(name, request)| (name, request.bytes(), expected)));
}

/// Requests from the page and from others: host, origin, site, token.
fn origins() -> Vec<Row> {
    let (ok, mut all) = (post("scene", "{}"), Vec::new());
    let host = |host: &str| ok.clone().without("Origin").set("Host", host);
    let origin = |origin: &str| ok.clone().set("Origin", origin);
    let site = |site: &str| ok.clone().set("Sec-Fetch-Site", site);
    let token = |token: &str| ok.clone().set("Authorization", token);
    rows(
        &mut all,
        "200",
        vec![
            ("the page", ok.clone()),
            ("Host localhost", host("localhost:PORT").add("Origin", "http://localhost:PORT")),
            ("Host [::1]", host("[::1]:PORT")),
            ("Host without a port", host("127.0.0.1")),
            ("no Origin, no Sec-Fetch-Site", ok.clone().without("Origin").without("Sec-Fetch-Site")),
            ("a file", get("/")),
            ("a file for the page", get("/view.js").set("Sec-Fetch-Site", "same-origin")),
        ],
    );
    rows(
        &mut all,
        "400",
        vec![
            ("no Host", ok.clone().without("Host")),
            ("two Hosts", ok.clone().add("Host", "127.0.0.1:PORT")),
            ("two Hosts, the second evil", ok.clone().add("host", "evil.com")),
            ("two Origins", ok.clone().add("Origin", "http://evil.com")),
            ("two Sec-Fetch-Site", ok.clone().add("Sec-Fetch-Site", "cross-site")),
            ("two tokens", ok.clone().add("Authorization", "Bearer 0")),
        ],
    );
    rows(
        &mut all,
        "403",
        vec![
            ("Host of a rebound name", host("evil.com:PORT").add("Origin", "http://evil.com:PORT")),
            ("Host of a rebound name, a file", get("/").set("Host", "evil.com:PORT")),
            ("Host with a name before it", host("user@127.0.0.1:PORT")),
            ("Host with a name behind it", host("127.0.0.1:PORT@evil.com")),
            ("Host localhost.evil.com", host("localhost.evil.com:PORT")),
            ("Host 127.0.0.1.", host("127.0.0.1.:PORT")),
            ("Host 0.0.0.0", host("0.0.0.0:PORT")),
            ("Host empty", host("")),
            ("Origin null", origin("null")),
            ("Origin evil", origin("http://evil.com")),
            ("Origin of another port", origin("http://127.0.0.1:1")),
            ("Origin https", origin("https://127.0.0.1:PORT")),
            ("Origin by another name", origin("http://localhost:PORT")),
            ("Origin with a path", origin("http://127.0.0.1:PORT/")),
            ("Origin empty", origin("")),
            ("Sec-Fetch-Site cross-site", site("cross-site")),
            ("Sec-Fetch-Site same-site", site("same-site")),
            ("Sec-Fetch-Site empty", site("")),
            ("a link followed to the page", get("/").set("Sec-Fetch-Site", "cross-site")),
            ("a wrong token", token("Bearer 00000000000000000000000000000000")),
            ("a short token", token("Bearer 0123")),
            ("a token and more", token("Bearer TOKEN0")),
            ("an empty token", token("Bearer ")),
            ("a token twice in one", token("Bearer TOKEN, Bearer TOKEN")),
            ("scheme Basic", token("Basic TOKEN")),
            ("no scheme", token("TOKEN")),
            ("a preflight from elsewhere", origin("http://evil.com").line("OPTIONS /frame HTTP/1.1")),
        ],
    );
    rows(&mut all, "401", vec![("no token", ok.clone().without("Authorization"))]);
    all
}

/// Methods and paths.
fn targets() -> Vec<Row> {
    let (ok, mut all) = (post("scene", "{}"), Vec::new());
    let line = |line: &str| ok.clone().line(line);
    rows(
        &mut all,
        "405",
        vec![
            ("GET /scene", line("GET /scene HTTP/1.1")),
            ("PUT /scene", line("PUT /scene HTTP/1.1")),
            ("POST /", line("POST / HTTP/1.1")),
            ("HEAD /", line("HEAD / HTTP/1.1")),
            ("TRACE /", line("TRACE / HTTP/1.1")),
            ("get /", line("get / HTTP/1.1")),
            ("a preflight", line("OPTIONS /frame HTTP/1.1").add("Access-Control-Request-Headers", "authorization")),
        ],
    );
    rows(
        &mut all,
        "404",
        vec![
            ("the token in the query", line("POST /scene?token=TOKEN HTTP/1.1").without("Authorization")),
            ("a query for a file", get("/?TOKEN")),
            ("/nothing", get("/nothing")),
            ("/../Cargo.toml", get("/../Cargo.toml")),
            ("/%2e%2e/Cargo.toml", get("/%2e%2e/Cargo.toml")),
            ("//etc/passwd", get("//etc/passwd")),
            ("/etc/passwd", get("/etc/passwd")),
            ("/view.js/../view.js", get("/view.js/../view.js")),
            ("/view.js%00.html", get("/view.js%00.html")),
            ("/..\\..\\Cargo.toml", get("/..\\..\\Cargo.toml")),
            ("POST /scene/", line("POST /scene/ HTTP/1.1")),
            ("POST //scene", line("POST //scene HTTP/1.1")),
        ],
    );
    rows(
        &mut all,
        "400",
        vec![
            ("http://127.0.0.1/ as the target", get("http://127.0.0.1:PORT/")),
            ("http://evil.com/ as the target", get("http://evil.com/")),
            ("CONNECT", line("CONNECT 127.0.0.1:80 HTTP/1.1")),
            ("OPTIONS *", line("OPTIONS * HTTP/1.1")),
            ("a space in the target", get("/a b")),
        ],
    );
    rows(&mut all, "414", vec![("2,000 bytes of target", get(&"/a".repeat(1000)))]);
    rows(&mut all, "204", vec![("the icon", get("/favicon.ico"))]);
    all
}

/// Requests with faults in their form: length, headers, version, protocol.
fn forms() -> Vec<Row> {
    let (ok, mut all) = (post("scene", "{}"), Vec::new());
    let length = |length: &str| ok.clone().set("Content-Length", length);
    let padded = |length: usize| post("scene", format!("{{{}}}", " ".repeat(length - 2)));
    rows(
        &mut all,
        "200",
        vec![
            ("a body of 64 KiB", padded(65_536)),
            ("a body longer than its length", post("scene", "{}{}").set("Content-Length", "2")),
        ],
    );
    rows(
        &mut all,
        "200 400",
        vec![(
            "the same, and the connection stays",
            post("scene", "{}{}").set("Content-Length", "2").without("Connection"),
        )],
    );
    rows(
        &mut all,
        "413",
        vec![
            ("a body of 64 KiB and a byte", padded(65_537)),
            ("a length of 10 GB", length("10000000000")),
            ("a length of 30 digits", length(&"9".repeat(30))),
        ],
    );
    rows(
        &mut all,
        "411",
        vec![
            ("no length", ok.clone().without("Content-Length")),
            (
                "chunks",
                post("scene", "2\r\n{}\r\n0\r\n\r\n").without("Content-Length").add("Transfer-Encoding", "chunked"),
            ),
        ],
    );
    rows(
        &mut all,
        "400",
        vec![
            ("chunks and a length", ok.clone().add("Transfer-Encoding", "chunked")),
            ("a negative length", length("-2")),
            ("a length with a sign", length("+2")),
            ("a length in hex", length("0x2")),
            ("two lengths in one", length("2, 2")),
            ("two lengths", ok.clone().add("Content-Length", "3")),
            ("two equal lengths", ok.clone().add("Content-Length", "2")),
            ("a file with a body", get("/").add("Content-Length", "2")),
            ("a header of two lines", ok.clone().add("A", "b\r\n c")),
            ("a space before a colon", ok.clone().add("A ", "b")),
            ("NUL in a header", ok.clone().add("A", "b\0c")),
            ("a header in UTF-8", ok.clone().add("A", "é")),
            ("HTTP/2.0", ok.clone().line("POST /scene HTTP/2.0")),
        ],
    );
    rows(
        &mut all,
        "431",
        vec![
            ("a header of 17 KiB", ok.clone().add("A", &"b".repeat(17 << 10))),
            ("10,000 headers", (0..10_000).fold(ok.clone(), |request, _| request.add("A", "b"))),
            ("65 short headers", (0..65).fold(ok.clone(), |request, _| request.add("A", "b"))),
        ],
    );
    all.push(("a hello of TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec(), "400"));
    all.push(("HTTP/0.9", b"GET /\r\n\r\n".to_vec(), "400"));
    all.push(("a hello of HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_vec(), "400"));
    all.push(("SMTP", b"EHLO evil.com\r\nMAIL FROM:<>\r\n".to_vec(), "400"));
    all
}

#[test]
fn only_the_page_is_answered() {
    let server = start(CALM, None);
    let (mut faults, mut count) = (Vec::new(), 0);
    for (name, request, expected) in [origins(), targets(), forms()].concat() {
        let calls = server.stage.calls();
        let answer = server.ask(&request);
        let (found, text) = (statuses(&answer), String::from_utf8_lossy(&answer).into_owned());
        println!("{name:<40} {found}");
        count += 1;
        let is_called = server.stage.calls() > calls;
        let is_question = expected.starts_with("200") && request.starts_with(b"POST");
        if found != expected || is_called != is_question {
            faults.push(format!("{name}: {found} and not {expected}, reached the stage: {is_called}"));
        }
        for header in ["default-src 'none'", "X-Content-Type-Options: nosniff", "Cache-Control: no-store"] {
            assert!(text.contains(header), "{name}: {text}");
        }
        assert!(!text.to_lowercase().contains("access-control-allow"), "{name}: {text}");
        assert!(!text.contains(&server.token), "{name} gets the token: {text}");
        let is_error = !expected.starts_with('2');
        assert_eq!(text.contains("\"kind\":\"settings\""), is_error || expected == "200 400", "{name}: {text}");
    }
    println!("{count} requests");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    server.stop();
}
