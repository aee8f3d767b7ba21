//! Work of a search, counted rather than timed, so that every search ends and gives the same answer on
//! any machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Points of a pass on vector lanes that take as long as one by itself.
const LANES: u64 = 8;

/// The work that fits to all copies of a curve may still do, in units of some 30 ns.
#[derive(Debug, Clone)]
pub(crate) struct Work(Arc<Account>);

#[derive(Debug)]
struct Account {
    most: u64,
    left: AtomicU64,
    cut: AtomicBool,
}

impl Default for Work {
    /// Without a limit.
    fn default() -> Self {
        Self::limited(u64::MAX)
    }
}

/// Blocks are compared by what was measured.
impl PartialEq for Work {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Work {
    pub(crate) fn limited(most: u64) -> Self {
        Self(Arc::new(Account { most, left: AtomicU64::new(most), cut: AtomicBool::new(false) }))
    }

    pub(crate) fn left(&self) -> u64 {
        self.0.left.load(Ordering::Relaxed)
    }

    /// Counts one pass over `points`, with the work of those computed one by one.
    pub(crate) fn spend(&self, points: usize, one_by_one: u64) {
        let spent = one_by_one + points as u64 / LANES;
        let left = self.left();
        if spent >= left {
            self.0.cut.store(true, Ordering::Relaxed);
        }
        self.0.left.store(left.saturating_sub(spent), Ordering::Relaxed);
    }

    /// Allows as much again, for the next step.
    pub(crate) fn renew(&self) {
        self.0.left.store(self.0.most, Ordering::Relaxed);
    }

    /// Whether a search was cut short.
    pub(crate) fn was_cut(&self) -> bool {
        self.0.cut.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_spend_from_one_account() {
        let work = Work::limited(100);
        work.clone().spend(80, 60);
        assert_eq!(work.left(), 30);
        assert!(!work.was_cut());
        work.spend(0, 31);
        assert_eq!(work.left(), 0);
        work.renew();
        assert!(work.was_cut());
        assert_eq!(work.left(), 100);
    }
}
