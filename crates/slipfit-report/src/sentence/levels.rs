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
        let [low, high] = threshold.interval_95;
        let high = plain(high, 2, &threshold.unit);
        if low > 0.0 {
            let low = plain(low, 2, &threshold.unit);
            return format!(
                "A threshold is possible but not certain ({}): sliding friction would hold the mass up to a drive \
                 between {low} and {high} (95 %).",
                p_value(answer.p_value)
            );
        }
        return format!("No threshold is found ({}): it lies below {high} (95 %).", p_value(answer.p_value));
    }
    let friction = answer.parameter(Parameter::FRICTION_DISPLACEMENT).map_or_else(String::new, |q| {
        format!(
            ", which corresponds to a friction displacement of {}",
            Rounded::new(q.value, q.std_error, &q.unit)
        )
    });
    format!(
        "Sliding friction holds the mass up to a drive of {shown}{friction}; a line through zero is excluded, {}.",
        p_value(answer.p_value)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipfit::levels::{Levels, Options, analyse};

    #[test]
    fn a_threshold_that_the_interval_keeps_off_zero_is_possible() {
        let mut possible = 0;
        for threshold in 0..40 {
            let threshold = 5e-4 * f64::from(threshold);
            let mut noise = 0.37f64;
            let drives: Vec<f64> = (1..=12).map(|i| 0.1 * f64::from(i)).collect();
            let amplitude = |drive: &f64| {
                noise = (noise * 997.0).fract();
                50.0 * (drive - threshold) + (noise - 0.5)
            };
            let amplitudes: Vec<f64> = drives.iter().map(amplitude).collect();
            let levels = Levels::builder(drives, amplitudes).build().unwrap();
            let answer = analyse(&levels, &Options::default()).unwrap();
            let [low, _] = answer.parameter(Parameter::Threshold).unwrap().interval_95;
            let said = sentence(&answer);
            assert_eq!(said.contains("No threshold"), !answer.detected && low == 0.0, "{threshold}: {said}");
            possible += usize::from(said.contains("possible but not certain"));
        }
        assert!(possible > 0);
    }
}
