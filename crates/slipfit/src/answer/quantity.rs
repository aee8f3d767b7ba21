//! A reported number: value, uncertainty, interval, unit.

/// An estimated quantity with its uncertainty.
///
/// `interval_95` need not be symmetric about `value`: close to a physical
/// limit (no friction, no viscous damping) it comes from the profile
/// likelihood and ends at the limit.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Quantity {
    /// Best estimate inside the physical range, in `unit`.
    pub value: f64,
    /// Standard error, in `unit`.
    pub std_error: f64,
    /// 95 % confidence interval, in `unit`.
    pub interval_95: [f64; 2],
    /// The same estimate without its physical limit, in `unit`: if there is no friction it scatters about zero on both
    /// sides, so that averages over many records are unbiased. Equal to `value` inside the limits.
    pub unbounded_value: f64,
    /// Unit in plain text (`Hz`, `1/s`, `mrad`, …); empty for pure numbers.
    pub unit: String,
}

impl Quantity {
    /// A quantity with a symmetric interval of `1.96` standard errors.
    ///
    /// ```
    /// let q = slipfit::Quantity::normal(2.0, 0.5, "rad");
    /// assert!((q.interval_95[0] - 1.02).abs() < 1e-3);
    /// ```
    pub fn normal(value: f64, std_error: f64, unit: impl Into<String>) -> Self {
        let half = crate::inference::Z_95 * std_error;
        Self {
            value,
            std_error,
            interval_95: [value - half, value + half],
            unbounded_value: value,
            unit: unit.into(),
        }
    }

    /// The quantity multiplied by an exact factor, in another unit.
    pub fn scaled(&self, factor: f64, unit: impl Into<String>) -> Self {
        let [a, b] = [self.interval_95[0] * factor, self.interval_95[1] * factor];
        Self {
            value: self.value * factor,
            std_error: self.std_error * factor.abs(),
            interval_95: [a.min(b), a.max(b)],
            unbounded_value: self.unbounded_value * factor,
            unit: unit.into(),
        }
    }

    /// A non-negative quantity multiplied by a factor of relative standard error `relative`. The two errors add in
    /// quadrature, as do the half widths of the interval, each with the contribution of the factor at that end.
    pub(crate) fn widened(self, relative: f64) -> Self {
        let most = |end: f64| self.value.abs().max(end.abs()) * relative;
        let [low, high] = self.interval_95;
        let [below, above] = [self.clone().with_error(most(low)), self.clone().with_error(most(high))];
        Self {
            std_error: self.std_error.hypot(self.value * relative),
            interval_95: [below.interval_95[0], above.interval_95[1]],
            ..self
        }
    }

    /// Adds another error in quadrature to the standard error and to the half widths of the interval of a quantity of
    /// any sign.
    pub(crate) fn add_error(&mut self, extra: f64) {
        let extra = extra.abs();
        self.std_error = self.std_error.hypot(extra);
        let width = |end: f64| (end - self.value).hypot(crate::inference::Z_95 * extra);
        let [low, high] = self.interval_95;
        self.interval_95 = [self.value - width(low), self.value + width(high)];
    }

    /// A non-negative quantity with another error added in quadrature; the interval stays non-negative.
    pub(crate) fn with_error(self, extra: f64) -> Self {
        let width = |end: f64| (end - self.value).hypot(crate::inference::Z_95 * extra);
        let [low, high] = self.interval_95;
        Self {
            std_error: self.std_error.hypot(extra),
            interval_95: [(self.value - width(low)).max(0.0), self.value + width(high)],
            ..self
        }
    }
}
