//! Counters that restart at zero while the motion goes on.

use super::criteria::ClockCriteria;

/// Powers of two at which the counters of microcontrollers restart, in these units (s).
const COUNTERS: [i32; 3] = [16, 24, 32];
const UNITS_S: [f64; 4] = [1e-9, 1e-6, 1e-3, 1.0];
/// Clocks that restart after a second, a minute, an hour, half a day or a day (s).
const CLOCKS_S: [f64; 5] = [1.0, 60.0, 3600.0, 43200.0, 86400.0];

/// The restarts that were joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wraps {
    pub(super) count: usize,
    pub(super) period_s: f64,
}

/// A period after which a clock restarts.
#[derive(Debug, Clone, Copy)]
struct Period {
    length_s: f64,
    /// Whether no run would have this length by chance.
    is_certain: bool,
}

impl Period {
    fn all() -> impl Iterator<Item = Self> {
        let clocks = CLOCKS_S.into_iter().map(|length_s| Self { length_s, is_certain: false });
        let counter = |unit_s: f64| {
            COUNTERS
                .into_iter()
                .map(move |bits| Self { length_s: 2_f64.powi(bits) * unit_s, is_certain: bits == 32 })
        };
        clocks.chain(UNITS_S.into_iter().flat_map(counter))
    }

    /// Whether a clock with this period goes from `before` to `after` in about one step, for a run that began at
    /// `start`.
    fn fits(self, start: f64, [before, after]: [f64; 2], step_s: f64, c: &ClockCriteria) -> bool {
        let half = 0.5 * self.length_s;
        let unsigned = after >= 0.0 && before <= self.length_s;
        let signed = after >= -half && before < half;
        let over = (after + self.length_s - before) / step_s;
        // Separate runs of exactly this length, each starting at zero, look the same.
        let zero = 0.0..c.zero_steps * step_s;
        let is_run = !self.is_certain && zero.contains(&start) && zero.contains(&after);
        (unsigned || signed) && (c.wrap_least_steps..c.wrap_most_steps).contains(&over) && !is_run
    }
}

/// Shifts the stamps after each restart of a counter; `step_s` is the usual step.
pub(super) fn join(time_s: &mut [f64], step_s: f64, c: &ClockCriteria) -> Option<Wraps> {
    let far = |i: &usize| time_s[i - 1] - time_s[*i] > c.disorder_steps * step_s;
    let stays = |i: &usize| time_s.get(i + 1).is_none_or(|next| *next < time_s[i - 1]);
    let falls: Vec<usize> = (1..time_s.len()).filter(far).filter(stays).collect();
    let joined = |period: Period| {
        let mut start = 0;
        let mut places = Vec::new();
        for &i in &falls {
            if period.fits(time_s[start], [time_s[i - 1], time_s[i]], step_s, c) {
                places.push(i);
            } else {
                start = i;
            }
        }
        places
    };
    let most = |held: (Period, Vec<usize>), other: (Period, Vec<usize>)| {
        if other.1.len() > held.1.len() { other } else { held }
    };
    let (period, places) = Period::all().map(|period| (period, joined(period))).reduce(most)?;
    if places.is_empty() {
        return None;
    }
    let mut turns = 0.0;
    let ends = falls.iter().skip(1).copied().chain([time_s.len()]);
    for (i, end) in falls.iter().copied().zip(ends) {
        turns = if places.contains(&i) { turns + 1.0 } else { 0.0 };
        time_s[i..end].iter_mut().for_each(|t| *t += turns * period.length_s);
    }
    Some(Wraps { count: places.len(), period_s: period.length_s })
}
