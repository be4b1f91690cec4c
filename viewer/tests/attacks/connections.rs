//! Connections: many, slow, half closed; and the end.

use crate::client::{CALM, Running, answer, get, half_close, post, rest, start, statuses};
use crate::stage::LONG;
use halfline_viewer::{Server, Times};
use std::collections::VecDeque;
use std::io::Write;
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// A request whose answer takes until the stage is released.
fn hanging_request() -> Vec<u8> {
    post("select", r#"{"expr":"hang"}"#).without("Connection").bytes()
}

/// The page asks; how long the answer takes, which is a few milliseconds on a machine without other load.
fn owner(server: &Running) -> Duration {
    let begun = Instant::now();
    assert_eq!(statuses(&server.ask(&post("scene", "{}").bytes())), "200");
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
    begun.elapsed()
}

/// Sends a byte after the other until the server closes; what came.
fn drip(server: &Running, request: &[u8]) -> String {
    let stream = server.connect();
    stream.set_nodelay(true).expect("set");
    let begun = Instant::now();
    for byte in request {
        server.send(&stream, &[*byte]);
        thread::sleep(Duration::from_millis(20));
        let mut peeked = [0];
        stream.set_nonblocking(true).expect("set");
        let is_answered = stream.peek(&mut peeked).is_ok();
        stream.set_nonblocking(false).expect("set");
        if is_answered {
            break;
        }
    }
    let found = statuses(&rest(&stream));
    println!("{} bytes, one after the other: {found} after {:.1?}", request.len(), begun.elapsed());
    found
}

#[test]
fn slow_requests_end() {
    let server = start(Times { request: Duration::from_millis(500), idle: LONG }, None);
    assert_eq!(drip(&server, &get("/").add("A", &"b".repeat(2000)).bytes()), "408");
    let body = post("scene", " ".repeat(2000));
    let head = body.bytes().len() - 2000;
    let stream = server.connect();
    server.send(&stream, &body.bytes()[..head + 10]);
    assert_eq!(statuses(&rest(&stream)), "408", "a length that is not reached");
    owner(&server);
    server.stop();
    let server = start(Times { request: LONG, idle: Duration::from_millis(300) }, None);
    assert_eq!(statuses(&server.ask(b"")), "closed", "a connection without a request");
    server.stop();
}

#[test]
fn connections_half_close() {
    let server = start(CALM, None);
    let of = |request: &[u8]| {
        let stream = server.connect();
        server.send(&stream, request);
        half_close(&stream);
        statuses(&rest(&stream))
    };
    let whole = post("scene", "{}").without("Connection").bytes();
    assert_eq!(of(&whole), "200", "a whole request");
    assert_eq!(of(&whole[..whole.len() - 1]), "closed", "a body without its end");
    assert_eq!(of(&whole[..40]), "closed", "a head without its end");
    assert_eq!(of(b""), "closed");
    server.stop();
}

#[test]
fn requests_in_a_row_are_answered_in_a_row() {
    let server = start(CALM, None);
    let keeps = post("scene", "{}").without("Connection").bytes();
    let all =
        [&keeps[..], &get("/view.css").without("Connection").bytes(), &keeps, &post("scene", "{}").bytes()].concat();
    assert_eq!(statuses(&server.ask(&all)), "200 200 200 200");
    let evil = post("scene", "{}").set("Host", "evil.com").without("Connection").bytes();
    assert_eq!(statuses(&server.ask(&[&keeps[..], &evil, &keeps].concat())), "200 403", "nothing behind it is read");
    let old = post("scene", "{}").line("POST /scene HTTP/1.0").without("Connection").bytes();
    assert_eq!(statuses(&server.ask(&[&old[..], &keeps].concat())), "200", "HTTP/1.0 closes");
    server.stop();
}

/// As many connections as the system lets one process have, at most 1,000.
fn crowd(server: &Running, request: &[u8]) -> Vec<TcpStream> {
    let connect = |n: usize| {
        if n.is_multiple_of(100) {
            // The system lets 128 wait, and others try again after a second.
            thread::sleep(Duration::from_millis(50));
        }
        TcpStream::connect(("127.0.0.1", server.port)).ok()
    };
    let mut all: Vec<_> = (0..1000).map_while(connect).collect();
    all.iter().for_each(|stream| server.send(stream, request));
    if all.len() < 1000 {
        // The server needs some too.
        all.truncate(all.len().saturating_sub(50));
    }
    all
}

#[test]
fn a_crowd_does_not_keep_the_owner_out() {
    let server = start(CALM, None);
    let kept = server.connect();
    server.send(&kept, &post("scene", "{}").without("Connection").bytes());
    assert_eq!(statuses(answer(&kept).0.as_bytes()), "200");
    let idle = crowd(&server, b"");
    println!("{} connections idle: the owner is answered in {:.1?}", idle.len(), owner(&server));
    // Strangers are closed before the owner's connection.
    server.send(&kept, &post("scene", "{}").bytes());
    assert_eq!(statuses(&rest(&kept)), "200");
    drop(idle);
    let slow = crowd(&server, b"POST /scene HTTP/1.1\r\n");
    let time = owner(&server);
    println!("{} connections with a part of a request: the owner is answered in {time:.1?}", slow.len());
    server.stop();
}

/// Strangers come all the time, each with a request that does not end.
#[test]
fn strangers_that_come_and_stay_do_not_keep_the_owner_out() {
    let server = start(CALM, None);
    let (port, is_over) = (server.port, AtomicBool::new(false));
    thread::scope(|scope| {
        for _ in 0..6 {
            scope.spawn(|| {
                let mut all = VecDeque::new();
                while !is_over.load(Ordering::Relaxed) {
                    let stream = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
                    // It may have been closed for another one.
                    let _ = (&stream).write_all(b"POST /scene HTTP/1.1\r\nHost: 127.0.0.1\r\n");
                    all.push_back(stream);
                    all.drain(..all.len().saturating_sub(10));
                    thread::sleep(Duration::from_millis(5));
                }
            });
        }
        thread::sleep(Duration::from_millis(300));
        let answers: Vec<String> = (0..40).map(|_| statuses(&server.ask(&post("scene", "{}").bytes()))).collect();
        is_over.store(true, Ordering::Relaxed);
        assert!(answers.iter().all(|answer| answer == "200"), "{answers:?}");
    });
    server.stop();
}

#[test]
fn the_ninth_request_at_a_time_is_refused() {
    let server = start(CALM, None);
    let all: Vec<_> = (0..8).map(|_| server.connect()).collect();
    all.iter().for_each(|stream| server.send(stream, &hanging_request()));
    server.stage.wait_for(8);
    assert_eq!(statuses(&server.ask(&post("scene", "{}").bytes())), "503");
    assert_eq!(statuses(&server.ask(&get("/").bytes())), "503");
    assert_eq!(statuses(&server.ask(b"")), "503", "at once");
    server.stage.release();
    all.iter().for_each(|stream| assert_eq!(statuses(answer(stream).0.as_bytes()), "200"));
    // They wait for another request now, and the one that has waited longest makes place.
    owner(&server);
    server.stop();
}

#[test]
fn the_server_ends_when_it_should() {
    // While the stage is at work, and a connection is open.
    let server = start(CALM, None);
    let (busy, open) = (server.connect(), server.connect());
    server.send(&busy, &hanging_request());
    server.stage.wait_for(1);
    server.send(&open, &post("scene", "{}").without("Connection").bytes());
    assert_eq!(statuses(answer(&open).0.as_bytes()), "200");
    let (port, stage) = (server.port, server.stage.clone());
    let time = server.stop();
    println!("the server with a busy stage ends in {time:.1?}");
    assert!(time < Duration::from_secs(3), "{time:?}");
    assert!(TcpStream::connect(("127.0.0.1", port)).is_err(), "the port is free");
    assert_eq!(statuses(&rest(&open)), "closed");
    stage.release();
    // What can be given up is.
    let server = start(CALM, None);
    let still = server.connect();
    let camera = r#"{"eye":[0,0,5],"at":[0,0,0],"up":[0,1,0],"height":4}"#;
    let body = format!(r#"{{"camera":{camera},"size":[4,4],"options":{{"look":["hold"]}}}}"#);
    server.send(&still, &post("frame", body).bytes());
    server.stage.wait_for(1);
    let stage = server.stage.clone();
    server.stop();
    let begun = Instant::now();
    while Arc::strong_count(&stage) > 1 {
        assert!(begun.elapsed() < LONG / 2, "the frame is not given up");
        thread::sleep(Duration::from_millis(5));
    }
    // No request comes. Connections without a token do not count as use, and work does.
    let server = start(CALM, Some(Duration::from_millis(600)));
    let (busy, _open) = (server.connect(), server.connect());
    server.send(&busy, &hanging_request());
    server.stage.wait_for(1);
    thread::sleep(Duration::from_millis(1000));
    assert!(!server.has_ended(), "it is at work");
    server.stage.release();
    let begun = Instant::now();
    while !server.has_ended() {
        assert!(begun.elapsed() < LONG, "it does not end");
        if let Ok(stream) = TcpStream::connect(("127.0.0.1", server.port)) {
            server.send(&stream, &get("/").set("Host", "evil.com").bytes());
        }
        thread::sleep(Duration::from_millis(100));
    }
    server.stop();
}

#[test]
fn ports_are_taken_as_requested() {
    let first = Server::bind(None).expect("a port");
    let second = Server::bind(None).expect("another port");
    assert_ne!(first.port(), second.port());
    assert!(Server::bind(Some(first.port())).is_err(), "it is taken");
    assert_ne!(Server::bind(Some(0)).expect("a free port").port(), 0);
    let token = |server: &Server| server.url().split_once("/#").expect("a token").1.to_owned();
    assert!(token(&first).len() == 32 && token(&first).bytes().all(|c| c.is_ascii_hexdigit()));
    assert_ne!(token(&first), token(&second));
}
