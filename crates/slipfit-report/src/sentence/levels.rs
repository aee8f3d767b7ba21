//! Drive levels in a sentence.

use crate::format::{Rounded, p_value, plain};
use slipfit::Parameter;
use slipfit::levels::Answer;

/// The threshold, the friction displacement and the evidence for them.
pub(super) fn sentence(answer: &Answer) -> String {
    let Some(threshold) = answer.parameter(Parameter::Threshold) else {
        return "The levels give no threshold.".to_owned();
    };
    let shown = Rounded::new(threshold.value, threshold.std_error, &threshold.unit);
    if !answer.detected {
        let high = plain(threshold.interval_95[1], 2, &threshold.unit);
        return format!(
            "No threshold is seen ({}): sliding friction holds the mass below a drive of {high} at most.",
            p_value(answer.p_value)
        );
    }
    let friction = answer.parameter(Parameter::FRICTION_DISPLACEMENT).map_or_else(String::new, |q| {
        format!(", a friction displacement of {}", Rounded::new(q.value, q.std_error, &q.unit))
    });
    format!(
        "Sliding friction holds the mass up to a drive of {shown}{friction}; a line through zero is excluded, {}.",
        p_value(answer.p_value)
    )
}
