//! Level about which a motion oscillates, if it wanders along a curve.

/// A polynomial in time without its mean.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Baseline {
    pub(super) at: Position,
    /// Coefficients of Legendre polynomials.
    pub(super) curve: Vec<f64>,
    /// Maximum minus minimum of its values at the samples.
    pub(super) range: f64,
    /// Whether the motion itself shifts the level.
    pub(super) goes_with_motion: bool,
}

impl Baseline {
    pub(crate) fn value(&self, time_s: f64) -> f64 {
        let basis = self.at.polynomials(time_s);
        basis.zip(&self.curve).skip(1).map(|(basis, coefficient)| basis * coefficient).sum()
    }
}

/// Time relative to a stretch, from -1 to 1; -1 before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Position {
    middle_s: f64,
    half_s: f64,
}

impl Position {
    pub(super) fn between(first: f64, last: f64) -> Self {
        Self { middle_s: 0.5 * (first + last), half_s: (0.5 * (last - first)).max(f64::MIN_POSITIVE) }
    }

    /// Legendre polynomials of degrees 0, 1, 2, …
    pub(super) fn polynomials(&self, time_s: f64) -> impl Iterator<Item = f64> {
        let u = ((time_s - self.middle_s) / self.half_s).max(-1.0);
        let (mut degree, mut value, mut next) = (0.0, 1.0, u);
        std::iter::repeat_with(move || {
            let found = value;
            degree += 1.0;
            (value, next) = (next, ((2.0 * degree + 1.0) * u * next - degree * value) / (degree + 1.0));
            found
        })
    }

    /// Legendre polynomials up to a degree.
    pub(super) fn basis(&self, time_s: f64, degree: usize) -> Vec<f64> {
        self.polynomials(time_s).take(degree + 1).collect()
    }
}
