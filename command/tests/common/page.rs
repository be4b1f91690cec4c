//! A page of `halfline view` as a program: the process, and questions over HTTP.

use crate::test_dir::TestDir;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

/// A running `halfline view`, which is killed at the end.
pub(crate) struct Page {
    child: Child,
    port: u16,
    token: String,
}

/// An answer: its status, the header X-Halfline, and its body.
pub(crate) struct Reply {
    pub(crate) status: u16,
    pub(crate) info: Value,
    pub(crate) body: Vec<u8>,
}

impl Reply {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or(Value::Null)
    }
}

impl Page {
    /// Starts it in the folder with these arguments, on a free port.
    pub(crate) fn open(dir: &TestDir, arguments: &str) -> Self {
        Self::of(dir.command(&format!("view {arguments} --port 0 --no-open")))
    }

    /// Starts this command, which has a free port.
    pub(crate) fn of(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("halfline runs");
        let mut url = String::new();
        BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut url).expect("a line");
        let (address, token) = url.trim().split_once("/#").unwrap_or_else(|| panic!("{command:?}: {url}"));
        let port = address.strip_prefix("http://127.0.0.1:").and_then(|port| port.parse().ok()).expect(&url);
        Self { child, port, token: token.to_owned() }
    }

    pub(crate) fn port(&self) -> u16 {
        self.port
    }

    pub(crate) fn process(&mut self) -> &mut Child {
        &mut self.child
    }

    /// The answer to a question.
    pub(crate) fn ask(&self, route: &str, body: &Value) -> Reply {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("a connection");
        let (body, token, port) = (body.to_string(), &self.token, self.port);
        let head = format!(
            "POST {route} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nAuthorization: Bearer {token}\r\nContent-Length: {}\r\n\
             Connection: close\r\n\r\n",
            body.len()
        );
        stream.write_all((head + &body).as_bytes()).expect("a request");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8(answer[..end].to_vec()).expect("UTF-8");
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
        let of_info = |line: &str| line.to_ascii_lowercase().starts_with("x-halfline:");
        let info = head.lines().find(|line| of_info(line)).and_then(|line| line.split_once(':'));
        let info = info.map_or(Value::Null, |(_, text)| serde_json::from_str(text).expect("JSON"));
        Reply { status, info, body: answer[end + 4..].to_vec() }
    }

    /// The JSON of a good answer.
    pub(crate) fn good(&self, route: &str, body: &Value) -> Value {
        let reply = self.ask(route, body);
        assert_eq!(reply.status, 200, "{route} {body}: {}", String::from_utf8_lossy(&reply.body));
        reply.json()
    }

    /// The bytes of a still picture, and the words of the command that renders it.
    pub(crate) fn still(&self, body: &Value) -> (Vec<u8>, Vec<String>) {
        let reply = self.ask("/frame", body);
        assert_eq!(reply.status, 200, "{body}: {}", String::from_utf8_lossy(&reply.body));
        let shell = self.good("/command", body)["shell"].as_str().expect("a command").to_owned();
        let printed = Command::new("sh").arg("-c").arg(format!("printf '%s\\n' {shell}")).output();
        let words = String::from_utf8(printed.expect("a shell").stdout).expect("UTF-8");
        (reply.body, words.lines().skip(1).map(str::to_owned).collect())
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A camera of the page, moved: turned about the point looked at by `turn` radians and `nearer` by a factor.
pub(crate) fn moved(camera: &Value, turn: f64, nearer: f64) -> Value {
    let of = |name: &str| [0, 1, 2].map(|k| camera[name][k].as_f64().expect("a number"));
    let ([ex, ey, ez], [ax, ay, az]) = (of("eye"), of("at"));
    let [x, y, z] = [ex - ax, ey - ay, ez - az].map(|x| x * nearer);
    let (sine, cosine) = turn.sin_cos();
    let mut moved = camera.clone();
    moved["eye"] = json!([ax + cosine * x + sine * z, ay + y, az - sine * x + cosine * z]);
    moved
}

/// Stills from ten cameras, perspective and orthographic, with looks, samples and selections: each has the bytes of the file
/// that its command writes.
pub(crate) fn check_stills(dir: &TestDir, arguments: &str, selection: Option<&str>) {
    let page = Page::open(dir, arguments);
    let scene = page.good("/scene", &json!({}));
    for n in 0..10_u32 {
        let mut camera = moved(&scene["camera"], 0.7 * f64::from(n), 1.0 - 0.06 * f64::from(n));
        if n % 3 == 2 {
            let object = camera.as_object_mut().expect("a camera");
            object.remove("vfov");
            object.insert("height".into(), json!(scene["radius"].as_f64().expect("a radius") * 2.0));
        }
        let mut body = json!({ "seq": n, "camera": camera, "size": [241 + n, 187], "mode": "still" });
        match n % 4 {
            1 => body["options"] = json!({ "look": ["plain"] }),
            2 => body["options"] = json!({ "samples": ["9"] }),
            3 => body["select"] = json!(selection),
            _ => {}
        }
        if scene["frames"] != 1 {
            body["frame"] = json!(1 + n % 3);
        }
        let (still, words) = page.still(&body);
        dir.good(&words);
        let output = words.last().expect("a file");
        assert!(still == dir.get(output), "{arguments}: {words:?}");
        dir.remove(output);
    }
}
