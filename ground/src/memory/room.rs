//! Capacity for what is read: a reader's list never grows beyond the free memory. Where the system does not report its
//! free memory, a failed allocation is still returned as an error and does not end the process.

use super::{Pool, free};
use crate::error::{Error, Result};

/// Smaller requests are not checked: the reserve covers many of them, and asking the system is slow.
pub(super) const GRAIN: u64 = 1 << 20;

/// Bytes that stay free beside every list: for blocks of text, their parsed form, and threads.
const RESERVE: u64 = 32 << 20;

/// The capacity, in entries of `each` bytes, for a list of `len` of `what` that receives `more`: twice the current
/// length, so that growing is cheap, or an eighth more where memory is short.
///
/// # Errors
/// [`Error::Limits`] with the number of entries that would fit.
pub fn entries(len: usize, more: usize, each: usize, what: &str) -> Result<usize> {
    entries_in(len, more, each, what, || free(&Pool::default()))
}

fn entries_in(len: usize, more: usize, each: usize, what: &str, free: impl Fn() -> Option<u64>) -> Result<usize> {
    let least = len.saturating_add(more);
    let need = |entries: usize| ((entries - len) as u64).saturating_mul(each as u64);
    let doubled = least.max(len.saturating_mul(2)).max(64);
    if need(doubled) < GRAIN {
        return Ok(doubled);
    }
    let Some(free) = free() else { return Ok(doubled) };
    let usable = free.saturating_sub(RESERVE);
    let some = least.max(len.saturating_add(len / 8));
    [doubled, some].into_iter().find(|entries| need(*entries) <= usable).ok_or_else(|| {
        let fit = len as u64 + usable / each.max(1) as u64;
        let problem = format!(
            "{least} {what} or more need {} bytes of memory besides the first {len}, but only {usable} are free for them",
            need(some)
        );
        Error::Limits { problem, mend: at_most(fit, what) }
    })
}

/// The mend where memory is short: the number of `what` that fits, or more memory where nothing fits.
fn at_most(fit: u64, what: &str) -> String {
    let memory = "end other programs, or use a machine with more memory";
    if fit == 0 { memory.into() } else { format!("read at most {fit} {what}, {memory}") }
}

/// Whether 32-bit ids can number this many spheres.
pub fn ids_fit(spheres: u64) -> bool {
    spheres <= i32::MAX as u64
}

/// Refuses more spheres than 32-bit ids can number, of a scene in memory.
///
/// # Errors
/// [`Error::Limits`] with both numbers.
pub fn check_ids(spheres: u64) -> Result<()> {
    if ids_fit(spheres) {
        return Ok(());
    }
    let problem = format!("{spheres} spheres are more than 32-bit ids can number");
    Err(Error::Limits { problem, mend: format!("use at most {} spheres", i32::MAX) })
}

/// Refuses more spheres than 64-bit ids can number.
///
/// # Errors
/// [`Error::Limits`] with both numbers.
pub fn check_wide_ids(spheres: u64) -> Result<()> {
    const MAX_SPHERES: u64 = i64::MAX as u64;
    if spheres <= MAX_SPHERES {
        return Ok(());
    }
    let problem = format!("{spheres} spheres or more are more than 64-bit ids can number");
    Err(Error::Limits { problem, mend: format!("use at most {MAX_SPHERES} spheres") })
}

/// Reserves capacity for `more` entries, as [`entries`] computes it.
///
/// # Errors
/// [`Error::Limits`].
pub fn reserve<T>(list: &mut Vec<T>, more: usize) -> Result<()> {
    if list.capacity() - list.len() >= more {
        return Ok(());
    }
    let entries = entries(list.len(), more, size_of::<T>(), if size_of::<T>() == 1 { "bytes" } else { "numbers" })?;
    extend_to(list, entries)
}

/// Grows the capacity of a list to `entries` in all.
///
/// # Errors
/// [`Error::Limits`] where the allocation fails.
pub fn extend_to<T>(list: &mut Vec<T>, entries: usize) -> Result<()> {
    list.try_reserve_exact(entries.saturating_sub(list.len())).map_err(|_| Error::Limits {
        problem: format!("{} bytes of memory could not be allocated", entries.saturating_mul(size_of::<T>())),
        mend: "read a smaller scene".into(),
    })
}

/// Bytes of a sphere in a scene: centre and radius, without a colour.
pub const SPHERE: u64 = 32;
const COLOR: u64 = 12;

