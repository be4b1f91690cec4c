//! Messages, and which frames are rendered.

use crate::client::{CALM, answer, post, rest, start, statuses};
use crate::stage::Fake;
use halfline_viewer::{FrameRequest, Lens, Reply, Routes};
use serde_json::Value;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

const CAMERA: &str = r#"{"eye":[0,0,5],"at":[0,0,0],"up":[0,1,0],"vfov":40}"#;

/// The body of a question for a frame, with more members.
fn frame(more: &str) -> String {
    format!(r#"{{"camera":{CAMERA},"size":[16,8]{more}}}"#)
}

#[test]
fn messages_are_read_or_refused() {
    let routes = Arc::new(Routes::new(Arc::new(Fake::default())));
    let camera = |camera: &str| frame("").replace(CAMERA, camera);
    let number = |number: &str| frame("").replace("[0,0,5]", &format!("[0,0,{number}]"));
    let size = |size: &str| frame("").replace("[16,8]", size);
    let options: Vec<String> = (0..10_000).map(|n| format!(r#""{n}":[""]"#)).collect();
    let deep = format!(r#","x":{}"#, "[".repeat(10_000));
    let rows: Vec<(&str, Vec<u8>, u16, &str)> = [
        ("a frame", frame(""), 200, ""),
        ("unknown members", frame(r#","new":{"a":[1]}"#), 200, ""),
        ("null for what may be left out", frame(r#","frame":null,"select":null"#), 200, ""),
        ("options", frame(r#","options":{"clip":["1,0,0,2","0,1,0,3"],"map":[]}"#), 200, ""),
        ("options in no object", frame(r#","options":[["clip","1,0,0,2"]]"#), 400, "settings"),
        ("an option that is no list", frame(r#","options":{"clip":"1,0,0,2"}"#), 400, "settings"),
        ("an option's number", frame(r#","options":{"samples":[4]}"#), 400, "settings"),
        ("an option's null", frame(r#","options":{"look":[null]}"#), 400, "settings"),
        ("an option in itself", frame(r#","options":{"clip":[["1,0,0,2"]]}"#), 400, "settings"),
        ("10,000 options", frame(&format!(r#","options":{{{}}}"#, options.join(","))), 200, ""),
        ("the greatest seq", frame(r#","seq":18446744073709551615"#), 200, ""),
        ("NaN", number("NaN"), 400, "settings"),
        ("Infinity", number("Infinity"), 400, "settings"),
        ("1e999", number("1e999"), 400, "settings"),
        ("-1e999", number("-1e999"), 400, "settings"),
        ("a number as a string", number("\"5\""), 400, "settings"),
        ("null as a number", number("null"), 400, "settings"),
        ("two numbers for an eye", camera(CAMERA.replace("[0,0,5]", "[0,5]").as_str()), 400, "settings"),
        ("vfov and height", camera(CAMERA.replace("40", "40,\"height\":2").as_str()), 400, "settings"),
        ("neither", camera(CAMERA.replace(",\"vfov\":40", "").as_str()), 400, "settings"),
        ("an eye twice", camera(CAMERA.replace("\"at\"", "\"eye\":[0,0,0],\"at\"").as_str()), 400, "settings"),
        ("no camera", r#"{"size":[1,1]}"#.into(), 400, "settings"),
        ("size 0", size("[0,8]"), 400, "limits"),
        ("size 1e9", size("[1000000000,1000000000]"), 400, "limits"),
        ("size 2^32", size("[4294967296,8]"), 400, "settings"),
        ("size -1", size("[-1,8]"), 400, "settings"),
        ("size 1.5", size("[1.5,8]"), 400, "settings"),
        ("size 1e400", size("[1e400,8]"), 400, "settings"),
        ("seq -1", frame(r#","seq":-1"#), 400, "settings"),
        ("seq 2^64", frame(r#","seq":18446744073709551616"#), 400, "settings"),
        ("another mode", frame(r#","mode":"fast""#), 400, "settings"),
        ("a list", "[]".into(), 400, "settings"),
        ("nothing", String::new(), 400, "settings"),
        ("10,000 lists in each other", frame(&deep), 400, "settings"),
        ("two objects", format!("{0}{0}", frame("")), 400, "settings"),
        ("a long word", frame(&format!(r#","mode":"{}""#, "\\u0007é".repeat(5000))), 400, "settings"),
    ]
    .map(|(name, body, status, kind)| (name, body.into_bytes(), status, kind))
    .into_iter()
    .chain([("not UTF-8", b"{\"camera\":\"\xff\"}".to_vec(), 400, "settings")])
    .collect();
    for (name, body, status, kind) in rows {
        let reply = routes.take("frame", &body)();
        let value: Option<Value> = serde_json::from_slice(&reply.body).ok();
        let found = value.as_ref().and_then(|value| value["error"]["kind"].as_str()).unwrap_or_default();
        println!("{name:<40} {} {found}", reply.status);
        assert_eq!((reply.status, found), (status, kind), "{name}");
        let message = value.as_ref().and_then(|value| value["error"]["message"].as_str()).unwrap_or_default();
        assert!(message.chars().count() < 400 && !message.chars().any(char::is_control), "{name}: {message}");
    }
    for (name, body, status) in [
        ("scene", "{}", 200),
        ("scene", "", 400),
        ("progress", "{}", 200),
        ("select", r#"{"expr":"a"}"#, 200),
        ("select", r#"{"expr":""}"#, 400),
        ("select", r#"{"expr":1}"#, 400),
        ("select", r#"{"options":{"color_by":["x"]}}"#, 200),
        ("select", r#"{"options":{"color_by":"x"}}"#, 400),
        ("command", &frame(""), 200),
        ("pick", &frame(r#","x":3,"y":4,"from":7"#), 200),
        ("pick", &frame(r#","x":3,"y":-4"#), 400),
        ("pick", &frame(""), 400),
        ("shell", "{}", 404),
        ("../scene", "{}", 404),
    ] {
        assert_eq!(routes.take(name, body.as_bytes())().status, status, "{name} {body}");
    }
}

#[test]
fn a_camera_survives_being_written() {
    let eye = [0.1, 1.0 / 3.0, 5e-324];
    let body = frame("").replace("[0,0,5]", &format!("{eye:?}"));
    let request: FrameRequest = serde_json::from_str(&body).expect("a request");
    assert_eq!((request.camera.eye, request.camera.lens), (eye, Lens::Vfov(40.0)));
    let written = serde_json::to_string(&request).expect("written");
    assert_eq!(serde_json::from_str::<FrameRequest>(&written).expect("read"), request, "{written}");
}

/// Asks for a frame, which a thread answers.
fn ask(routes: &Arc<Routes>, seq: u64, mode: &str, look: &str) -> thread::JoinHandle<Reply> {
    let body = frame(&format!(r#","seq":{seq},"mode":"{mode}","options":{{"look":["{look}"]}}"#));
    thread::spawn(routes.take("frame", body.as_bytes()))
}

#[test]
fn the_newest_frame_wins() {
    let stage = Arc::new(Fake::default());
    let routes = Arc::new(Routes::new(stage.clone()));
    let status = |reply: thread::JoinHandle<Reply>| reply.join().expect("no panic").status;
    // A move that has begun is finished; of those that wait, the newest is rendered.
    let first = ask(&routes, 1, "move", "hold");
    stage.wait_for(1);
    let second = ask(&routes, 2, "move", "");
    let third = ask(&routes, 3, "move", "");
    assert_eq!(status(second), 204, "it returns while the first is rendered");
    assert!(!first.is_finished() && !third.is_finished());
    stage.release();
    let first = first.join().expect("no panic");
    assert_eq!((first.status, first.content_type), (200, "image/jpeg"));
    assert_eq!(first.halfline.as_deref(), Some(r#"{"adapter":"\u00b5","seq":1}"#));
    assert_eq!(status(third), 200);
    // A still is also given up while it is rendered, and a failure is not the end.
    let stage = Arc::new(Fake::default());
    let routes = Arc::new(Routes::new(stage.clone()));
    let still = ask(&routes, 10, "still", "hold");
    stage.wait_for(1);
    let waiting = ask(&routes, 11, "still", "");
    let newest = ask(&routes, 12, "still", "panic");
    assert_eq!((status(still), status(newest)), (204, 500));
    assert!([200, 204].contains(&status(waiting)), "it may have had its turn before the newest arrived");
    let again = ask(&routes, 1, "still", "").join().expect("no panic");
    assert_eq!((again.status, again.content_type), (200, "image/png"));
    // At the end nothing is waited for.
    let still = ask(&routes, 2, "still", "hold");
    stage.wait_for(2);
    routes.close();
    assert_eq!(status(still), 204);
}

#[test]
fn a_panic_is_an_answer() {
    let server = start(CALM, None);
    let stream = server.connect();
    for (look, expected) in [("panic", "500"), ("", "200"), ("panic", "500"), ("", "200")] {
        let body = frame(&format!(r#","options":{{"look":["{look}"]}}"#));
        server.send(&stream, &post("frame", body).without("Connection").bytes());
        let (head, body) = answer(&stream);
        assert_eq!(statuses(head.as_bytes()), expected, "{head}");
        let text = String::from_utf8_lossy(&body);
        assert_eq!(text.contains(r#""exit":101,"kind":"internal""#), expected == "500", "{text}");
    }
    server.stop();
}

/// A picture whose client is gone is given up, so that what waits behind it is answered, although no number cancels it; nor is one rendered
/// whose client left while it waited. A client that stays gets its picture.
#[test]
fn a_picture_that_no_one_reads_is_given_up() {
    let server = start(CALM, None);
    let ask = |look: &str, mode: &str| {
        let stream = server.connect();
        let body = frame(&format!(r#","mode":"{mode}","options":{{"look":["{look}"]}}"#));
        server.send(&stream, &post("frame", body).bytes());
        stream
    };
    let gone = ask("hold", "still");
    server.stage.wait_for(1);
    let left = ["still", "move"].map(|mode| ask("hang", mode));
    let behind = ask("", "still");
    thread::sleep(Duration::from_millis(300));
    assert_eq!(server.stage.calls(), 1, "they wait for a picture that is read");
    drop(left);
    thread::sleep(Duration::from_millis(100));
    drop(gone);
    assert_eq!(statuses(&rest(&behind)), "200");
    assert_eq!(server.stage.calls(), 2, "only that which is read was rendered");
    let stays = ask("hold", "still");
    server.stage.wait_for(2);
    thread::sleep(Duration::from_millis(300));
    server.stage.release();
    assert_eq!(statuses(&rest(&stays)), "200");
    server.stop();
}
