//! Requests to the server of `halfline view`.

use super::check::{Allowed, PER_BYTE, Pieces, allowed, check_words};
use halfline_viewer::{
    Answer, Commands, FrameRequest, GoOn, Lens, Mode, PickRequest, Picture, Pixels, Pose, Refusal, Reply, Routes,
    SceneRequest, SelectRequest, Stage, converse,
};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// The token of the server, which the seeds have.
const TOKEN: &str = "0123456789abcdef0123456789abcdef";

/// A stage that checks and counts the requests.
#[derive(Default)]
struct Checking(AtomicUsize);

impl Checking {
    fn check(&self, Pose { eye, at, up, lens }: &Pose) {
        self.0.fetch_add(1, Ordering::Relaxed);
        // The numbers of a named lens are checked with the options that it becomes.
        let wide = match lens {
            Lens::Vfov(wide) | Lens::Height(wide) => Some(wide),
            Lens::Named(_) => None,
        };
        assert!([*eye, *at, *up].as_flattened().iter().chain(wide).all(|number| number.is_finite()));
    }

    fn frame(&self, request: &FrameRequest) {
        self.check(&request.camera);
        let written = serde_json::to_vec(request).expect("written");
        assert_eq!(serde_json::from_slice::<FrameRequest>(&written).expect("read again"), *request);
    }
}

impl Stage for Checking {
    fn scene(&self, _: &SceneRequest) -> Answer<Value> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Ok(json!({}))
    }

    fn frame(&self, request: &FrameRequest, go_on: &GoOn) -> Answer<Option<Picture>> {
        self.frame(request);
        assert!(go_on(), "nothing newer can come");
        let pixels = match request.mode {
            Mode::Move | Mode::Part => Pixels::Rgb { size: [9, 2], levels: vec![77; 54] },
            Mode::Still => Pixels::Png(Vec::new()),
            Mode::Svg => Pixels::Svg(Vec::new()),
            Mode::Pdf => Pixels::Pdf(Vec::new()),
        };
        Ok(Some(Picture { pixels, info: json!({ "seq": request.seq, "adapter": request.options.get("look") }) }))
    }

    fn pick(&self, request: &PickRequest) -> Answer<Value> {
        self.check(&request.camera);
        Ok(Value::Null)
    }

    fn select(&self, request: &SelectRequest) -> Answer<Value> {
        self.0.fetch_add(1, Ordering::Relaxed);
        let expr = request.expr.as_deref().unwrap_or_default();
        Err(Refusal::settings(format!("{} characters", expr.chars().count())))
    }

    fn fit(&self, request: &FrameRequest) -> Answer<Value> {
        Ok(json!({ "camera": request.camera }))
    }

    fn command(&self, request: &FrameRequest) -> Answer<Commands> {
        self.frame(request);
        Ok(Commands { shell: request.select.clone(), python: String::new() })
    }

    fn progress(&self, _: Duration) -> Answer<Value> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Ok(json!({}))
    }
}

fn contains(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|window| window == word)
}

/// The input as all that comes through a connection, and as the body of each question.
pub(super) fn requests(data: &[u8]) -> Allowed {
    let stage = Arc::new(Checking::default());
    let routes = Arc::new(Routes::new(stage.clone()));
    let answers = converse(data, TOKEN, &routes);
    assert_eq!(converse(Pieces::new(data), TOKEN, &routes), answers, "in pieces");
    assert!(answers.is_empty() || answers.starts_with(b"HTTP/1.1 "));
    assert!(!contains(&answers, b"Access-Control") && !contains(&answers, b"HTTP/1.1 500"));
    let is_reached = stage.0.load(Ordering::Relaxed) > 0;
    let lower = data.to_ascii_lowercase();
    let needed = [&b"host:"[..], b"authorization:", b"content-length:"];
    let is_shown = contains(data, TOKEN.as_bytes()) && needed.iter().all(|name| contains(&lower, name));
    assert!(is_shown || !is_reached, "a request without the token reached the stage");
    for name in ["scene", "frame", "pick", "select", "command", "progress"] {
        let Reply { status, halfline, body, .. } = routes.take(name, data)();
        assert!([200, 400].contains(&status), "{name}: {status}");
        assert!(halfline.is_none_or(|text| text.bytes().all(|c| (b' '..0x7f).contains(&c))), "a header in ASCII");
        if status == 400 {
            let error: Value = serde_json::from_slice(&body).expect("JSON");
            check_words(error["error"]["message"].as_str().expect("a message"));
        }
    }
    allowed(data.len(), PER_BYTE)
}
