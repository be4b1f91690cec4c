//! The page of `halfline view` and its server. The crate knows HTTP, its security and the messages; it reads no scene and
//! renders nothing: who starts the server gives it a [`Stage`], which answers.

pub mod stage;

pub use stage::{
    Answer, Commands, FrameRequest, GoOn, Lens, Mode, PickRequest, Picture, Pixels, Pose, Refusal, SelectRequest, Stage,
};

use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// The port that is tried first where none is given.
pub const PORT: u16 = 8642;

/// A server that listens on 127.0.0.1 and waits for [`run`](Self::run).
pub struct Server {
    listener: TcpListener,
    token: String,
}

impl Server {
    /// Binds a port of 127.0.0.1: the given one, or else [`PORT`], and a free one if that is taken. Port 0 is a free one.
    pub fn bind(port: Option<u16>) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port.unwrap_or(PORT)))?;
        Ok(Self { listener, token: String::new() })
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.listener.local_addr().map_or(0, |address| address.port())
    }

    /// The address of the page, with the token in its fragment, which browsers do not send.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port(), self.token)
    }

    /// Serves until `stop` is set, or until there was no request for as long as `idle`.
    pub fn run(self, _stage: Arc<dyn Stage>, _idle: Option<Duration>, _stop: &AtomicBool) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// Opens the page in a browser where there is a display; returns whether one was started.
pub fn open_browser(_url: &str) -> bool {
    false
}

/// The command for the user's own machine that makes the port reachable there, if this is an SSH session.
pub fn ssh_line(_port: u16) -> Option<String> {
    None
}

/// The page's module for a notebook widget.
pub fn widget_module() -> String {
    String::new()
}
