//! The parameters an analysis may report, each with its name, symbol and unit.

use super::quantity::Quantity;
use crate::model::loss::LossTerm;
use crate::model::unit::UnitRule;
use std::fmt;

macro_rules! parameters {
    ($($(#[$docs:meta])* $variant:ident: $name:literal, $label:literal, $symbol:literal, $unit:expr;)+) => {
        /// A parameter of an answer.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Parameter {
            /// The coefficient of a loss term.
            Loss(LossTerm),
            $($(#[$docs])* $variant,)+
        }

        impl Parameter {
            const OTHERS: &[Parameter] = &[$(Parameter::$variant),+];

            /// Machine-readable name, as in JSON, e.g. `decay_rate_per_s`.
            pub const fn name(self) -> &'static str {
                match self {
                    Parameter::Loss(term) => term.coefficient(),
                    $(Parameter::$variant => $name,)+
                }
            }

            /// The parameter in words, as printed.
            pub const fn label(self) -> &'static str {
                match self {
                    Parameter::Loss(term) => term.label(),
                    $(Parameter::$variant => $label,)+
                }
            }

            /// Symbol, as printed.
            pub const fn symbol(self) -> &'static str {
                match self {
                    Parameter::Loss(term) => term.symbol(),
                    $(Parameter::$variant => $symbol,)+
                }
            }

            /// Rule by which its unit follows from that of the signal.
            pub(crate) const fn unit_rule(self) -> UnitRule {
                match self {
                    Parameter::Loss(term) => term.unit(),
                    $(Parameter::$variant => $unit,)+
                }
            }
        }
    };
}

parameters! {
    /// Mean frequency of a free decay.
    Frequency: "frequency_hz", "frequency", "f", UnitRule::Fixed("Hz");
    /// Natural frequency of a driven oscillator.
    NaturalFrequency: "natural_frequency_hz", "natural frequency", "f₀", UnitRule::Fixed("Hz");
    /// Quality factor of the viscous part alone, `omega_0/(2 delta)`.
    QFactor: "q_factor", "viscous quality factor", "Q", UnitRule::Fixed("");
    /// Rate `a0` at which sliding friction reduces the amplitude.
    SlidingRate: "sliding_rate", "sliding rate", "a₀", UnitRule::SignalPerSecond;
    /// Exponent `n` of a loss that is a power of the amplitude.
    LossExponent: "loss_exponent", "exponent of the loss", "n", UnitRule::Fixed("");
    /// Characteristic velocity of the decrease of friction over the first velocity amplitude: `v_s/(A0 omega)`.
    StribeckVelocityRatio: "stribeck_velocity_ratio", "Stribeck velocity ratio", "v_s/A₀ω", UnitRule::Fixed("");
    /// Amplitude below which contacts stick, over the initial amplitude: `A_b/A0`.
    BreakAmplitudeRatio: "break_amplitude_ratio", "break amplitude ratio", "A_b/A₀", UnitRule::Fixed("");
    /// Amplitude at the first instant used.
    InitialAmplitude: "initial_amplitude", "initial amplitude", "A₀", UnitRule::Signal;
    /// Amplitude `x_0` of the motion of the base.
    DriveAmplitude: "drive_amplitude", "drive amplitude", "x₀", UnitRule::Signal;
    /// `beta = 4 x_F/(pi x_0)`.
    FrictionRatio: "friction_ratio", "friction ratio", "β", UnitRule::Fixed("");
    /// Frequency shift per squared amplitude (Duffing).
    DuffingCoefficient: "frequency_shift_by_amplitude", "Duffing coefficient", "", UnitRule::HertzPerSignalSquared;
    /// Slope of the amplitude at resonance with respect to the drive level.
    Slope: "slope", "slope", "R/x₀", UnitRule::Derived;
    /// Drive level below which friction keeps the mass at rest.
    Threshold: "threshold", "threshold of the drive", "x_T", UnitRule::Derived;
    /// `gamma = 2 m delta`.
    ViscousCoefficient: "viscous_coefficient", "viscous coefficient", "γ", UnitRule::Derived;
    /// `F = k x_F`.
    CoulombForce: "coulomb_force", "sliding friction force", "F", UnitRule::Derived;
}

impl Parameter {
    /// Decay rate `delta`, 1/s: the coefficient of viscous damping.
    pub const DECAY_RATE: Parameter = Parameter::Loss(LossTerm::Viscous);
    /// Friction displacement `x_F = F/k`: the coefficient of sliding friction.
    pub const FRICTION_DISPLACEMENT: Parameter = Parameter::Loss(LossTerm::Sliding);
    /// Drag rate `a2`: the coefficient of quadratic drag.
    pub const DRAG_RATE: Parameter = Parameter::Loss(LossTerm::Drag);

    /// Every parameter, loss terms first.
    pub fn all() -> impl Iterator<Item = Parameter> {
        LossTerm::ALL.iter().map(|t| Parameter::Loss(*t)).chain(Self::OTHERS.iter().copied())
    }

    /// Its unit for a signal in the given unit.
    pub fn unit(self, signal: &str) -> String {
        self.unit_rule().unit(signal)
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Parameter {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::all().find(|p| p.name() == text).ok_or_else(|| format!("no parameter `{text}`"))
    }
}

/// Parameters with their values, in reading order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parameters(Vec<(Parameter, Quantity)>);

impl Parameters {
    /// Adds a parameter at the end, or replaces its value.
    pub fn set(&mut self, parameter: Parameter, quantity: Quantity) {
        match self.0.iter_mut().find(|(p, _)| *p == parameter) {
            Some((_, old)) => *old = quantity,
            None => self.0.push((parameter, quantity)),
        }
    }

    /// The value of a parameter, if the analysis reports it.
    pub fn get(&self, parameter: Parameter) -> Option<&Quantity> {
        self.iter().find(|(p, _)| *p == parameter).map(|(_, q)| q)
    }

    /// Mutable access to the value of a parameter.
    pub fn get_mut(&mut self, parameter: Parameter) -> Option<&mut Quantity> {
        self.0.iter_mut().find(|(p, _)| *p == parameter).map(|(_, q)| q)
    }

    /// Removes and returns a parameter.
    pub fn remove(&mut self, parameter: Parameter) -> Option<Quantity> {
        let place = self.0.iter().position(|(p, _)| *p == parameter)?;
        Some(self.0.remove(place).1)
    }

    /// Parameters and values in order.
    pub fn iter(&self) -> impl Iterator<Item = (Parameter, &Quantity)> {
        self.0.iter().map(|(p, q)| (*p, q))
    }
}

impl FromIterator<(Parameter, Quantity)> for Parameters {
    fn from_iter<I: IntoIterator<Item = (Parameter, Quantity)>>(list: I) -> Self {
        let mut parameters = Self::default();
        list.into_iter().for_each(|(p, q)| parameters.set(p, q));
        parameters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_distinct_and_read_back() {
        for parameter in Parameter::all() {
            assert_eq!(parameter.name().parse(), Ok(parameter));
        }
    }

    #[test]
    fn units_follow_the_signal() {
        assert_eq!(Parameter::DRAG_RATE.unit("rad"), "1/(rad s)");
        assert_eq!(Parameter::DRAG_RATE.unit(""), "1/s");
        assert_eq!(Parameter::SlidingRate.unit("mm"), "mm/s");
        assert_eq!(Parameter::DECAY_RATE.unit("mm"), "1/s");
    }
}
