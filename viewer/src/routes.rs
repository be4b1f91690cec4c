//! The questions of the page: JSON to [`Stage`], and its answers back.

use crate::http::{Refused, refused};
use crate::queue::{Queue, Ticket};
use crate::reply::Reply;
use crate::stage::{Answer, FrameRequest, GoOn, Mode, PickRequest, Pixels, Refusal, Stage};
use crate::{jpeg, page};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::any::Any;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The longest target.
const TARGET: usize = 1024;

/// The most characters of a message about JSON, which may quote it.
const MESSAGE: usize = 300;

/// The longest time for which a question for progress is held open.
const PROGRESS_WAIT: Duration = Duration::from_secs(20);

/// The target of a request.
#[derive(Debug)]
pub(crate) enum Route {
    /// A file of the page.
    File(Reply),
    Ask(Question),
}

/// A question of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Question {
    Scene,
    Frame,
    Pick,
    Select,
    Fit,
    Command,
    Progress,
}

impl Question {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "scene" => Self::Scene,
            "frame" => Self::Frame,
            "pick" => Self::Pick,
            "select" => Self::Select,
            "fit" => Self::Fit,
            "command" => Self::Command,
            "progress" => Self::Progress,
            _ => return None,
        })
    }
}

impl Route {
    pub(crate) fn of(method: &str, target: &str) -> Result<Self, Refused> {
        let Some(name) = target.strip_prefix('/') else { return refused(400, "the target is not a path") };
        if target.len() > TARGET {
            return refused(414, "the target has at most 1,024 bytes");
        }
        match (method, Question::of(name), page::file(target)) {
            ("POST", Some(question), _) => Ok(Self::Ask(question)),
            ("GET", _, Some(file)) => Ok(Self::File(file)),
            (_, None, None) => refused(404, "there is nothing at this path"),
            (_, Some(_), _) => refused(405, "this path is for POST"),
            _ => refused(405, "this path is for GET"),
        }
    }
}

/// Answers the questions of a page, over HTTP or otherwise.
pub struct Routes {
    stage: Arc<dyn Stage>,
    sends: Sends,
    queue: Arc<Queue>,
    is_closed: AtomicBool,
}

/// The form of pixels while the camera moves.
#[derive(Debug, Clone, Copy)]
enum Sends {
    Jpeg,
    /// Pixels as they are, to the same thread, which this call lets do other work.
    Rgba(fn()),
}

/// The body of a question without parameters.
#[derive(Deserialize)]
struct Nothing {}

impl Routes {
    /// Lets the stage answer a page to which there is a way.
    pub fn new(stage: Arc<dyn Stage>) -> Self {
        Self { stage, sends: Sends::Jpeg, queue: Arc::default(), is_closed: AtomicBool::new(false) }
    }

    /// Lets the stage answer a page in the same thread. Pixels of a moving camera are sent as `image/x-rgba`: red, green, blue and 255.
    /// `pause` is called often while a picture is made, so that newer questions can be taken.
    pub fn within_page(stage: Arc<dyn Stage>, pause: fn()) -> Self {
        Self { sends: Sends::Rgba(pause), ..Self::new(stage) }
    }

    /// Takes a question by its name, such as `frame`, and its body in JSON. What is returned answers it, in any thread.
    /// Frames come in the order in which they were asked for.
    pub fn take(self: &Arc<Self>, name: &str, body: &[u8]) -> impl FnOnce() -> Reply + Send + use<> {
        let (routes, question, body) = (Arc::clone(self), Question::of(name), body.to_vec());
        let frame = matches!(question, Some(Question::Frame)).then(|| self.arrive(&body));
        move || match (question, frame) {
            (_, Some(frame)) => reply(|| routes.frame(frame?, &always())),
            (Some(question), _) => routes.ask(question, &body, &always()),
            (None, _) => Refused { status: 404, message: "there is no such question" }.into(),
        }
    }

    /// Cancels the frame that is rendered, unless the camera moves, and those that wait; later requests for frames get an empty
    /// reply.
    pub fn close(&self) {
        self.is_closed.store(true, Ordering::Relaxed);
        self.queue.clear();
    }

    /// Gives up frames with smaller numbers than `seq`.
    pub fn supersede(&self, seq: u64) {
        drop(self.queue.arrive(seq));
    }

    /// The answer to a question. A panic of the stage is an answer too. A picture that no one reads is given up.
    pub(crate) fn ask(&self, question: Question, body: &[u8], is_read: &GoOn) -> Reply {
        reply(|| self.put(question, body, is_read))
    }

