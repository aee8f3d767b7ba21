//! Units of parameters.

/// How the unit of a parameter follows from the signal's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub(crate) enum UnitRule {
    /// The same for every signal; empty for pure numbers.
    Fixed(&'static str),
    /// The signal's own.
    Signal,
    /// The signal's per second.
    SignalPerSecond,
    /// Of `c` in `dA/dt = -c A^n`, `n` above one: one over a second and the signal's to the power `n - 1`.
    LossRate(u32),
    /// Hertz over the squared signal's.
    HertzPerSignalSquared,
    /// Set by the analysis: forces and ratios of two units.
    Derived,
}

impl UnitRule {
    /// The unit beside a signal of the given unit; empty where the analysis sets it.
    pub(crate) fn unit(self, signal: &str) -> String {
        match (self, signal) {
            (UnitRule::Fixed(unit), _) => unit.to_owned(),
            (UnitRule::Derived, _) => String::new(),
            (UnitRule::Signal, signal) => signal.to_owned(),
            (UnitRule::SignalPerSecond | UnitRule::LossRate(_), "") => "1/s".to_owned(),
            (UnitRule::SignalPerSecond, signal) => format!("{signal}/s"),
            (UnitRule::LossRate(2), signal) => format!("1/({signal} s)"),
            (UnitRule::LossRate(3), signal) => format!("1/({signal}² s)"),
            (UnitRule::LossRate(n), signal) => format!("1/({signal}^{} s)", n - 1),
            (UnitRule::HertzPerSignalSquared, "") => "Hz".to_owned(),
            (UnitRule::HertzPerSignalSquared, signal) => format!("Hz/{signal}²"),
        }
    }
}
