//! One budget for the memory of loaded pictures and meshes and of the film, so that a file that declares too much data
//! is refused instead of ending the process.
//!
//! Readers reserve the most bytes that they will need before they allocate them. The reservation is kept beside the
//! data and released with it, so the pieces of a scene count together, and during a reload the old and the new data
//! both count. Small data (entities, text, the window) are not counted; the default budget leaves a part of the
//! machine's memory for them.

mod machine;
mod size;

use std::fmt;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};

pub use self::size::{Bytes, NoSize, parse_size};
use crate::files::{Access, FileError, LARGEST_DATA};

/// The environment variable with the budget, such as `8GB`.
pub const VARIABLE: &str = "SUNROOM_MEMORY";

const REMEDY: &str = "`--memory SIZE` or SUNROOM_MEMORY sets another budget";

/// A number of bytes that reservations share.
#[derive(Debug)]
pub struct Budget {
    limit: AtomicU64,
    reserved: AtomicU64,
    /// Whether the limit is from the command line or the variable, which override preferences.
    is_named: AtomicBool,
}

/// The budget of the process: `SUNROOM_MEMORY`, or else [`default_limit`].
pub fn budget() -> &'static Budget {
    static BUDGET: LazyLock<Budget> = LazyLock::new(|| {
        let budget = Budget::new(default_limit());
        if let Some(Ok(limit)) = budget_of_variable() {
            budget.name_limit(limit);
        }
        budget
    });
    &BUDGET
}

/// Three quarters of the memory that the process may use, in bytes.
pub fn default_limit() -> u64 {
    machine::memory_bytes() / 4 * 3
}

/// The bytes that `SUNROOM_MEMORY` names, or an error if it is malformed; None if it is not set.
pub fn budget_of_variable() -> Option<Result<u64, NoSize>> {
    let text = std::env::var_os(VARIABLE).filter(|text| !text.is_empty())?;
    Some(parse_size(&text.to_string_lossy()))
}

/// Reads a mesh or picture file. It may be at most as long as the budget, because it is in memory before the size of
/// its content is known.
pub fn read_data(path: &Path, access: &Access) -> Result<Vec<u8>, FileError> {
    data_result(budget().limit(), |limit| access.read(path, limit))
}

/// Checks whether [`read_data`] can read a file.
pub fn check_data(path: &Path, access: &Access) -> Result<(), FileError> {
    data_result(budget().limit(), |limit| access.check(path, limit))
}

/// Calls `act` with the largest allowed length of a file in bytes, and names the budget if that is the reason for an
/// error.
fn data_result<T>(budget: u64, act: impl FnOnce(u64) -> Result<T, FileError>) -> Result<T, FileError> {
    act(LARGEST_DATA.min(budget)).map_err(|error| match error {
        FileError::TooLarge { limit } if limit == budget => {
            let limit = Bytes(limit);
            FileError::OverBudget(format!("the memory budget of {limit}; {REMEDY}"))
        }
        other => other,
    })
}

/// Reserves from the budget of the process.
pub fn reserve(bytes: u64) -> Result<Reservation, Shortage> {
    budget().reserve(bytes)
}

impl Budget {
    /// A budget; `limit` is in bytes.
    pub const fn new(limit: u64) -> Self {
        Self {
            limit: AtomicU64::new(limit),
            reserved: AtomicU64::new(0),
            is_named: AtomicBool::new(false),
        }
    }

    /// Sets the limit in bytes that the user has given for this run. Existing reservations stay.
    pub fn name_limit(&self, limit: u64) {
        self.is_named.store(true, Ordering::Relaxed);
        self.limit.store(limit, Ordering::Relaxed);
    }

    /// Sets the limit in bytes from the preferences, unless one was given for this run.
    pub fn prefer_limit(&self, limit: u64) {
        if !self.is_named.load(Ordering::Relaxed) {
            self.limit.store(limit, Ordering::Relaxed);
        }
    }

    /// The limit in bytes.
    pub fn limit(&self) -> u64 {
        self.limit.load(Ordering::Relaxed)
    }

    /// The reserved bytes.
    pub fn reserved(&self) -> u64 {
        self.reserved.load(Ordering::Relaxed)
    }

    /// Takes `bytes` from the budget until the reservation is dropped.
    pub fn reserve(&'static self, bytes: u64) -> Result<Reservation, Shortage> {
        let mut reservation = Reservation { budget: self, bytes: 0 };
        reservation.resize(bytes)?;
        Ok(reservation)
    }
}