/// Refuses a scene of `spheres` spheres before they are read.
///
/// # Errors
/// [`Error::Limits`] with the number that would fit.
pub fn check_spheres(spheres: u64, colored: bool) -> Result<()> {
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
            mend: at_most(free / each, "spheres"),
        }),
        _ => Ok(()),
    }
}

/// Refuses `bytes` for `what`, which begins the message, where they are not free.
///
/// # Errors
/// [`Error::Limits`] with both numbers.
pub fn check(bytes: u64, what: impl FnOnce() -> String) -> Result<()> {
    if bytes < GRAIN {
        return Ok(());
    }
    match free(&Pool::default()).map(|free| free.saturating_sub(RESERVE)) {
        Some(usable) if bytes > usable => Err(Error::Limits {
            problem: format!("{} may need {bytes} bytes of memory, but only {usable} are free for them", what()),
            mend: "read a smaller file, or on a machine with more memory".into(),
        }),
        _ => Ok(()),
    }
}

/// Counts the bytes that a reader keeps in many small pieces: names, texts, maps of them.
#[derive(Debug, Clone, Default)]
pub struct Ledger {
    bytes: u64,
    /// The bytes for which free memory was checked.
    checked: u64,
}

impl Ledger {
    /// Counts `bytes` more. A growing map holds its old and its new table for a moment, so twice the kept bytes must be
    /// free.
    ///
    /// # Errors
    /// [`Error::Limits`].
    pub fn add(&mut self, bytes: usize) -> Result<()> {
        self.bytes = self.bytes.saturating_add(bytes as u64);
        if self.bytes > self.checked.max(GRAIN) {
            let next = self.bytes.saturating_add(GRAIN);
            check(next.saturating_mul(2), || "the names and texts of the file".into())?;
            self.checked = next;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_too_many_spheres_is_refused_with_the_number_that_fits() {
        let check_spheres_in = |spheres, colored, free| check_spheres_in(spheres, colored, || free);
        assert!(check_spheres_in(1000, true, Some(0)).is_ok(), "too few for a query of the system");
        let million = 1_000_000;
        assert!(check_spheres_in(million, true, Some(44_000_000)).is_ok());
        assert!(check_spheres_in(u64::MAX, true, None).is_ok());
        let error = check_spheres_in(million, true, Some(43_999_999)).expect_err("a byte too few").to_string();
        assert!(error.contains("at most 999999 "), "{error}");
        let error = check_spheres_in(million, true, Some(43)).expect_err("no sphere fits").to_string();
        assert!(!error.contains("at most") && error.contains("more memory"), "{error}");
        assert!(check_spheres_in(u64::MAX, false, Some(u64::MAX - 1)).is_err(), "no overflow");
    }

    #[test]
    fn lists_double_while_there_is_room_and_then_grow_by_an_eighth() {
        let with = |free: u64| move || Some(RESERVE + free);
        let million = 1_000_000;
        assert_eq!(entries_in(0, 1, 44, "spheres", || Some(0)).expect("little"), 64);
        assert_eq!(entries_in(million, 1, 40, "spheres", with(40_000_000)).expect("twice"), 2 * million);
        assert_eq!(entries_in(million, 1, 40, "spheres", with(39_999_999)).expect("an eighth"), million + million / 8);
        assert_eq!(entries_in(million, 500_000, 40, "spheres", with(20_000_000)).expect("just enough"), 1_500_000);
        assert_eq!(entries_in(million, 1, 40, "spheres", || None).expect("unknown"), 2 * million);
        let error = entries_in(million, 1, 40, "spheres", with(4_999_960)).expect_err("a byte too few");
        assert!(matches!(error, Error::Limits { .. }) && error.to_string().contains("at most 1124999 "), "{error}");
        // A message with less needed than free would contradict itself.
        assert!(error.to_string().contains("but only 4999960 are free"), "{error}");
        assert!(
            entries_in(usize::MAX, usize::MAX, 40, "spheres", with(0)).is_ok(),
            "nothing more fits, and nothing overflows"
        );
        assert!(entries_in(10, usize::MAX, usize::MAX, "spheres", with(0)).is_err());
    }

    #[test]
    fn a_memory_budget_refuses_what_no_machine_has() {
        let mut ledger = Ledger::default();
        assert!(ledger.add(1000).is_ok());
        assert!(cfg!(not(target_os = "linux")) || matches!(ledger.add(usize::MAX / 4), Err(Error::Limits { .. })));
        let mut list = vec![1u64];
        assert!(matches!(extend_to(&mut list, usize::MAX), Err(Error::Limits { .. })));
        reserve(&mut list, 100).expect("little");
        assert!(list.capacity() > 100);
    }
}
