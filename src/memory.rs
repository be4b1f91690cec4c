//! Memory: what certainly cannot be had is refused before the work, where the system would promise it and later end
//! the process; and what was had is kept from frame to frame.

use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::plan::Kernel;
use std::any::Any;
use std::sync::Mutex;

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

/// Vectors of earlier frames, to be written again: having the system hand out and clear the same pages for every frame
/// takes a third of a frame's time.
#[derive(Debug, Default)]
pub(crate) struct Pool(Mutex<Vec<Spare>>);

#[derive(Debug)]
struct Spare {
    /// A `Vec` of some type.
    vector: Box<dyn Any + Send>,
    /// Frames since it was last of use.
    age: u32,
}

/// Frames after which nobody is expected to ask again.
const STALE: u32 = 2;

impl Pool {
    /// A vector with room for `n`, and whatever an earlier frame left in it: who takes it writes all of it.
    pub(crate) fn take<T: Send + 'static>(&self, n: usize) -> Vec<T> {
        let mut spares = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let room = |spare: &Spare| spare.vector.downcast_ref::<Vec<T>>().map(Vec::capacity).filter(|c| *c >= n);
        let fits = spares.iter().enumerate().filter_map(|(place, spare)| Some((room(spare)?, place)));
        let Some((_, place)) = fits.min() else { return Vec::new() };
        spares.swap_remove(place).vector.downcast().map_or_else(|_| Vec::new(), |vector| *vector)
    }

    /// A vector of `n` values, all of which the caller writes; new ones are zeros.
    ///
    /// # Errors
    /// [`Error::Limits`] when the memory cannot be had.
    pub(crate) fn values<T: Send + Clone + Default + 'static>(&self, n: usize) -> Result<Vec<T>> {
        let mut vector = self.take(n);
        vector.truncate(n);
        vector.try_reserve_exact(n - vector.len()).map_err(|_| Error::Limits {
            problem: format!("{} bytes for one buffer of the frame cannot be had", n.saturating_mul(size_of::<T>())),
            mend: "render a smaller --size or fewer buffers".into(),
        })?;
        vector.resize(n, T::default());
        Ok(vector)
    }

    /// Keeps a vector for a later frame.
    pub(crate) fn give<T: Send + 'static>(&self, vector: Vec<T>) {
        if vector.capacity() > 0 {
            let mut spares = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            spares.push(Spare { vector: Box::new(vector), age: 0 });
        }
    }

    /// A frame begins: what was of no use for some frames is let go.
    pub(crate) fn turn(&self) {
        let mut spares = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        spares.retain_mut(|spare| {
            spare.age += 1;
            spare.age <= STALE
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Plan, Settings};

    #[test]
    fn vectors_come_back_and_are_let_go() {
        let pool = Pool::default();
        pool.give(vec![7u32; 100]);
        pool.give(vec![7.0f32; 100]);
        assert_eq!(pool.take::<f64>(1), [0.0; 0], "none of that type");
        assert_eq!(pool.take::<u32>(101), [0; 0], "none as large");
        assert_eq!(pool.values::<u32>(100).expect("room"), [7; 100], "as it was left");
        assert_eq!(pool.values::<u32>(3).expect("room"), [0; 3], "taken already");
        (0..=STALE).for_each(|_| pool.turn());
        assert_eq!(pool.take::<f32>(1), [0.0; 0], "nobody asked for frames");
    }

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