/// A part of a budget; dropping it gives the part back.
#[derive(Debug)]
pub struct Reservation {
    budget: &'static Budget,
    bytes: u64,
}

impl Reservation {
    /// The reserved bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Changes the size to `bytes`. After an error the reservation is unchanged.
    pub fn resize(&mut self, bytes: u64) -> Result<(), Shortage> {
        let limit = self.budget.limit();
        let own = self.bytes;
        let others = |reserved: u64| reserved.saturating_sub(own);
        let fits = |reserved: u64| {
            let sum = others(reserved).checked_add(bytes)?;
            (bytes <= own || sum <= limit).then_some(sum)
        };
        match self
            .budget
            .reserved
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits)
        {
            Ok(_) => {
                self.bytes = bytes;
                Ok(())
            }
            Err(reserved) => Err(Shortage {
                asked: bytes,
                others: others(reserved),
                limit,
            }),
        }
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.budget.reserved.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// The reservation of a value that can be cloned. Clones of the value share one reservation, and comparisons of values
/// ignore it.
#[derive(Clone, Debug, Default)]
pub struct Held {
    _reservation: Option<Arc<Reservation>>,
}

impl From<Reservation> for Held {
    fn from(reservation: Reservation) -> Self {
        Self {
            _reservation: Some(Arc::new(reservation)),
        }
    }
}

impl PartialEq for Held {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The reason why bytes cannot be reserved. The message begins with the size, for a sentence such as "the picture needs
/// ...".
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Shortage {
    /// The requested bytes. The other numbers are bytes as well.
    pub asked: u64,
    /// The bytes that are reserved for other data.
    pub others: u64,
    /// The whole budget.
    pub limit: u64,
}

impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [asked, others, limit] = [self.asked, self.others, self.limit].map(Bytes);
        write!(f, "{asked} of memory")?;
        match self.others {
            0 => write!(f, ", and the budget is {limit}")?,
            _ => write!(f, ", and of the budget of {limit} other data take {others}")?,
        }
        write!(f, "; {REMEDY}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_count_together_until_they_are_dropped() {
        static BUDGET: Budget = Budget::new(100);
        let mut first = BUDGET.reserve(60).unwrap();
        let shortage = BUDGET.reserve(50).unwrap_err();
        assert_eq!((shortage.asked, shortage.others, shortage.limit), (50, 60, 100));
        assert!(shortage.to_string().contains("50 B of memory"), "{shortage}");
        let second = BUDGET.reserve(40).unwrap();
        assert_eq!(first.resize(61).unwrap_err().others, 40);
        first.resize(10).unwrap();
        drop(second);
        first.resize(100).unwrap();
        assert!(first.resize(u64::MAX).is_err());
        assert_eq!(BUDGET.reserved(), 100);
        // Shrinking works even above a limit that has become smaller.
        BUDGET.name_limit(10);
        first.resize(90).unwrap();
        drop(first);
        assert_eq!(BUDGET.reserved(), 0);
    }

    #[test]
    fn a_file_longer_than_the_budget_is_refused_with_the_budget() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.hdr");
        std::fs::write(&path, [0; 2000]).unwrap();
        let message = data_result(1000, |limit| crate::files::check(&path, limit))
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("the memory budget of 1.0 kB") && message.contains("--memory"),
            "{message}"
        );
        data_result(2000, |limit| crate::files::check(&path, limit)).unwrap();
    }

    #[test]
    fn a_limit_that_was_named_counts_before_a_preferred_one() {
        let budget = Budget::new(100);
        budget.prefer_limit(50);
        assert_eq!(budget.limit(), 50);
        budget.name_limit(70);
        budget.prefer_limit(60);
        assert_eq!(budget.limit(), 70);
    }

    #[test]
    fn threads_never_reserve_more_than_there_is() {
        static BUDGET: Budget = Budget::new(1000);
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..8)
                .map(|_| {
                    scope.spawn(|| {
                        for _ in 0..1000 {
                            if let Ok(held) = BUDGET.reserve(300) {
                                assert!(BUDGET.reserved() <= 1000);
                                drop(held);
                            }
                        }
                    })
                })
                .collect();
            threads
                .into_iter()
                .for_each(|thread| thread.join().expect("no assertion failed"));
        });
        assert_eq!(BUDGET.reserved(), 0);
    }
}
