//! The loss models a decay is compared with.

use std::fmt;

/// Which loss terms act on the oscillator.
///
/// The amplitude obeys `dA/dt = -(a0 + a1 A + a2 A²)`: sliding friction gives
/// the constant term (eqs. (15)-(18) of the paper), viscous damping the
/// linear one, quadratic drag the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum LossModel {
    /// Viscous damping only: the exponential decay.
    Viscous,
    /// Sliding friction only: the amplitude falls along a straight line.
    Sliding,
    /// Viscous damping and sliding friction: the paper's model.
    ViscousSliding,
    /// Viscous damping and quadratic drag (air, water).
    ViscousDrag,
    /// Sliding friction and quadratic drag.
    SlidingDrag,
    /// All three.
    ViscousSlidingDrag,
}

impl LossModel {
    /// Every model, simplest first.
    pub const ALL: [LossModel; 6] = [
        LossModel::Viscous,
        LossModel::Sliding,
        LossModel::ViscousSliding,
        LossModel::ViscousDrag,
        LossModel::SlidingDrag,
        LossModel::ViscousSlidingDrag,
    ];

    /// Whether sliding friction is part of the model.
    pub fn has_sliding(self) -> bool {
        !matches!(self, LossModel::Viscous | LossModel::ViscousDrag)
    }

    /// Whether viscous damping is part of the model.
    pub fn has_viscous(self) -> bool {
        !matches!(self, LossModel::Sliding | LossModel::SlidingDrag)
    }

    /// Whether quadratic drag is part of the model.
    pub fn has_drag(self) -> bool {
        matches!(self, LossModel::ViscousDrag | LossModel::SlidingDrag | LossModel::ViscousSlidingDrag)
    }

    /// What the BIC of this model must be better by before it is preferred.
    ///
    /// Every oscillator has some loss linear in velocity: one that seems to have none beside its
    /// drag is more often chance (one record in a hundred with two losses and 20 dB), and its
    /// `x_F` is then far off. 6 is strong evidence on the scale of the BIC (Kass and Raftery 1995).
    pub(crate) fn handicap(self) -> f64 {
        if self.has_drag() && !self.has_viscous() { 6.0 } else { 0.0 }
    }

    /// The model with these terms; `None` when there is no loss at all.
    pub fn from_terms(viscous: bool, sliding: bool, drag: bool) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|m| m.has_viscous() == viscous && m.has_sliding() == sliding && m.has_drag() == drag)
    }

    /// Machine-readable name, as in the JSON answer and `--model`.
    pub fn name(self) -> &'static str {
        match self {
            LossModel::Viscous => "viscous",
            LossModel::Sliding => "sliding",
            LossModel::ViscousSliding => "viscous+sliding",
            LossModel::ViscousDrag => "viscous+drag",
            LossModel::SlidingDrag => "sliding+drag",
            LossModel::ViscousSlidingDrag => "viscous+sliding+drag",
        }
    }
}

impl fmt::Display for LossModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for LossModel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|m| m.name() == text).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|m| m.name()).collect();
            format!("no loss model `{text}`; one of {}", names.join(", "))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        for model in LossModel::ALL {
            assert_eq!(model.name().parse(), Ok(model));
            assert_eq!(
                LossModel::from_terms(model.has_viscous(), model.has_sliding(), model.has_drag()),
                Some(model)
            );
        }
        assert_eq!(LossModel::from_terms(false, false, true), None);
        assert!("elastic".parse::<LossModel>().is_err());
    }
}
