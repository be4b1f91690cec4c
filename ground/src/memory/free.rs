//! Free memory, and how many spheres fit in it.

use super::Pool;

/// Bytes that can still be allocated, including the bytes of `pool`: within the machine's memory and swap, the limit of the
/// control group and the address space of the process. `None` where the system does not report them. With debug assertions,
/// HALFLINE_FREE=N makes it at most N, so that tests need not fill the memory.
pub fn free(pool: &Pool) -> Option<u64> {
    let given = std::env::var("HALFLINE_FREE").ok().filter(|_| cfg!(debug_assertions));
    let given = given.and_then(|bytes| bytes.parse().ok());
    let least = [machine(), group(), addresses(), given].into_iter().flatten().min()?;
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

/// The bytes left below the limit of the control group (version 1 or 2), where inactive cache of files counts as free;
/// `None` without a limit.
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

/// The bytes of address space left below `ulimit -v`; `None` without a limit.
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
