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
                    "The curve jumps at {}: it has more than one amplitude there, and no loss follows from it \
                     as it stands.",
                    plain(*frequency_hz, 4, "Hz")
                );
            }
            Warning::SecondPeak { main_hz, other_hz, .. } => {
                return format!(
                    "The curve holds more than one line ({} and {}); what follows holds for neither alone. {}",
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

fn conclusion(a: &Answer) -> String {
    let s = &a.sliding;
    let drive = match a.drive_source {
        DriveSource::Known => "with the drive amplitude given",
        DriveSource::Reference => "with the drive amplitude of the friction-free reference",
        _ => "by the shape of the curve alone",
    };
    let by = if a.method == Method::Paper { ", inverted with a = 4/3" } else { "" };
    if a.model.has_sliding() && s.detected && s.share_at_highest > 0.0 {
        let rest = if s.share_at_lowest > s.share_at_highest + 0.05 {
            format!(" and {} at the lowest amplitude", percent(s.share_at_lowest))
        } else {
            String::new()
        };
        return format!(
            "Sliding friction carries {} of the loss at the peak{rest}, {drive}{by}; a curve without it is \
             excluded, {}.",
            percent(s.share_at_highest),
            p_value(s.p_value)
        );
    }
    let limit = |parameter| a.parameter(parameter).map(|q| (q.interval_95, q.unit.clone()));
    let ratio = limit(Parameter::FrictionRatio).map(|(i, _)| i);
    let law = if a.preferred_model.is_within(a.model) { a.preferred_model } else { a.model };
    if !a.diagnostics.law_holds {
        return format!(
            "Whether sliding friction takes part stays open, {drive}: what every loss law leaves of the curve is more \
             than noise and than what friction explains."
        );
    }
    if law.has_sliding() && !s.detected && s.share_at_highest > 0.0 {
        return format!(
            "Sliding friction is possible but not certain, {}, {drive}: it would carry {} of the loss at the \
             peak.",
            p_value(s.p_value),
            percent(s.share_at_highest)
        );
    }
    if s.detected && a.model.has_sliding() {
        return format!(
            "Sliding friction is present, {}; the curve as it was described{by} shows none.",
            p_value(s.p_value)
        );
    }
    if s.detected {
        return format!("Sliding friction is present, {}, which {} leaves out.", p_value(s.p_value), a.model);
    }
    let below = limit(Parameter::FRICTION_DISPLACEMENT)
        .filter(|(i, _)| i[1].is_finite() && i[1] > 0.0)
        .map(|(i, unit)| format!(": x_F is below {} (95 %)", plain(i[1], 2, &unit)))
        .unwrap_or_default();
    let wide = match (a.drive_source, ratio) {
        (DriveSource::Shape, Some(r)) if r[1] > 0.3 => {
            format!(", which leaves a friction ratio up to {:.2}", r[1].min(1.0))
        }
        _ => String::new(),
    };
    format!("The curve is explained without sliding friction, {}, {drive}{wide}{below}.", p_value(s.p_value))
}
