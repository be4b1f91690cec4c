//! The program in a page: the scene that the page has, a renderer, and the answers to the page's questions. It is the code of
//! `halfline view`, with WebGPU as the device where the browser has it.

#![expect(deprecated, reason = "suspension is experimental in wasm-bindgen")]

mod selftest;

use halfline::camera::{self, Camera};
use halfline::frame::{Aov, Data};
use halfline::render::Renderer;
use halfline::settings::{Accuracy, Backend, Settings};
use halfline_command::shown::{Content, MemoryScene, in_page, stage};
use halfline_viewer::{FrameRequest, Lens, Pose, Reply, Routes};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;
use wasm_bindgen::prelude::*;
use web_time::Instant;

static ROUTES: OnceLock<Arc<Routes>> = OnceLock::new();

/// Whether a graphics device was opened.
static IS_GPU: OnceLock<bool> = OnceLock::new();

/// Work that answers a question.
type Work = Box<dyn FnOnce() -> Reply>;

thread_local! {
    /// The questions that are taken and not answered, by their tickets, and the last ticket.
    static TAKEN: RefCell<(HashMap<u32, Work>, u32)> = RefCell::default();
}

#[wasm_bindgen]
extern "C" {
    /// Lets the page's other work go on for a moment.
    #[wasm_bindgen(suspending)]
    fn pause();
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn log(text: &str);
}

/// The answer to a question.
#[wasm_bindgen(getter_with_clone)]
pub struct Answer {
    /// The status of HTTP.
    pub status: u16,
    /// The kind of content.
    pub content_type: String,
    /// The JSON about a picture.
    pub info: String,
    /// The content.
    pub body: Vec<u8>,
}

/// Begins with the content of the page, on a backend: auto, gpu or cpu. The error says what is wrong.
#[wasm_bindgen(jspi)]
pub fn start(content: Vec<u8>, backend: String) -> Result<(), JsError> {
    std::panic::set_hook(Box::new(|info| log(&info.to_string())));
    let content =
        Content::unpack(&content).ok_or_else(|| JsError::new("the page is damaged: its content is incomplete"))?;
    let (renderer, backend) = renderer(&backend)?;
    let _ = IS_GPU.set(renderer.is_gpu());
    let renderer = Arc::new(Mutex::new(Some(renderer)));
    let memory = MemoryScene { content, renderer, backend, words: in_page };
    let routes = Routes::within_page(stage(memory)?, pauses);
    ROUTES.set(Arc::new(routes)).map_err(|_| JsError::new("the program runs already"))
}

/// The report of the self-test on a backend, as JSON.
#[wasm_bindgen(jspi)]
pub fn selftest(backend: String) -> Result<String, JsError> {
    Ok(selftest::report(backend.parse()?)?.to_string())
}

fn renderer(backend: &str) -> Result<(Renderer, Backend), JsError> {
    let backend: Backend = backend.parse()?;
    Ok((Renderer::new(&Settings { backend, ..Settings::default() })?, backend))
}

/// The time between two pauses of a picture.
const TURN: Duration = Duration::from_millis(30);

/// Lets questions arrive while a picture is made, so that a newer one ends it.
fn pauses() {
    thread_local! {
        static LAST: Cell<Option<Instant>> = const { Cell::new(None) };
    }
    if LAST.get().is_none_or(|last| last.elapsed() >= TURN) {
        pause();
        LAST.set(Some(Instant::now()));
    }
}

/// Takes a question by its name, with its body in JSON; returns the ticket for [`answer`].
#[wasm_bindgen]
pub fn take(name: &str, body: &str) -> Option<u32> {
    let work: Work = Box::new(ROUTES.get()?.take(name, body.as_bytes()));
    Some(TAKEN.with_borrow_mut(|(taken, last)| {
        *last = last.wrapping_add(1);
        taken.insert(*last, work);
        *last
    }))
}

/// Whether a graphics device renders; processors render parts of a still next to each other.
#[wasm_bindgen]
pub fn is_gpu() -> bool {
    IS_GPU.get() == Some(&true)
}

/// Gives up frames with smaller numbers.
#[wasm_bindgen]
pub fn supersede(seq: f64) {
    ROUTES.get().into_iter().for_each(|routes| routes.supersede(seq as u64));
}

/// The answer to the question of a ticket.
#[wasm_bindgen(jspi)]
pub fn answer(ticket: u32) -> Option<Answer> {
    let work = TAKEN.with_borrow_mut(|(taken, _)| taken.remove(&ticket))?;
    let Reply { status, content_type, halfline, body } = work();
    Some(Answer {
        status,
        content_type: content_type.into(),
        info: halfline.unwrap_or_default(),
        body: body.into_owned(),
    })
}

/// The buffers of a view of the content's first frame, for scripts: the ids as i32, the depths as f64 and the certainty as u8 of all
/// pixels, one list after the other; about them the report. `request` is a request for a frame.
#[wasm_bindgen(jspi)]
pub fn buffers(content: Vec<u8>, request: String, backend: String) -> Result<Answer, JsError> {
    let content =
        Content::unpack(&content).ok_or_else(|| JsError::new("the page is damaged: its content is incomplete"))?;
    let request: FrameRequest = serde_json::from_str(&request)?;
    let Pose { eye, at, up, lens } = request.camera;
    let [width, height] = request.size;
    let lens = match lens {
        Lens::Vfov(degrees) => camera::Lens::Vfov { degrees, distance: 1.0 },
        Lens::Height(height) => camera::Lens::Orthographic { height },
        Lens::Named(_) => return Err(JsError::new("buffers are those of a camera with vfov or height")),
    };
    let mut scene = content.frames.into_iter().next().ok_or_else(|| JsError::new("there is no frame"))?.scene;
    scene.camera = Camera { eye: eye.into(), look: camera::Look::At(at.into()), up: up.into(), lens };
    (scene.image.width, scene.image.height) = (width, height);
    let aovs = vec![Aov::Id, Aov::Depth, Aov::Certainty];
    let settings = Settings { backend: backend.parse()?, accuracy: Accuracy::Certified, aovs, ..Settings::default() };
    let frame = Renderer::new(&settings)?.render(&scene, &settings)?;
    let mut bytes = Vec::new();
    for aov in [Aov::Id, Aov::Depth, Aov::Certainty] {
        match frame.get(aov).map(|buffer| &buffer.data) {
            Some(Data::I32(values)) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
            Some(Data::F64(values)) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
            Some(Data::U8(values)) => bytes.extend(values),
            _ => return Err(JsError::new("a buffer is missing")),
        }
    }
    Ok(Answer { status: 200, content_type: String::new(), info: serde_json::to_string(&frame.report)?, body: bytes })
}
