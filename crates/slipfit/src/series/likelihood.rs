//! Hartung-Knapp factor, weights of two models from their likelihoods, and minimisation over a scatter.

use crate::inference::evidence::student_factor;
use crate::numeric::GOLDEN_SECTION;

/// Half width of an interval over that of a normal one, from the reduced chi square with `freedom` degrees of freedom
/// (G. Knapp and J. Hartung, Stat. Med. 22, 2693, 2003; never below one as C. Röver et al., BMC Med. Res. Methodol.
/// 15, 99, 2015, advise).
pub(super) fn hartung_knapp_factor(reduced: f64, freedom: f64) -> f64 {
    if freedom > 0.0 { (student_factor(freedom) * reduced.sqrt()).max(1.0) } else { 1.0 }
}

/// Weights of two models from minus twice their log-likelihoods.
pub(super) fn weights([a, b]: [f64; 2]) -> [f64; 2] {
    let second = 1.0 / (1.0 + (0.5 * (b - a)).exp());
    let second = if second.is_finite() { second } else { 0.0 };
    [1.0 - second, second]
}

/// Position and value of the minimum of a function of a scatter from zero to `highest`: first by halving, then by
/// golden section.
pub(super) fn lowest(highest: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    const HALVES: i32 = 20;
    const SECTIONS: usize = 24;
    let tried = std::iter::once(0.0).chain((0..HALVES).map(|i| highest * 0.5_f64.powi(i))).map(|x| (x, f(x)));
    let (x, y) = tried.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, f64::INFINITY));
    let [mut low, mut high] = [0.5 * x, (2.0 * x).min(highest)];
    for _ in 0..SECTIONS {
        let [left, right] = [high - GOLDEN_SECTION * (high - low), low + GOLDEN_SECTION * (high - low)];
        if f(left) < f(right) { high = right } else { low = left }
    }
    let middle = 0.5 * (low + high);
    let refined = f(middle);
    if refined < y { (middle, refined) } else { (x, y) }
}
