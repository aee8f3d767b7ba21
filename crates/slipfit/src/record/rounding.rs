//! Uniform clocks whose stamps were written with too few digits.

use super::Clock;
use super::criteria::ClockCriteria;

/// A uniform clock and the deviation of the stamps from it.
pub(super) struct Rebuilt {
    pub(super) clock: Clock,
    /// Coarsest rounding (s).
    pub(super) quantum_s: f64,
    /// Largest deviation of a stamp beyond half its rounding (s).
    pub(super) excess_s: f64,
    /// Half width of the range of rates compatible with all stamps, over the rate.
    pub(super) rate_error: f64,
}

/// How a stamp was rounded.
#[derive(Clone, Copy)]
enum Shortening {
    /// To a fixed number of decimals.
    Fixed(i32),
    /// To a number of significant digits, so that the step grows with time.
    Significant(i32),
}

impl Shortening {
    /// Distance between neighbouring stamps near `time_s`.
    fn quantum_s(self, time_s: f64, step_s: f64) -> f64 {
        match self {
            Self::Fixed(decimals) => 10f64.powi(-decimals),
            Self::Significant(digits) => {
                // A double has no decade beyond these; for a stamp and step of zero the decade is undefined.
                let decade = time_s.abs().max(step_s).log10().floor().clamp(-400.0, 400.0) as i32;
                10f64.powi(decade + 1 - digits)
            }
        }
    }
}

/// The uniform clock behind stamps many of which repeat, if one exists within the rounding of every stamp.
pub(super) fn rebuild(time_s: &[f64], c: &ClockCriteria) -> Option<Rebuilt> {
    let (digits, decimals) = written(time_s, c.rounded_digits)?;
    [Shortening::Fixed(decimals), Shortening::Significant(digits)]
        .into_iter()
        .flat_map(|shortening| [(shortening, 0.0), (shortening, 0.5)])
        .find_map(|(shortening, shift)| fit(time_s, shortening, shift, c))
}

/// Largest number of significant digits (`None` if above `most_digits`) and largest number of decimals among the
/// stamps.
fn written(time_s: &[f64], most_digits: usize) -> Option<(i32, i32)> {
    let (mut digits, mut decimals) = (1, i32::MIN);
    let mut previous = f64::NAN;
    for &t in time_s {
        if t == previous || t == 0.0 {
            continue;
        }
        previous = t;
        // The file contains the shortest decimal that reads back as t.
        let text = format!("{t:e}");
        let (mantissa, exponent) = text.split_once('e')?;
        let count = mantissa.bytes().filter(u8::is_ascii_digit).count() as i32;
        let exponent: i32 = exponent.parse().ok()?;
        digits = digits.max(count);
        decimals = decimals.max(count - 1 - exponent);
        if digits > most_digits as i32 {
            return None;
        }
    }
    (decimals > i32::MIN).then_some((digits, decimals))
}

/// Weighted straight line through the stamps; `shift` in quanta is 0 for
/// rounded stamps, one half for truncated ones.
fn fit(time_s: &[f64], shortening: Shortening, shift: f64, c: &ClockCriteria) -> Option<Rebuilt> {
    let n = time_s.len();
    let (first, last) = (*time_s.first()?, *time_s.last()?);
    let rough_step_s = (last - first) / (n as f64 - 1.0);
    let weighted = || {
        time_s.iter().enumerate().map(move |(i, &t)| {
            let quantum_s = shortening.quantum_s(t, rough_step_s);
            let weight = 1.0 / ((quantum_s / rough_step_s).powi(2) + c.rounded_jitter.powi(2));
            (i as f64, t + shift * quantum_s, weight, quantum_s)
        })
    };
    let (mut sw, mut si, mut st) = (0.0, 0.0, 0.0);
    for (i, t, w, _) in weighted() {
        sw += w;
        si += w * i;
        st += w * t;
    }
    let (mean_i, mean_t) = (si / sw, st / sw);
    let (mut sii, mut sit) = (0.0, 0.0);
    for (i, t, w, _) in weighted() {
        sii += w * (i - mean_i).powi(2);
        sit += w * (i - mean_i) * (t - mean_t);
    }
    let interval_s = sit / sii;
    let start_s = mean_t - interval_s * mean_i;
    if !(interval_s > 0.0 && interval_s.is_finite() && start_s.is_finite()) {
        return None;
    }
    let (mut coarsest_s, mut excess_s) = (0.0_f64, 0.0_f64);
    for (i, t, _, quantum_s) in weighted() {
        coarsest_s = coarsest_s.max(quantum_s);
        let excess = (t - start_s - interval_s * i).abs() - 0.5 * quantum_s;
        if excess > c.rounded_line * quantum_s + c.rounded_jitter * interval_s {
            return None;
        }
        excess_s = excess_s.max(excess);
    }
    let clock = Clock::Uniform { start_s, interval_s };
    let half = |t: f64| 0.5 * shortening.quantum_s(t, rough_step_s) + excess_s.max(0.0);
    let rate_error = rate_error(time_s, interval_s, half);
    Some(Rebuilt { clock, quantum_s: coarsest_s, excess_s, rate_error })
}

/// Uncertainty of the interval over the interval: any two stamps, each off by at most `half`, bound it. For long
/// records the stamps at the beginning are combined with those at the end, which give the tightest bounds.
fn rate_error(time_s: &[f64], interval_s: f64, half: impl Fn(f64) -> f64) -> f64 {
    const MOST: usize = 512;
    let taken = MOST.min(time_s.len() / 2);
    let (mut least, mut most) = (0.0_f64, f64::INFINITY);
    let late: Vec<(f64, f64, f64)> =
        (time_s.len() - taken..time_s.len()).map(|k| (k as f64, time_s[k], half(time_s[k]))).collect();
    for (i, &early) in time_s.iter().enumerate().take(taken) {
        let slack = half(early);
        for &(k, t, of) in &late {
            let (rows, between, room) = (k - i as f64, t - early, slack + of);
            least = least.max((between - room) / rows);
            most = most.min((between + room) / rows);
        }
    }
    let off = (most - interval_s).max(interval_s - least) / interval_s;
    if off.is_finite() { off.max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{ClockCriteria, rebuild};

    #[test]
    fn stamps_that_end_where_they_began_have_no_clock() {
        let criteria = ClockCriteria::default();
        assert!(rebuild(&[0.0, 1.0, 1.0, 0.0], &criteria).is_none());
        assert!(rebuild(&[1e-310, 1e300, 1e-310], &criteria).is_none());
    }
}
