//! A running server, and raw requests to it.

use crate::stage::{Fake, LONG};
use halfline_viewer::{Server, Times};
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// A server in a thread.
pub(crate) struct Running {
    pub(crate) port: u16,
    pub(crate) token: String,
    pub(crate) stage: Arc<Fake>,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<io::Result<()>>,
}

/// Times that do not matter to the test.
pub(crate) const CALM: Times = Times { request: LONG, idle: LONG };

/// Starts a server on a free port.
pub(crate) fn start(times: Times, idle: Option<Duration>) -> Running {
    let server = Server::bind(Some(0)).expect("a port").with_times(times);
    let (port, url) = (server.port(), server.url());
    let token = url.strip_prefix(&format!("http://127.0.0.1:{port}/#")).expect("a token").to_owned();
    let (stage, stop) = (Arc::new(Fake::default()), Arc::new(AtomicBool::new(false)));
    let thread = {
        let (stage, stop) = (stage.clone(), stop.clone());
        thread::spawn(move || server.run(stage, idle, &stop))
    };
    Running { port, token, stage, stop, thread }
}

impl Running {
    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("a connection");
        stream.set_read_timeout(Some(LONG)).expect("a time");
        stream
    }

    /// Sends bytes, in which PORT and TOKEN are replaced; a server that has closed takes them no longer.
    pub(crate) fn send(&self, stream: &TcpStream, request: &[u8]) {
        let mut stream = stream;
        let _ = stream.write_all(&self.fill(request));
    }

    /// Sends bytes on a new connection; returns the bytes that come back until it is closed.
    pub(crate) fn ask(&self, request: &[u8]) -> Vec<u8> {
        let stream = self.connect();
        self.send(&stream, request);
        rest(&stream)
    }

    fn fill(&self, request: &[u8]) -> Vec<u8> {
        let words = [("PORT", self.port.to_string()), ("TOKEN", self.token.clone())];
        words.iter().fold(request.to_vec(), |bytes, (name, value)| {
            let (mut filled, mut at) = (Vec::new(), 0);
            while at < bytes.len() {
                if bytes[at..].starts_with(name.as_bytes()) {
                    filled.extend_from_slice(value.as_bytes());
                    at += name.len();
                } else {
                    filled.push(bytes[at]);
                    at += 1;
                }
            }
            filled
        })
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Stops the server; how long that took.
    pub(crate) fn stop(self) -> Duration {
        let begun = Instant::now();
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().expect("no panic").expect("no error");
        begun.elapsed()
    }
}

/// Everything until the connection is closed.
pub(crate) fn rest(stream: &TcpStream) -> Vec<u8> {
    let (mut all, mut stream) = (Vec::new(), stream);
    match stream.read_to_end(&mut all) {
        Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
            panic!("it stays open")
        }
        _ => all,
    }
}

/// The next answer of a connection that stays open: its head and its body.
pub(crate) fn answer(stream: &TcpStream) -> (String, Vec<u8>) {
    let (mut head, mut byte, mut stream) = (Vec::new(), [0], stream);
    while !head.ends_with(b"\r\n\r\n") && stream.read(&mut byte).expect("read") == 1 {
        head.push(byte[0]);
    }
    let head = String::from_utf8(head).expect("a head in ASCII");
    let length = head.lines().find_map(|line| line.strip_prefix("Content-Length: ")?.parse().ok()).unwrap_or(0);
    let mut body = vec![0; length];
    stream.read_exact(&mut body).expect("a body");
    (head, body)
}

/// The statuses of the answers that are in these bytes, or `closed`.
pub(crate) fn statuses(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let all: Vec<_> = text.split("HTTP/1.1 ").skip(1).filter_map(|answer| answer.get(..3)).collect();
    if all.is_empty() { "closed".to_owned() } else { all.join(" ") }
}

/// No more will be sent.
pub(crate) fn half_close(stream: &TcpStream) {
    stream.shutdown(Shutdown::Write).expect("half closed");
}

/// A request that can be changed.
#[derive(Clone)]
pub(crate) struct Request {
    line: String,
    headers: Vec<(String, String)>,
    body: Vec<u8>,
}

/// A question as the page asks it.
pub(crate) fn post(name: &str, body: impl Into<Vec<u8>>) -> Request {
    let body = body.into();
    let length = body.len().to_string();
    let headers = [
        ("Host", "127.0.0.1:PORT"),
        ("Origin", "http://127.0.0.1:PORT"),
        ("Sec-Fetch-Site", "same-origin"),
        ("Authorization", "Bearer TOKEN"),
        ("Connection", "close"),
        ("Content-Length", &length),
    ];
    let headers = headers.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec();
    Request { line: format!("POST /{name} HTTP/1.1"), headers, body }
}

/// A request for a file as a browser's address line makes it.
pub(crate) fn get(path: &str) -> Request {
    let request = post("", "").line(&format!("GET {path} HTTP/1.1")).set("Sec-Fetch-Site", "none");
    request.without("Origin").without("Authorization").without("Content-Length")
}

impl Request {
    pub(crate) fn line(self, line: &str) -> Self {
        Self { line: line.into(), ..self }
    }

    pub(crate) fn without(mut self, name: &str) -> Self {
        self.headers.retain(|header| header.0 != name);
        self
    }

    pub(crate) fn add(mut self, name: &str, value: &str) -> Self {
        self.headers.push((name.into(), value.into()));
        self
    }

    pub(crate) fn set(self, name: &str, value: &str) -> Self {
        self.without(name).add(name, value)
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let headers: String = self.headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
        [format!("{}\r\n{headers}\r\n", self.line).as_bytes(), &self.body].concat()
    }
}
