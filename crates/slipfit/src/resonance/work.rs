//! Work of a search, counted instead of timed, so that every search ends and gives the same answer on any machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Work of a pass independent of its points: parameters, matrices, and the step.
const PASS: u64 = 50;
/// Work of a point on vector lanes.
const POINT: u64 = 1;

/// Work reserved for the model at every point if nothing else is left.
const REPORT: u64 = 1_000_000;

/// The remaining work allowed for fits to all copies of a curve, in units of about 30 ns.
#[derive(Debug, Clone)]
pub(crate) struct Work(Arc<Account>);

#[derive(Debug)]
struct Account {
    most: u64,
    /// Allowed for the present step, and used by it.
    step: AtomicU64,
    used: AtomicU64,
    /// Used by the previous steps.
    before: AtomicU64,
    cut: AtomicBool,
}

impl Default for Work {
    /// Without a limit.
    fn default() -> Self {
        Self::limited(u64::MAX)
    }
}

/// Work is ignored when blocks are compared.
impl PartialEq for Work {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Work {
    pub(crate) fn limited(most: u64) -> Self {
        Self(Arc::new(Account {
            most,
            step: AtomicU64::new(most),
            used: AtomicU64::new(0),
            before: AtomicU64::new(0),
            cut: AtomicBool::new(false),
        }))
    }

    fn used(&self) -> u64 {
        self.0.used.load(Ordering::Relaxed)
    }

    fn allowed(&self) -> u64 {
        self.0.step.load(Ordering::Relaxed)
    }

    /// Remaining work for motions with stops.
    pub(crate) fn remaining(&self) -> u64 {
        self.allowed().saturating_sub(self.used())
    }

    /// Whether even motions in closed form are no longer computed; a sixteenth more is allowed for these.
    pub(crate) fn is_spent(&self) -> bool {
        self.used() >= self.allowed().saturating_add(self.allowed() / 16)
    }

    /// Allows `search` a fraction of the remaining work, so that the rest is left for what follows.
    pub(crate) fn within<T>(&self, part: f64, search: impl FnOnce() -> T) -> T {
        let (used, allowed) = (self.used(), self.allowed());
        let most = used.saturating_add((part * self.remaining() as f64) as u64).min(allowed);
        self.0.step.store(most, Ordering::Relaxed);
        let found = search();
        self.0.step.store(allowed, Ordering::Relaxed);
        found
    }

    /// Reserves at least a fraction of the work of the first step for what follows, once.
    pub(crate) fn reserve(&self, part: f64) {
        let part = (part * self.0.most as f64) as u64;
        let least = self.used().saturating_add(part).min(self.0.most.saturating_add(part));
        self.0.step.store(self.allowed().max(least), Ordering::Relaxed);
    }

    /// Work allowed for a curve to be reported, whatever the search used.
    pub(crate) fn for_report(&self) -> u64 {
        self.remaining().max(REPORT)
    }

    /// All work done so far.
    #[cfg(test)]
    pub(crate) fn spent(&self) -> u64 {
        self.0.before.load(Ordering::Relaxed) + self.used()
    }

    /// Adds one pass over `points`, with the work of those computed one by one.
    pub(crate) fn spend(&self, points: usize, one_by_one: u64) {
        let spent = (PASS + POINT * points as u64).saturating_add(one_by_one);
        if spent >= self.remaining() {
            self.0.cut.store(true, Ordering::Relaxed);
        }
        self.0.used.store(self.used().saturating_add(spent), Ordering::Relaxed);
    }

    /// Allows the next step a fraction of the work of the first.
    pub(crate) fn renew(&self, part: f64) {
        self.0.before.fetch_add(self.used(), Ordering::Relaxed);
        self.0.used.store(0, Ordering::Relaxed);
        self.0.step.store((part * self.0.most as f64) as u64, Ordering::Relaxed);
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
        let work = Work::limited(1000);
        work.clone().spend(5, 400);
        assert_eq!(work.remaining(), 1000 - PASS - 5 * POINT - 400);
        assert!(!work.was_cut());
        work.spend(5, 1000);
        assert_eq!(work.remaining(), 0);
        assert!(!Work::limited(10_000).is_spent());
        work.spend(0, 500);
        assert!(work.is_spent());
        work.renew(0.5);
        assert!(work.was_cut());
        assert_eq!(work.remaining(), 500);
        assert_eq!(work.spent(), 3 * PASS + 10 * POINT + 1900);
    }
    #[test]
    fn a_part_of_a_search_leaves_the_rest_to_others() {
        let work = Work::limited(1000);
        work.within(0.5, || {
            assert_eq!(work.remaining(), 500);
            work.spend(0, 600);
            assert_eq!(work.remaining(), 0);
        });
        assert_eq!(work.remaining(), 1000 - PASS - 600);
        work.spend(0, 1000 - 2 * PASS - 600);
        assert_eq!(work.remaining(), 0);
        // Only once, however often it is requested.
        work.reserve(0.25);
        assert_eq!(work.remaining(), 250);
        work.spend(0, 250 - PASS);
        work.reserve(0.25);
        assert_eq!(work.remaining(), 0);
        // Work beyond the limit does not allow a further fraction.
        work.spend(0, 1250 / 16);
        work.within(0.5, || assert!(work.is_spent()));
    }
}
