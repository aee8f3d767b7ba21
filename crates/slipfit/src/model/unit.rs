//! Units of parameters.

/// How the unit of a parameter follows from the unit of the signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub(crate) enum UnitRule {
    /// The same unit for every signal; empty for pure numbers.
    Fixed(&'static str),
    /// The unit of the signal.
    Signal,
    /// The unit of the signal per second.
    SignalPerSecond,
    /// Unit of `c` in `dA/dt = -c A^n`, `n` above one: 1/s over the unit of the signal to the power `n - 1`.
    LossRate(u32),
    /// Hertz over the squared unit of the signal.
    HertzPerSignalSquared,
    /// Set by the analysis: forces, and ratios of two units.
    Derived,
}

impl UnitRule {
    /// The unit for a signal of the given unit; empty if the analysis sets it.
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
