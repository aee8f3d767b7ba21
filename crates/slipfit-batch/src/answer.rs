//! One row of answer.

/// Outcome of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Status {
    /// An answer without warnings.
    Done,
    /// An answer with warnings.
    Warned,
    /// No answer.
    #[default]
    Failed,
}

impl Status {
    /// Name in a table.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Warned => "warned",
            Self::Failed => "failed",
        }
    }
}

/// Value, standard error and ends of the 95 % interval; NaN if there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    pub(crate) std_error: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Estimate {
    pub(crate) const NONE: Self =
        Self { value: f64::NAN, std_error: f64::NAN, low: f64::NAN, high: f64::NAN };

    /// The estimate of a fit, whose interval is symmetric.
    pub(crate) fn normal([value, std_error]: [f64; 2]) -> Self {
        let [low, high] = slipfit::Quantity::normal(value, std_error, String::new()).interval_95;
        Self { value, std_error, low, high }
    }
}

impl Default for Estimate {
    fn default() -> Self {
        Self::NONE
    }
}

impl From<&slipfit::Quantity> for Estimate {
    fn from(q: &slipfit::Quantity) -> Self {
        Self { value: q.value, std_error: q.std_error, low: q.interval_95[0], high: q.interval_95[1] }
    }
}
