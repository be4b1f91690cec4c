//! Ways for the user to reach the page: a browser on this machine, or a tunnel from the user's own machine.

use std::env;
use std::ffi::OsString;
use std::net::IpAddr;
use std::process::{Command, Stdio};
use std::thread;

/// Opens an address in the user's browser where there is a display; returns whether one was started. It does not wait for it.
pub fn open_browser(url: &str) -> bool {
    let is_set = |name: &str| env::var_os(name).is_some_and(|value| !value.is_empty());
    let Some(mut command) = opener(env::consts::OS, is_set) else { return false };
    command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // Ctrl-C ends the server and not the browser.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let Ok(mut child) = command.spawn() else { return false };
    // A browser that ends is taken off the system's list.
    thread::Builder::new().spawn(move || child.wait()).is_ok()
}

/// The program that opens addresses, if the user sees its windows: not through SSH, where he has a browser of his own.
fn opener(system: &str, is_set: impl Fn(&str) -> bool) -> Option<Command> {
    if is_set("SSH_CONNECTION") {
        return None;
    }
    match system {
        "macos" => Some(Command::new("open")),
        "windows" => {
            // `start` takes a first argument in quotes as a title.
            let mut command = Command::new("cmd");
            command.args(["/C", "start", ""]);
            Some(command)
        }
        _ if is_set("DISPLAY") || is_set("WAYLAND_DISPLAY") => Some(Command::new("xdg-open")),
        _ => None,
    }
}

/// The command for the user's own machine that makes the port reachable there, if this is an SSH session.
pub fn ssh_line(port: u16) -> Option<String> {
    let text = |name: &str| env::var_os(name).map(OsString::into_string)?.ok();
    line(&text("SSH_CONNECTION")?, text("USER").or_else(|| text("LOGNAME")).as_deref(), port)
}

/// The command, from the addresses and ports of both sides. What is printed to be pasted has plain characters only.
fn line(connection: &str, user: Option<&str>, port: u16) -> Option<String> {
    let mut words = connection.split_whitespace().skip(2);
    let (host, door) = (words.next()?, words.next()?.parse::<u16>().ok()?);
    host.split('%').next()?.parse::<IpAddr>().ok()?;
    let is_plain = |text: &&str| {
        let first = text.bytes().next().is_some_and(|c| c.is_ascii_alphanumeric() || c == b'_');
        first && text.bytes().all(|c| c.is_ascii_alphanumeric() || b"._-:%".contains(&c))
    };
    let host = Some(host).filter(|host| host.starts_with(':') || is_plain(host))?;
    let host = user.filter(is_plain).map_or(host.to_owned(), |user| format!("{user}@{host}"));
    let door = if door == 22 { String::new() } else { format!("-p {door} ") };
    Some(format!("ssh -L {port}:127.0.0.1:{port} {door}{host}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tunnel_has_the_servers_address() {
        let of = |connection, user| line(connection, user, 8642);
        let here = "203.0.113.7 50000 198.51.100.2 22";
        assert_eq!(of(here, Some("ada")).as_deref(), Some("ssh -L 8642:127.0.0.1:8642 ada@198.51.100.2"));
        assert_eq!(of(here, None).as_deref(), Some("ssh -L 8642:127.0.0.1:8642 198.51.100.2"));
        let other = "2001:db8::1 50000 2001:db8::2 2222";
        assert_eq!(of(other, Some("a.b")).as_deref(), Some("ssh -L 8642:127.0.0.1:8642 -p 2222 a.b@2001:db8::2"));
        assert_eq!(of(here, Some("$(reboot)")).as_deref(), Some("ssh -L 8642:127.0.0.1:8642 198.51.100.2"));
        for bad in
            ["", "1.2.3.4 1", "1.2.3.4 1 5.6.7.8", "1.2.3.4 1 5.6.7.8 x", "1.2.3.4 1 -oProxyCommand=x 22", "a b c 22"]
        {
            assert_eq!(of(bad, Some("ada")), None, "{bad:?}");
        }
        assert_eq!(of("1.2.3.4 1 fe80::1%$(x) 22", None), None);
    }

    #[test]
    fn a_browser_needs_a_display() {
        let program = |system: &str, set: &[&str]| {
            opener(system, |name| set.contains(&name)).map(|command| command.get_program().to_owned())
        };
        assert_eq!(program("linux", &[]), None);
        assert_eq!(program("linux", &["DISPLAY"]).as_deref(), Some("xdg-open".as_ref()));
        assert_eq!(program("freebsd", &["WAYLAND_DISPLAY"]).as_deref(), Some("xdg-open".as_ref()));
        assert_eq!(program("linux", &["DISPLAY", "SSH_CONNECTION"]), None);
        assert_eq!(program("macos", &[]).as_deref(), Some("open".as_ref()));
        assert_eq!(program("windows", &[]).as_deref(), Some("cmd".as_ref()));
    }
}
