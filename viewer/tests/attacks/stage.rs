//! A stage without a scene.

use halfline_viewer::{
    Answer, Commands, FrameRequest, GoOn, PickRequest, Picture, Pixels, Refusal, SceneRequest, SelectRequest, Stage,
};
use serde_json::{Value, json};
use std::sync::{Condvar, Mutex};
use std::time::{Duration, Instant};

/// More time than anything here takes, so that a test that hangs ends.
pub(crate) const LONG: Duration = Duration::from_secs(20);

/// It does what the look of a frame says: `panic`, `hold` until it is released or no longer wanted, `hang` until it is
/// released. A selection `hang` does that too.
#[derive(Default)]
pub(crate) struct Fake {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    calls: usize,
    /// The number of calls that have begun to be held.
    waiting: usize,
    is_released: bool,
}

impl Fake {
    /// The number of calls so far, except calls of `fit`.
    pub(crate) fn calls(&self) -> usize {
        self.state.lock().expect("state").calls
    }

    /// Waits until so many calls have begun to be held.
    pub(crate) fn wait_for(&self, count: usize) {
        let state = self.state.lock().expect("state");
        let (state, _) = self.changed.wait_timeout_while(state, LONG, |state| state.waiting < count).expect("state");
        assert!(state.waiting >= count, "{} calls are held", state.waiting);
    }

    pub(crate) fn release(&self) {
        self.state.lock().expect("state").is_released = true;
        self.changed.notify_all();
    }

    fn call(&self) {
        self.state.lock().expect("state").calls += 1;
    }

    /// Whether it was released, rather than given up.
    fn hold(&self, go_on: &dyn Fn() -> bool) -> bool {
        let mut state = self.state.lock().expect("state");
        state.waiting += 1;
        self.changed.notify_all();
        let begun = Instant::now();
        while !state.is_released && go_on() && begun.elapsed() < LONG {
            state = self.changed.wait_timeout(state, Duration::from_millis(5)).expect("state").0;
        }
        state.is_released
    }
}

impl Stage for Fake {
    fn scene(&self, _: &SceneRequest) -> Answer<Value> {
        self.call();
        Ok(json!({ "schema": 1 }))
    }

    fn frame(&self, request: &FrameRequest, go_on: &GoOn) -> Answer<Option<Picture>> {
        self.call();
        let size @ [width, height] = request.size;
        if width == 0 || height == 0 || width > 10_000 || height > 10_000 {
            return Err(Refusal { kind: "limits", message: "this size cannot be rendered".into(), exit: 5 });
        }
        let is_done = match request.options.get("look").map(|looks| looks[0].as_str()) {
            Some("panic") => panic!("as the test wants"),
            Some("hold") => self.hold(&**go_on),
            Some("hang") => self.hold(&|| true),
            _ => true,
        };
        let info = json!({ "seq": request.seq, "adapter": "µ" });
        let pixels = match request.mode {
            halfline_viewer::Mode::Move | halfline_viewer::Mode::Part => {
                Pixels::Rgb { size, levels: vec![127; 3 * (width * height) as usize] }
            }
            halfline_viewer::Mode::Still => Pixels::Png(b"\x89PNG".to_vec()),
            halfline_viewer::Mode::Svg => Pixels::Svg(b"<svg/>".to_vec()),
            halfline_viewer::Mode::Pdf => Pixels::Pdf(b"%PDF".to_vec()),
        };
        Ok(is_done.then_some(Picture { pixels, info }))
    }

    fn pick(&self, request: &PickRequest) -> Answer<Value> {
        self.call();
        Ok(json!({ "id": request.x, "from": request.from }))
    }

    fn select(&self, SelectRequest { expr, frame, .. }: &SelectRequest) -> Answer<Value> {
        self.call();
        let expr = expr.as_deref().unwrap_or("all");
        if expr == "hang" {
            self.hold(&|| true);
        }
        if expr.is_empty() { Err(Refusal::settings("empty")) } else { Ok(json!({ "count": expr.len(), "of": frame })) }
    }

    fn fit(&self, request: &FrameRequest) -> Answer<Value> {
        Ok(json!({ "camera": request.camera }))
    }

    fn command(&self, request: &FrameRequest) -> Answer<Commands> {
        self.call();
        Ok(Commands {
            shell: Some(format!("halfline render {:?}", request.camera.eye)),
            python: "import halfline".into(),
        })
    }

    fn progress(&self, wait: Duration) -> Answer<Value> {
        self.call();
        Ok(json!({ "state": "ready", "text": format!("{wait:?}") }))
    }
}
