#![doc = include_str!("../README.md")]

mod exchange;
mod guard;
mod http;
mod jpeg;
mod open;
mod page;
mod queue;
mod reply;
mod routes;
mod server;
mod slots;
pub mod stage;
mod timed;

pub use open::{open_browser, ssh_line};
pub use page::{figure_script, style, widget_module, worker_script};
pub use reply::Reply;
pub use routes::Routes;
pub use server::{PORT, Server, Times};
pub use stage::{
    Answer, Commands, FrameRequest, GoOn, Lens, LensName, Mode, NamedLens, Options, PickRequest, Picture, Pixels, Pose,
    Refusal, SceneRequest, SelectRequest, Stage,
};

/// The bytes that the server sends back to a connection that sends these bytes; for tests and the fuzzer.
#[doc(hidden)]
pub fn converse(reader: impl std::io::Read, token: &str, routes: &Routes) -> Vec<u8> {
    let mut answers = Vec::new();
    exchange::converse(reader, &mut answers, (routes, token, &routes::always()), &|_| true);
    answers
}
