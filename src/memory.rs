//! Memory: what certainly cannot be had is refused before the work, where the system would promise it and later end
//! the process.

use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::plan::Kernel;

/// Refuses a frame whose buffers are together larger than all the memory there is.
///
/// # Errors
/// [`Error::Limits`] with both numbers.
pub(crate) fn check(kernel: &Kernel, aovs: &[Aov], pixels: u64) -> Result<()> {
    let need = pixels.saturating_mul(bytes_per_pixel(kernel, aovs));
    match total() {
        Some(total) if need > total => Err(Error::Limits {
            problem: format!("the frame's buffers need {need} bytes and this machine has {total}"),
            mend: "render a smaller --size or fewer buffers".into(),
        }),
        _ => Ok(()),
    }
}

/// What a frame holds at once: the kernel's own buffers and those made of them.
fn bytes_per_pixel(kernel: &Kernel, aovs: &[Aov]) -> u64 {
    let made = aovs.iter().map(|aov| match aov {
        // The kernel's own become the frame's.
        Aov::Color | Aov::Normal | Aov::Id => 0,
        Aov::Position => 24,
        Aov::Distance | Aov::Depth | Aov::Bound => 8,
        Aov::Mask | Aov::Certainty => 1,
    });
    let vectors = u64::from(kernel.normal) + u64::from(kernel.shade.is_some());
    let t = u64::from(kernel.t) * if kernel.is_wide() { 2 } else { 1 };
    4 + 4 * (t + u64::from(kernel.width)) + 12 * vectors + made.sum::<u64>()
}

/// Memory and swap of this machine, or what its control group allows, in bytes; `None` where the system does not tell.
fn total() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| {
        let of =
            |name: &str| text.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().next()?.parse().ok());
        let (memory, swap): (u64, u64) = (of("MemTotal:")?, of("SwapTotal:").unwrap_or(0));
        Some((memory + swap) << 10)
    });
    // Version 2 and version 1 of control groups.
    let group = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let group = group.iter().find_map(|path| read(path)?.trim().parse().ok());
    machine.into_iter().chain(group).min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Plan, Settings};

    #[test]
    fn only_what_cannot_be_had_is_refused() {
        let kernel = Plan::for_method(&Settings::default()).expect("a plan").kernel;
        assert!(check(&kernel, &Aov::ALL, 3840 * 2160).is_ok());
        if total().is_some() {
            assert!(matches!(check(&kernel, &[], u64::MAX / 2), Err(Error::Limits { .. })));
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn linux_tells_its_memory() {
        assert!(total().is_some_and(|bytes| bytes > 1 << 20));
    }
}
