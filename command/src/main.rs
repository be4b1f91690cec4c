//! The command `halfline`: runs, prints at most one error, exits with its code.

use std::env;
use std::process::ExitCode;

fn main() -> ExitCode {
    silence_device_select();
    halfline_command::command(env::args_os()).into()
}

/// A layer of Mesa chooses the device of the desktop, and without one prints an error that is none. The Python package has the
/// same rule.
fn silence_device_select() {
    let desktop = ["XDG_RUNTIME_DIR", "DISPLAY", "MESA_VK_DEVICE_SELECT", "NODEVICE_SELECT"];
    if desktop.iter().all(|name| env::var_os(name).is_none()) {
        #[expect(unsafe_code, reason = "the layer is switched off by a variable alone")]
        // SAFETY: no other thread runs yet.
        unsafe {
            env::set_var("NODEVICE_SELECT", "1");
        }
    }
}
