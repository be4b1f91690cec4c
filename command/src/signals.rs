//! Signals: the first request to terminate lets the work end in order within [`GRACE`], the second ends the process at
//! once.

#[cfg(unix)]
use halfline::Error;
use halfline::progress::Watch;
#[cfg(not(target_arch = "wasm32"))]
use signal_hook::consts::{SIGINT, SIGTERM};
#[cfg(not(target_arch = "wasm32"))]
use signal_hook::flag::{register, register_conditional_shutdown};
use std::sync::atomic::{AtomicBool, Ordering};
#[cfg(unix)]
use std::{io, io::Read, os::unix::net::UnixStream, thread, time::Duration};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// The signals that request termination.
#[cfg(unix)]
const ENDS: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
#[cfg(windows)]
const ENDS: [i32; 2] = [SIGINT, SIGTERM];

/// The time that the work may take to end, because passes over many millions of spheres do not check for requests.
/// Unfinished files have no name yet, so the process can end at any time.
#[cfg(unix)]
const GRACE: Duration = Duration::from_millis(500);

/// Installs the handlers. Where the system refuses, its default action ends the process, which is acceptable. Other
/// signals keep their default action, which a user may want (such as a core file by ctrl-\).
pub(super) fn listen() {
    #[cfg(not(target_arch = "wasm32"))]
    for signal in ENDS {
        // The order matters: the shutdown checks the flag before the first signal sets it.
        let _ = register_conditional_shutdown(signal, 130, &INTERRUPTED);
        let _ = register(signal, &INTERRUPTED);
    }
    // The default action of SIGXFSZ ends the process in the middle of a write beyond `ulimit -f`. With any handler the
    // write fails, and the failure is reported like a full disk.
    #[cfg(unix)]
    {
        static BEYOND_FILE_SIZE: AtomicBool = AtomicBool::new(false);
        let _ = register(signal_hook::consts::SIGXFSZ, &BEYOND_FILE_SIZE);
        // Without this thread the work still ends, but later.
        let _ = end_after_grace();
    }
}

/// Starts a thread that waits for the first request and ends the process after [`GRACE`].
#[cfg(unix)]
fn end_after_grace() -> io::Result<()> {
    let (mut requests, request) = UnixStream::pair()?;
    for signal in ENDS {
        signal_hook::low_level::pipe::register(signal, request.try_clone()?)?;
    }
    let wait = move || {
        if requests.read_exact(&mut [0]).is_ok() {
            thread::sleep(GRACE);
            // If standard error or output is a full pipe, the message blocks this thread and not the process.
            if thread::Builder::new().spawn(|| super::failure::fail(&Error::Interrupted)).is_ok() {
                thread::sleep(GRACE / 10);
            }
            signal_hook::low_level::exit(130);
        }
    };
    thread::Builder::new().name("signals".into()).stack_size(1 << 16).spawn(wait).map(drop)
}

/// Ends work when termination is requested.
pub(super) fn watch() -> Watch {
    Watch::default().while_true(go_on)
}

/// Whether no termination was requested.
pub(super) fn go_on() -> bool {
    !INTERRUPTED.load(Ordering::SeqCst)
}
