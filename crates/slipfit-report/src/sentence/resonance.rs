//! A resonance curve in a sentence.

use crate::format::{p_value, percent, plain};
use slipfit::Parameter;
use slipfit::answer::Warning;
use slipfit::resonance::{Answer, DriveSource, Method};

/// What the curve says about sliding friction, in plain words: how much of the loss it
/// carries at the peak and how sure that is, or why that cannot be determined.
pub(super) fn sentence(a: &Answer) -> String {
    for warning in &a.warnings {
        match warning {
            Warning::Jump { frequency_hz, .. } => {
                return format!(
                    "The curve jumps at {}: it has more than one amplitude there, so no loss can be \
                     determined from the whole curve.",
                    plain(*frequency_hz, 4, "Hz")
                );
            }
            Warning::SecondPeak { main_hz, other_hz, .. } => {
                return format!(
                    "The curve contains more than one peak ({} and {}); the following results are valid for \
                     neither alone. {}",
                    plain(*main_hz, 4, "Hz"),
                    plain(*other_hz, 4, "Hz"),
                    conclusion(a)
                );
            }
            _ => {}
        }
    }
    conclusion(a)
}

/// The instrument term that amplitudes alone do not distinguish from friction.
fn term_confused_with_friction(a: &Answer) -> Option<&'static str> {
    a.warnings.iter().find_map(|w| match w {
        Warning::Background { phases: false, .. } => Some("the background"),
        Warning::AmplitudeOffset { .. } => Some("the constant offset of every amplitude"),
        Warning::NoiseFloor { .. } => Some("the noise floor"),
        _ => None,
    })
}

fn conclusion(a: &Answer) -> String {
    let s = &a.sliding;
    let drive = match a.drive_source {
        DriveSource::Known => "with the drive amplitude given",
        DriveSource::Reference => "with the drive amplitude of the reference",
        _ => "according to the shape of the curve alone",
    };
    let by = if a.method == Method::Paper { ", inverted with a = 4/3" } else { "" };
    if a.model.has_sliding() && s.detected && s.share_at_highest > 0.0 {
        let rest = if s.share_at_lowest > s.share_at_highest + 0.05 {
            format!(" and {} at the lowest amplitude", percent(s.share_at_lowest))
        } else {
            String::new()
        };
        let carries = format!(
            "Sliding friction carries {} of the loss at the peak{rest}, {drive}{by}",
            percent(s.share_at_highest)
        );
        // It is not known whether the assumption of the p value holds.
        if let Some(term) = term_confused_with_friction(a) {
            return format!(
                "{carries}, if {term} is as fitted: amplitudes alone do not distinguish it from friction, \
                 and no p value is valid."
            );
        }
        return format!("{carries}; a curve without friction is excluded, {}.", p_value(s.p_value));
    }
    let limit = |parameter| a.parameter(parameter).map(|q| (q.interval_95, q.unit.clone()));
    let ratio = limit(Parameter::FrictionRatio).map(|(i, _)| i);
    let law = if a.preferred_model.is_within(a.model) { a.preferred_model } else { a.model };
    if !a.diagnostics.law_holds {
        return "Whether there is sliding friction remains open: with every loss law the residuals are larger than \
                noise or friction explains."
            .to_owned();
    }
    // A term whose interval excludes zero is possible, whichever model has the lower BIC.
    let off_zero = a.model.has_sliding()
        && limit(Parameter::FRICTION_DISPLACEMENT).is_some_and(|(interval, _)| interval[0] > 0.0);
    if (law.has_sliding() || off_zero) && !s.detected && s.share_at_highest > 0.0 {
        return format!(
            "Sliding friction is possible but not certain, {}, {drive}: it would carry {} of the loss at the \
             peak.",
            p_value(s.p_value),
            percent(s.share_at_highest)
        );
    }
    if s.detected && a.model.has_sliding() {
        return format!(
            "Sliding friction is present, {}; the reported description of the curve{by} shows none.",
            p_value(s.p_value)
        );
    }
    if s.detected {
        return format!(
            "Sliding friction is present, {}, but the model {} does not include it.",
            p_value(s.p_value),
            a.model
        );
    }
    let below = limit(Parameter::FRICTION_DISPLACEMENT)
        .filter(|(i, _)| i[1].is_finite() && i[1] > 0.0)
        .map(|(i, unit)| format!(": x_F is below {} (95 %)", plain(i[1], 2, &unit)))
        .unwrap_or_default();
    let wide = match (a.drive_source, ratio) {
        (DriveSource::Shape, Some(r)) if r[1] > 0.3 => {
            format!(", which allows a friction ratio of up to {:.2}", r[1].min(1.0))
        }
        _ => String::new(),
    };
    format!("The curve is explained without sliding friction ({}), {drive}{wide}{below}.", p_value(s.p_value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipfit::Oscillator;
    use slipfit::motion::steady::{Phasor, scan};
    use slipfit::resonance::{Curve, Options, analyse};

    fn answer(friction: f64, background: f64, phases: bool) -> Answer {
        let o = Oscillator::builder().frequency_hz(1.0).q_factor(100.0).friction_displacement(friction);
        let o = o.build().unwrap();
        let hz: Vec<f64> = (0..161).map(|i| 0.96 + 5e-4 * f64::from(i)).collect();
        let mut noise = 0.37f64;
        let mut jitter = || {
            noise = (noise * 997.0).fract();
            0.6 * (noise - 0.5)
        };
        let read = |f: &f64| {
            let z = scan::reading(&o, 1.0, *f).unwrap().fundamental;
            z + Phasor::new(background + jitter(), jitter())
        };
        let z: Vec<Phasor> = hz.iter().map(read).collect();
        let curve = if phases {
            Curve::complex(hz, z)
        } else {
            Curve::builder(hz, z.iter().map(|z| z.norm()).collect())
        };
        analyse(&curve.build().unwrap(), &Options::default()).unwrap()
    }

    #[test]
    fn no_p_value_stands_where_a_background_may_be_friction() {
        let said = sentence(&answer(0.4, 6.0, false));
        assert!(said.contains("if the background is as fitted") && !said.contains("p <"), "{said}");
        let said = sentence(&answer(0.4, 6.0, true));
        assert!(said.contains("a curve without friction is excluded, p <"), "{said}");
    }

    #[test]
    fn friction_that_the_interval_keeps_off_zero_is_possible() {
        for friction in [0.0, 2e-3, 4e-3, 6e-3, 8e-3, 1e-2, 1.2e-2] {
            let answer = answer(friction, 0.0, true);
            let [low, _] = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().interval_95;
            let said = sentence(&answer);
            assert!(low == 0.0 || !said.contains("explained without"), "{friction}: {said}");
        }
    }
}
