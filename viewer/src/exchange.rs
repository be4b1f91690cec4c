//! The requests of one connection and their answers, in turn.

use crate::guard::admit;
use crate::http::{Input, Refused, Trouble, refused};
use crate::reply::Reply;
use crate::routes::{Route, Routes};
use crate::stage::GoOn;
use std::io::{Read, Write};

/// The answer while as many requests are answered as may be.
pub(crate) const BUSY: Refused = Refused { status: 503, message: "8 other requests are being answered" };

/// The state of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// It waits for a request.
    Idle,
    /// A request has begun to arrive.
    Reading,
    /// It has shown the token, and the stage answers.
    Working,
    /// The answer of so many bytes is written.
    Writing(usize),
}

/// Answers the requests of a connection until it ends, or until `goes_on` says in a phase that it must. `is_read` says whether someone
/// waits for the answer that is made.
pub(crate) fn converse(
    reader: impl Read,
    mut writer: impl Write,
    (routes, token, is_read): (&Routes, &str, &GoOn),
    goes_on: &dyn Fn(Phase) -> bool,
) {
    let mut input = Input::new(reader);
    while goes_on(Phase::Idle) && input.wait() && goes_on(Phase::Reading) {
        let (reply, keeps_alive): (Reply, bool) = match request(&mut input, token) {
            Ok((Route::File(file), _, keeps_alive)) => (file, keeps_alive),
            Ok((Route::Ask(question), body, keeps_alive)) if goes_on(Phase::Working) => {
                (routes.ask(question, &body, is_read), keeps_alive)
            }
            Ok((Route::Ask(..), ..)) => (BUSY.into(), false),
            // What else is in the connection is not read as a request.
            Err(Trouble::Refused(refused)) => (refused.into(), false),
            _ => return,
        };
        let goes_on = goes_on(Phase::Writing(reply.body.len()));
        if !goes_on || reply.write(&mut writer, keeps_alive).is_err() || !keeps_alive {
            return;
        }
    }
}

/// The next request that may be answered: its route, its body, and whether another may follow. The body is read only then.
fn request<R: Read>(input: &mut Input<R>, token: &str) -> Result<(Route, Vec<u8>, bool), Trouble> {
    let head = input.head()?;
    let route = admit(&head, token)?;
    let length = match (&route, head.length()?) {
        (_, Some(length)) => length,
        (Route::File(_), None) => 0,
        (Route::Ask(_), None) => return Ok(refused(411, "a body is sent with Content-Length")?),
    };
    if matches!(route, Route::File(_)) && length > 0 {
        return Ok(refused(400, "a request for a file has no body")?);
    }
    Ok((route, input.body(length)?, head.keeps_alive()))
}
