//! Free memory, and how many spheres fit in it.

use super::Pool;
use super::room::GRAIN;
use crate::error::{Error, Result};

/// Bytes of a sphere in a scene: centre and radius, without a colour.
pub(crate) const SPHERE: u64 = 32;
const COLOR: u64 = 12;

/// Refuses a scene of `spheres` spheres before they are read.
///
/// # Errors
/// [`Error::Limits`] with the number that would fit.
pub(crate) fn check_spheres(spheres: u64, colored: bool) -> Result<()> {
    check_spheres_in(spheres, colored, || free(&Pool::default()))
}

fn check_spheres_in(spheres: u64, colored: bool, free: impl Fn() -> Option<u64>) -> Result<()> {
    let each = SPHERE + if colored { COLOR } else { 0 };
    let need = spheres.saturating_mul(each);
    if need < GRAIN {
        return Ok(());
    }
    match free() {
        Some(free) if need > free => Err(Error::Limits {
            problem: format!("{spheres} spheres need {need} bytes of memory, but only {free} are free"),
            mend: format!("read at most {} spheres", free / each),
        }),
        _ => Ok(()),
    }
}

/// Bytes that can still be allocated, including those of `pool`: within the machine's memory and swap, the limit of the
/// control group and the address space of the process. `None` where the system does not report them.
pub(crate) fn free(pool: &Pool) -> Option<u64> {
    let least = [machine(), group(), addresses()].into_iter().flatten().min()?;
    Some(least.saturating_add(pool.kept()))
}

fn read(path: &str) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// The first number after `name` in text with lines such as `MemTotal:  23 kB`.
fn number(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().next()?.parse().ok())
}

/// Memory that programs can allocate without the system ending others.
fn machine() -> Option<u64> {
    let text = read("/proc/meminfo")?;
    let kib = number(&text, "MemAvailable:")? + number(&text, "SwapFree:").unwrap_or(0);
    Some(kib << 10)
}

/// What the limit of the control group (version 1 or 2) leaves; the cache of files counts as free.
fn group() -> Option<u64> {
    let left = |limit: &str, used: &str, stat: &str, files: &str| {
        let of = |path: &str| read(&format!("/sys/fs/cgroup/{path}"))?.trim().parse::<u64>().ok();
        let cached = read(&format!("/sys/fs/cgroup/{stat}")).and_then(|text| number(&text, files));
        Some(of(limit)?.saturating_sub(of(used)?.saturating_sub(cached.unwrap_or(0))))
    };
    left("memory.max", "memory.current", "memory.stat", "inactive_file ").or_else(|| {
        let [limit, used] = ["memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes"];
        left(limit, used, "memory/memory.stat", "total_inactive_file ")
    })
}

/// What `ulimit -v` leaves.
fn addresses() -> Option<u64> {
    let most = number(&read("/proc/self/limits")?, "Max address space ")?;
    let used = number(&read("/proc/self/status")?, "VmSize:")? << 10;
    Some(most.saturating_sub(used))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GIB: u64 = 1 << 30;

    #[test]
    fn a_file_of_too_many_spheres_is_refused_with_the_number_that_fits() {
        let check_spheres_in = |spheres, colored, free| check_spheres_in(spheres, colored, || free);
        assert!(check_spheres_in(1000, true, Some(0)).is_ok(), "fewer than the system is asked about");
        let million = 1_000_000;
        assert!(check_spheres_in(million, true, Some(44_000_000)).is_ok());
        assert!(check_spheres_in(u64::MAX, true, None).is_ok());
        let error = check_spheres_in(million, true, Some(43_999_999)).expect_err("a byte too few").to_string();
        assert!(error.contains("at most 999999 "), "{error}");
        assert!(check_spheres_in(u64::MAX, false, Some(u64::MAX - 1)).is_err(), "no overflow");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn free_memory_is_read_on_linux_and_pooled_memory_counts() {
        let pool = Pool::default();
        assert!(free(&pool).is_some_and(|bytes| bytes > 1 << 20));
        // Nothing is written, so the system has not committed any page.
        pool.put_back(Vec::<u64>::with_capacity(1 << 27));
        assert!(pool.kept() >= GIB && free(&pool).is_some_and(|bytes| bytes >= pool.kept()));
    }

    #[test]
    fn numbers_are_found_behind_their_keys() {
        let text = "MemTotal: 7 kB\nMemAvailable:   42 kB\nMax address space         unlimited\n";
        assert_eq!(number(text, "MemAvailable:"), Some(42));
        assert_eq!((number(text, "SwapFree:"), number(text, "Max address space ")), (None, None));
    }
}
