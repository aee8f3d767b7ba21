//! A series in a sentence.

use crate::format::{Rounded, Scale, p_value, plain};
use slipfit::Quantity;
use slipfit::series::{Answer, Estimate, LoadLaw};

/// Whether ring-down and resonance agree, or what was found if no condition was measured by both.
pub(super) fn sentence(answer: &Answer) -> String {
    let both = answer.table.iter().filter(|r| r.ring_down.is_some() && r.resonance.is_some()).count();
    let conditions = |n: usize| if n == 1 { "one condition".to_owned() } else { format!("{n} conditions") };
    match answer.agreement_p_value {
        Some(p) => {
            let verdict = if answer.agrees == Some(false) { "disagree" } else { "agree" };
            format!(
                "Ring-down and resonance {verdict} on friction and damping at {} ({}).",
                conditions(both),
                p_value(p)
            )
        }
        None => found(answer),
    }
}

/// Friction and its dependence on load, if no condition was measured by both methods.
fn found(answer: &Answer) -> String {
    let cells: Vec<&Estimate> = answer.table.iter().filter_map(|r| r.joint.as_ref()).collect();
    let Some(first) = cells.first() else { return "No measurement gives friction and damping.".to_owned() };
    let conditions = match cells.len() {
        1 => "one condition".to_owned(),
        n => format!("{n} conditions"),
    };
    if !answer.has_friction() {
        let most = cells.iter().map(|c| c.friction.interval_95[1]).fold(0.0, f64::max);
        let scale = Scale::for_size(most, &first.friction.unit);
        let most = plain(most * scale.factor, 2, &scale.unit);
        return format!("No sliding friction is found at {conditions}: it is below {most} (95 %).");
    }
    let Some(best) = answer.laws.first() else {
        let with = cells.iter().filter(|c| c.friction.interval_95[0] > 0.0).count();
        return match cells.len() {
            1 => {
                let [friction, damping] = [&first.friction, &first.damping]
                    .map(|q| Rounded::new(q.value, q.std_error, &q.unit).to_string());
                format!("Friction of {friction} and damping of {damping} at one condition.")
            }
            _ => format!("Sliding friction is found at {with} of {conditions}."),
        };
    };
    let value =
        |symbol: &str, q: &Quantity| format!("{symbol} = {}", Rounded::new(q.value, q.std_error, &q.unit));
    let (symbol, offset) = match best.law {
        LoadLaw::Hertz => ("c", ""),
        LoadLaw::Adhesive => ("mu", "N_0"),
        _ => ("mu", "F_0"),
    };
    let values: Vec<String> = std::iter::once(value(symbol, &best.coefficient))
        .chain(best.offset.as_ref().map(|q| value(offset, q)))
        .collect();
    let open: Vec<String> = answer.laws[1..]
        .iter()
        // The line with a pull-off load is identical to the line with an offset.
        .filter(|l| !l.excluded && l.law != LoadLaw::Adhesive)
        .map(|l| l.law.to_string())
        .collect();
    let open = match open.as_slice() {
        [] => "the other laws compared are excluded".to_owned(),
        laws => format!("{} cannot be excluded", laws.join(" and ")),
    };
    format!(
        "Friction at {} loads is described best by {}, with {}; {open}.",
        best.loads(),
        best.law,
        values.join(" and ")
    )
}
