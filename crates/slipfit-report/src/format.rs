//! Numbers formatted for reading: rounded to their uncertainty, in a suitable unit.
//!
//! All interfaces (terminal, plots, notebooks, browser) format numbers with this module, so that one answer reads
//! the same everywhere. The rounding and the choice of the unit prefix are those of the core library, whose
//! warnings contain numbers as well.

pub use slipfit::answer::rounded::{Rounded, Scale, decay_times, exact_percent, plain, signed_percent};

/// A time (s) on a clock that covers `span_s`; a clock that counts from 1970 is shown with enough digits to
/// resolve the span.
///
/// ```
/// use slipfit_report::format::instant;
/// assert_eq!(instant(1.23456, 30.0), "1.235 s");
/// assert_eq!(instant(1_699_023_130.1234, 30.0), "1699023130.1 s");
/// ```
pub fn instant(time_s: f64, span_s: f64) -> String {
    let span_s = span_s.abs();
    if !(span_s > 0.0 && time_s.abs() > 100.0 * span_s) {
        return plain(time_s, 4, "s");
    }
    let decimals = (3.0 - span_s.log10().floor() - 1.0).clamp(0.0, 9.0) as usize;
    format!("{time_s:.decimals$} s")
}

/// A ratio: two decimals, or none from ten upwards.
///
/// ```
/// assert_eq!(slipfit_report::format::times(1.0049), "1.00");
/// assert_eq!(slipfit_report::format::times(57.17), "57");
/// ```
pub fn times(ratio: f64) -> String {
    format!("{ratio:.*}", if ratio < 9.995 { 2 } else { 0 })
}

/// `p < 1e-12`, `p = 3e-5`, `p = 0.012`.
///
/// ```
/// assert_eq!(slipfit_report::format::p_value(0.0), "p < 1e-12");
/// assert_eq!(slipfit_report::format::p_value(0.0123), "p = 0.012");
/// ```
pub fn p_value(p: f64) -> String {
    if p < 1e-12 {
        "p < 1e-12".to_owned()
    } else if p < 1e-3 {
        format!("p = {p:.0e}")
    } else {
        format!("p = {}", plain(p, 2, ""))
    }
}

/// A fraction in per cent, `41 %`; never `0 %` or `100 %` unless it is exactly that.
///
/// ```
/// use slipfit_report::format::percent;
/// assert_eq!(percent(0.414), "41 %");
/// assert_eq!(percent(0.0042), "0.4 %");
/// assert_eq!(percent(0.9999), "over 99 %");
/// ```
pub fn percent(share: f64) -> String {
    let per_cent = share * 100.0;
    match per_cent {
        p if !p.is_finite() => "an unknown share".to_owned(),
        p if p <= 0.0 => "0 %".to_owned(),
        p if p < 0.1 => "under 0.1 %".to_owned(),
        p if p < 2.0 => format!("{p:.1} %"),
        p if p >= 100.0 => format!("{p:.0} %"),
        p if p >= 99.5 => "over 99 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_never_round_to_none_or_all() {
        assert_eq!(percent(0.996), "over 99 %");
        assert_eq!(percent(1.0), "100 %");
        assert_eq!(percent(1e-5), "under 0.1 %");
        assert_eq!(percent(0.0), "0 %");
    }
}
