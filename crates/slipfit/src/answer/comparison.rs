//! Results of the comparison of loss models: the fit of each model, the evidence for sliding friction, correlations of
//! the estimates.

use super::parameter::Parameter;
use crate::model::loss::LossModel;

/// One loss model, fitted.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Candidate {
    /// The model.
    pub model: LossModel,
    /// Bayesian information criterion; only differences are meaningful.
    pub bic: f64,
    /// `bic` minus that of the best candidate.
    pub delta_bic: f64,
    /// Root mean square of the residuals (of each quadrature if complex), in the unit of the signal.
    pub rms: f64,
    /// Number of free parameters, nuisance parameters included.
    pub free_parameters: usize,
    /// Whether the fit converged to its tolerance.
    pub converged: bool,
    /// The loss coefficient at its limit (zero) in this model, if any.
    pub at_limit: Option<Parameter>,
    /// Fitted values; zero for loss terms the model does not have.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub values: Values,
}

impl Candidate {
    /// Fitted value of a parameter; zero if the model has none.
    pub fn value(&self, parameter: Parameter) -> f64 {
        self.values.get(parameter).unwrap_or(0.0)
    }
}

/// Fitted values by parameter.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Values(Vec<(Parameter, f64)>);

impl Values {
    /// The value of a parameter, if there is one.
    pub fn get(&self, parameter: Parameter) -> Option<f64> {
        self.0.iter().find(|(p, _)| *p == parameter).map(|(_, v)| *v)
    }

    /// Parameters and values in order.
    pub fn iter(&self) -> impl Iterator<Item = (Parameter, f64)> {
        self.0.iter().copied()
    }
}

impl FromIterator<(Parameter, f64)> for Values {
    fn from_iter<I: IntoIterator<Item = (Parameter, f64)>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}

/// Evidence for sliding friction, and its share of the loss.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SlidingEvidence {
    /// Whether sliding friction is detected: `p_value` is below 0.01 and the BIC prefers it; if a sensor curve is
    /// fitted, the friction displacement must also exceed three standard errors.
    pub detected: bool,
    /// Probability that data without sliding friction would give at least this likelihood ratio, under the best model
    /// without it. One-sided: friction cannot be negative.
    pub p_value: f64,
    /// BIC of the best model without sliding friction minus that of the best model with it.
    pub delta_bic: f64,
    /// Share of sliding friction in the loss at the highest amplitude used (the start of a decay, the peak of a curve),
    /// in the chosen model.
    pub share_at_highest: f64,
    /// Share of sliding friction in the loss at the lowest amplitude used.
    pub share_at_lowest: f64,
    /// Instant, s, from which sliding friction accounts for more than 95 % of the loss of a decay.
    pub dominates_from_s: Option<f64>,
    /// p value of a purely viscous loss (one-sided F test against the chosen model); 1 if the chosen model is viscous.
    pub viscous_only_p_value: f64,
    /// Whether a purely viscous loss is excluded: its p value is below the threshold of [`detected`](Self::detected).
    #[cfg_attr(feature = "serde", serde(skip))]
    pub viscous_only_excluded: bool,
}

/// Correlation of two estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Correlation {
    /// The two parameters.
    pub parameters: [Parameter; 2],
    /// Their correlation coefficient, in `[-1, 1]`.
    pub value: f64,
}

/// The correlation of two parameters in a list, in either order.
pub(crate) fn correlation(list: &[Correlation], a: Parameter, b: Parameter) -> Option<f64> {
    list.iter().find(|c| c.parameters == [a, b] || c.parameters == [b, a]).map(|c| c.value)
}