    fn put(&self, question: Question, body: &[u8], is_read: &GoOn) -> Answer<Reply> {
        match question {
            Question::Scene => self.stage.scene(&read(body)?).map(|value| Reply::json(&value)),
            Question::Fit => self.stage.fit(&read(body)?).map(|value| Reply::json(&value)),
            Question::Frame => self.frame(self.arrive(body)?, is_read),
            Question::Pick => self.stage.pick(&read::<PickRequest>(body)?).map(|value| Reply::json(&value)),
            Question::Select => self.stage.select(&read(body)?).map(|value| Reply::json(&value)),
            Question::Command => {
                let commands = self.stage.command(&read::<FrameRequest>(body)?)?;
                let value = serde_json::to_value(commands).map_err(|error| Refusal::internal(error.to_string()))?;
                Ok(Reply::json(&value))
            }
            Question::Progress => {
                read::<Nothing>(body).and_then(|_| self.stage.progress(PROGRESS_WAIT)).map(|value| Reply::json(&value))
            }
        }
    }

    /// A request for a frame arrives.
    fn arrive(&self, body: &[u8]) -> Answer<(FrameRequest, Ticket)> {
        let request: FrameRequest = read(body)?;
        let ticket = self.queue.arrive(request.seq);
        Ok((request, ticket))
    }

    fn frame(&self, (request, mut ticket): (FrameRequest, Ticket), is_read: &GoOn) -> Answer<Reply> {
        if self.is_closed.load(Ordering::Relaxed) || !ticket.wait() || !is_read() {
            return Ok(Reply::EMPTY);
        }
        // A move that has begun is finished: else a page that asks while it waits would see none.
        let go_on: GoOn = match (request.mode, self.sends) {
            (Mode::Move, _) => Arc::new(|| true),
            (_, Sends::Jpeg) => {
                let (go_on, is_read) = (ticket.go_on(), GoOn::clone(is_read));
                Arc::new(move || go_on() && is_read())
            }
            (_, Sends::Rgba(pause)) => {
                let go_on = ticket.go_on();
                Arc::new(move || {
                    pause();
                    go_on()
                })
            }
        };
        let Some(picture) = self.stage.frame(&request, &go_on)? else { return Ok(Reply::EMPTY) };
        // The next frame is rendered while this one is encoded.
        drop(ticket);
        let reply = match picture.pixels {
            Pixels::Rgb { size, levels } => match self.sends {
                Sends::Jpeg => Reply::new("image/jpeg", jpeg::encode(size, &levels)?),
                Sends::Rgba(_) => {
                    let rgba = |rgb: &[u8]| [rgb[0], rgb[1], rgb[2], 255];
                    Reply::new("image/x-rgba", levels.chunks_exact(3).flat_map(rgba).collect::<Vec<u8>>())
                }
            },
            Pixels::Png(bytes) => Reply::new("image/png", bytes),
            Pixels::Svg(bytes) => Reply::new("image/svg+xml", bytes),
            Pixels::Pdf(bytes) => Reply::new("application/pdf", bytes),
        };
        Ok(reply.with(picture.info))
    }
}

/// For answers that are always read.
pub(crate) fn always() -> GoOn {
    Arc::new(|| true)
}

/// The reply to a question. A panic is a reply too.
fn reply(answer: impl FnOnce() -> Answer<Reply>) -> Reply {
    match panic::catch_unwind(AssertUnwindSafe(answer)) {
        Ok(Ok(reply)) => reply,
        Ok(Err(refusal)) => Reply::refusal(400, &refusal),
        Err(payload) => Reply::refusal(500, &Refusal::internal(words(&*payload))),
    }
}

/// Parses the JSON body of a question; an error quotes at most [`MESSAGE`] characters.
fn read<T: DeserializeOwned>(body: &[u8]) -> Answer<T> {
    serde_json::from_slice(body).map_err(|error| {
        let words = error.to_string();
        let shown = words.chars().map(|c| if c.is_control() { ' ' } else { c }).take(MESSAGE);
        Refusal::settings(format!("the request is not valid: {}", shown.collect::<String>()))
    })
}

/// A message with the text of a panic.
fn words(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied().or(payload.downcast_ref::<String>().map(String::as_str));
    format!("the program failed: {}", text.unwrap_or("it does not say why"))
}
