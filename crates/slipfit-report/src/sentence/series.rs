//! A series in a sentence.

use crate::format::p_value;
use slipfit::series::Answer;

/// Whether ring-down and resonance agree.
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
        None => format!(
            "{} measured; at none of them by ring-down and by resonance both.",
            match answer.table.len() {
                1 => "One condition".to_owned(),
                n => format!("{n} conditions"),
            }
        ),
    }
}
