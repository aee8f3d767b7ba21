//! A ring-down in a sentence.

use crate::format::{decay_times, exact_percent, p_value, percent, plain};
use slipfit::answer::Warning;
use slipfit::ringdown::{Answer, Mode};
use slipfit::{LossModel, LossTerm, Parameter};

/// Share from which the sentence says "nearly all".
const NEARLY_ALL: f64 = 0.95;
/// If the shares at both ends differ by less than this, only one share is given.
const SAME_SHARE: f64 = 0.05;

/// What the record says about sliding friction, in plain words: how much of
/// the loss it carries and how sure that is, or why that cannot be determined.
///
/// For instance "Sliding friction carries 41 % of the loss at the start and
/// nearly all of it in the last 8 s; a purely viscous decay is excluded,
/// p < 1e-12." Shares are those of the chosen model between the first and
/// the last amplitude used.
pub(super) fn sentence(a: &Answer) -> String {
    let mut text = String::new();
    if let Some([main_hz, other_hz]) = modes_hz(a) {
        text = format!(
            "The record contains more than one mode ({} and {}); the following results are valid for neither alone. ",
            plain(main_hz, 4, "Hz"),
            plain(other_hz, 4, "Hz")
        );
    }
    if let Some((second, main_hz, strength)) = second_mode(a) {
        text = format!(
            "The record contains two modes, {} and {} (relative amplitude {}); the second was subtracted, and \
             the following results are those of the first. ",
            plain(main_hz, 4, "Hz"),
            plain(second.frequency.value, 4, "Hz"),
            exact_percent(strength)
        );
    }
    text.push_str(&loss_sentence(a));
    text
}

fn loss_sentence(a: &Answer) -> String {
    let undetermined = a.warnings.iter().find_map(|w| match w {
        Warning::ModelUndetermined { asked, reported } => Some((*asked, *reported)),
        _ => None,
    });
    if let Some((asked, reported)) = undetermined {
        let conclusion = conclusion(a);
        return format!("The data do not determine all of {asked}; {reported} is reported. {conclusion}");
    }
    let asked = a.warnings.iter().find_map(|w| match w {
        Warning::ModelNotPreferred { asked, preferred, .. } => Some((*asked, *preferred)),
        _ => None,
    });
    if let Some((asked, preferred)) = asked {
        return format!(
            "The data prefer the model {preferred} to {asked}, which was asked for. {}",
            conclusion(a)
        );
    }
    conclusion(a)
}

fn conclusion(a: &Answer) -> String {
    for warning in &a.warnings {
        match warning {
            Warning::TooFewCycles { cycles } => {
                return format!(
                    "{}, too few to separate viscous from sliding loss{}.",
                    if *cycles < 1.0 {
                        "Less than one cycle".to_owned()
                    } else {
                        format!("Only {cycles:.1} cycles")
                    },
                    total_loss(a)
                );
            }
            Warning::NotSeparable { decay_times: Some(recorded), .. } if !a.diagnostics.falls => {
                return format!(
                    "The amplitude does not fall: {} is recorded, and no kind of loss can be determined from it.",
                    decay_times(*recorded)
                );
            }
            Warning::NotSeparable { correlation, decay_times: Some(recorded) } => {
                return format!(
                    "{} recorded: viscous and sliding loss cannot be separated, correlation {correlation:.3}{}.",
                    decay_times(*recorded),
                    total_loss(a)
                );
            }
            _ => {}
        }
    }
    if let Some(text) = no_law(a) {
        return text;
    }
    match (law(a).has_sliding(), a.sliding.detected) {
        (true, true) => found(a),
        (true, false) => uncertain(a),
        // Evidence against the viscous law alone that another law without sliding explains.
        (false, true) if !not_preferred(a) => format!(
            "{} describes the record best and contains no sliding friction, but the same law with sliding \
             friction describes the decay better, {}; whether there is sliding friction remains open{}.",
            capital(law(a).name()),
            p_value(a.sliding.p_value),
            open_question(a)
        ),
        (false, true) => format!(
            "Sliding friction is present, {}, but the model {} does not include it.",
            p_value(a.sliding.p_value),
            a.model
        ),
        (false, false) => absent(a),
    }
}

/// The sentence if no law describes the decay.
fn no_law(a: &Answer) -> Option<String> {
    let misfit = a.diagnostics.misfit.filter(|_| !a.diagnostics.law_holds)?;
    Some(format!(
        "No loss law describes this decay: the amplitude deviates from the model {} by {} rms ({} at {}); \
         whether there is sliding friction remains open.",
        a.model,
        exact_percent(misfit.relative_rms),
        exact_percent(misfit.largest),
        plain(misfit.largest_at_s, 4, "s")
    ))
}

/// The simplest law that the data support, or the requested one.
fn law(a: &Answer) -> LossModel {
    if a.preferred_model.is_within(a.model) { a.preferred_model } else { a.model }
}

fn not_preferred(a: &Answer) -> bool {
    a.warnings.iter().any(|w| matches!(w, Warning::ModelNotPreferred { .. }))
}

fn modes_hz(a: &Answer) -> Option<[f64; 2]> {
    a.warnings.iter().find_map(|w| match w {
        Warning::SeveralModes { main_hz, other_hz, .. } => Some([*main_hz, *other_hz]),
        _ => None,
    })
}

/// The second mode with the frequency of the first and its own relative amplitude.
fn second_mode(a: &Answer) -> Option<(&Mode, f64, f64)> {
    let second = a.second_mode.as_ref()?;
    let main_hz = a.parameter(Parameter::Frequency)?.value;
    let strength = second.amplitude.value / a.parameter(Parameter::InitialAmplitude)?.value;
    Some((second, main_hz, strength))
}

/// The total loss, described as one viscous loss.
fn total_loss(a: &Answer) -> String {
    let viscous = a.comparison.iter().find(|c| c.model == LossModel::VISCOUS && c.converged);
    match viscous {
        Some(c) if c.value(Parameter::DECAY_RATE) > 0.0 => {
            format!(
                "; together they damp like a viscous decay rate of {}",
                plain(c.value(Parameter::DECAY_RATE), 3, "1/s")
            )
        }
        _ => String::new(),
    }
}

fn found(a: &Answer) -> String {
    let s = &a.sliding;
    let length_s = a.segment.end_s - a.segment.start_s;
    let end_s = a.fit.rest_s().map_or(a.segment.end_s, |rest_s| rest_s.min(a.segment.end_s));
    let last_s = s.dominates_from_s.map(|t| end_s - t).filter(|last| *last > 0.0);
    let start = percent(s.share_at_highest);
    let share = if a.model == LossModel::SLIDING {
        "Sliding friction carries all of the loss".to_owned()
    } else if s.share_at_highest >= NEARLY_ALL && s.share_at_lowest >= NEARLY_ALL {
        "Sliding friction carries nearly all of the loss throughout".to_owned()
    } else if let Some(last_s) = last_s.filter(|last| *last < length_s) {
        format!(
            "Sliding friction carries {start} of the loss at the start and nearly all of it in the last {}",
            plain(last_s, 2, "s")
        )
    } else if (s.share_at_lowest - s.share_at_highest).abs() < SAME_SHARE {
        format!("Sliding friction carries {start} of the loss")
    } else {
        format!(
            "Sliding friction carries {start} of the loss at the start and {} at the end",
            percent(s.share_at_lowest)
        )
    };
    let more = !a.model.is_within(LossModel::VISCOUS_SLIDING);
    let others = a.model.terms().filter(|term| *term != LossTerm::Sliding);
    let rest = if more { format!(", {} the rest", in_words(others)) } else { String::new() };
    let evidence = if more || !s.viscous_only_excluded {
        format!("a decay without friction is excluded, {}", p_value(s.p_value))
    } else {
        format!("a purely viscous decay is excluded, {}", p_value(s.viscous_only_p_value))
    };
    format!("{share}{rest}; {evidence}{}.", open_question(a))
}

fn uncertain(a: &Answer) -> String {
    format!(
        "Sliding friction is possible but not certain, {}: the model {} describes the decay best; sliding \
         friction would carry {} of the loss at the start.",
        p_value(a.sliding.p_value),
        law(a),
        percent(a.sliding.share_at_highest)
    )
}

fn absent(a: &Answer) -> String {
    let no_viscous = a.parameter(Parameter::DECAY_RATE).is_some_and(|q| q.value == 0.0);
    let acts = |term: &LossTerm| law(a) == LossModel::VISCOUS || *term != LossTerm::Viscous || !no_viscous;
    let terms: Vec<LossTerm> = law(a).terms().filter(acts).collect();
    let explain = if terms.len() == 1 { "alone explains" } else { "explain" };
    let cause = format!("{} {explain}", capital(&in_words(terms.into_iter())));
    // A term whose interval excludes zero is possible, whichever model has the lower BIC.
    let possible = a.parameter(Parameter::FRICTION_DISPLACEMENT).filter(|q| q.interval_95[0] > 0.0);
    if let Some(q) = possible {
        return format!(
            "{cause} the decay; sliding friction is possible but not certain, {}: x_F lies between {} and {} (95 %){}.",
            p_value(a.sliding.p_value),
            plain(q.interval_95[0], 2, &q.unit),
            plain(q.interval_95[1], 2, &q.unit),
            open_question(a)
        );
    }
    let limit = [(Parameter::FRICTION_DISPLACEMENT, "x_F is"), (Parameter::SlidingRate, "its loss rate is")]
        .into_iter()
        .find_map(|(parameter, is)| a.parameter(parameter).map(|q| (q.interval_95[1], q.unit.as_str(), is)))
        .filter(|(high, ..)| high.is_finite() && *high > 0.0)
        .map(|(high, unit, is)| format!(": {is} below {} (95 %)", plain(high, 2, unit)))
        .unwrap_or_default();
    format!(
        "{cause} the decay; no sliding friction is found, {}{limit}{}.",
        p_value(a.sliding.p_value),
        open_question(a)
    )
}

fn open_question(a: &Answer) -> String {
    let rival = a.warnings.iter().find_map(|w| match w {
        Warning::AmbiguousModel { rival, .. } => Some(*rival),
        _ => None,
    });
    match rival {
        Some(rival) if rival.has_sliding() == law(a).has_sliding() => {
            format!("; which model describes the loss, {} or {rival}, remains open", law(a))
        }
        Some(rival) => format!("; {rival} describes the record as well"),
        None => String::new(),
    }
}

/// The losses in words: `viscous damping and quadratic drag`.
fn in_words(terms: impl Iterator<Item = LossTerm>) -> String {
    let words: Vec<&str> = terms.map(LossTerm::words).collect();
    match words.split_last() {
        Some((last, [])) => (*last).to_owned(),
        Some((last, first)) => format!("{} and {last}", first.join(", ")),
        None => String::new(),
    }
}

fn capital(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sentence;
    use crate::document::ParameterRow;
    use crate::example;
    use slipfit::Quantity;

    #[test]
    fn found_sliding_is_told_by_its_shares() {
        let mut a = example::answer();
        a.sliding.share_at_highest = 0.41;
        a.sliding.dominates_from_s = Some(a.segment.end_s - 8.0);
        assert_eq!(
            a.sentence(),
            "Sliding friction carries 41 % of the loss at the start and nearly all of it in the last 7.6 s; a purely \
             viscous decay is excluded, p < 1e-12."
        );
        a.sliding.dominates_from_s = None;
        a.sliding.share_at_lowest = 0.78;
        a.sliding.viscous_only_p_value = 3.2e-5;
        assert_eq!(
            a.sentence(),
            "Sliding friction carries 41 % of the loss at the start and 78 % at the end; a purely viscous decay is \
             excluded, p = 3e-5."
        );
        a.model = LossModel::VISCOUS_SLIDING_DRAG;
        assert_eq!(
            a.sentence(),
            "Sliding friction carries 41 % of the loss at the start and 78 % at the end, viscous damping and \
             quadratic drag the rest; a decay without friction is excluded, p < 1e-12."
        );
        a.model = LossModel::SLIDING;
        a.sliding.viscous_only_p_value = 0.0;
        assert_eq!(
            a.sentence(),
            "Sliding friction carries all of the loss; a purely viscous decay is excluded, p < 1e-12."
        );
    }

    #[test]
    fn sliding_not_found_comes_with_its_upper_limit() {
        let mut a = example::answer();
        a.model = LossModel::VISCOUS;
        a.sliding.detected = false;
        a.sliding.p_value = 0.42;
        let mut x_f = Quantity::normal(0.0, 1e-4, "rad");
        x_f.interval_95 = [0.0, 2.5e-4];
        a.parameters.remove(Parameter::FRICTION_DISPLACEMENT);
        a.parameters.remove(Parameter::SlidingRate);
        assert_eq!(
            a.sentence(),
            "Viscous damping alone explains the decay; no sliding friction is found, p = 0.42."
        );
        a.parameters.set(Parameter::FRICTION_DISPLACEMENT, x_f);
        assert_eq!(
            a.sentence(),
            "Viscous damping alone explains the decay; no sliding friction is found, p = 0.42: x_F is below \
             250 µrad (95 %)."
        );
        let mut x_f = a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().clone();
        x_f.interval_95 = [3.1e-5, 2.5e-4];
        a.parameters.set(Parameter::FRICTION_DISPLACEMENT, x_f.clone());
        assert_eq!(
            a.sentence(),
            "Viscous damping alone explains the decay; sliding friction is possible but not certain, p = 0.42: x_F \
             lies between 31 µrad and 250 µrad (95 %)."
        );
        x_f.interval_95[0] = 0.0;
        a.parameters.set(Parameter::FRICTION_DISPLACEMENT, x_f);
        a.model = LossModel::VISCOUS_DRAG;
        a.warnings = vec![Warning::AmbiguousModel {
            chosen: LossModel::VISCOUS_DRAG,
            rival: LossModel::VISCOUS_SLIDING,
            delta_bic: 0.7,
        }];
        assert!(a.sentence().starts_with("Viscous damping and quadratic drag explain the decay; no sliding"));
        assert!(a.sentence().ends_with("; viscous+sliding describes the record as well."));
    }

    #[test]
    fn an_upper_limit_has_the_digits_of_its_interval() {
        let mut a = example::answer();
        a.model = LossModel::VISCOUS;
        a.sliding.detected = false;
        let x_f = Quantity { interval_95: [0.0, 2.84e-6], ..Quantity::normal(0.0, 1.45e-6, "m") };
        a.parameters.set(Parameter::FRICTION_DISPLACEMENT, x_f.clone());
        let row = ParameterRow::new(Parameter::FRICTION_DISPLACEMENT, &x_f);
        assert_eq!([row.interval.as_str(), row.unit.as_str()], ["0.0 to 2.8", "µm"]);
        assert!(a.sentence().ends_with("x_F is below 2.8 µm (95 %)."), "{}", a.sentence());
    }

    #[test]
    fn what_cannot_be_told_is_said_with_its_number() {
        let mut a = example::answer();
        a.warnings = vec![Warning::NotSeparable { correlation: -0.9991, decay_times: Some(0.7) }];
        assert_eq!(
            a.sentence(),
            "0.7 of a decay time recorded: viscous and sliding loss cannot be separated, correlation \
             -0.999; together they damp like a viscous decay rate of 0.0302 1/s."
        );
        a.warnings = vec![Warning::TooFewCycles { cycles: 3.1 }];
        assert!(a.sentence().starts_with("Only 3.1 cycles, too few to separate"));
        a.warnings = vec![Warning::SeveralModes { main_hz: 80.5, other_hz: 297.7, relative_amplitude: 0.4 }];
        assert!(a.sentence().starts_with("The record contains more than one mode (80.5 Hz and 297.7 Hz);"));
    }

    #[test]
    fn a_model_asked_for_against_the_data_says_so() {
        let mut a = example::answer();
        a.model = LossModel::VISCOUS;
        a.warnings = vec![Warning::ModelNotPreferred {
            asked: LossModel::VISCOUS,
            preferred: LossModel::VISCOUS_SLIDING,
            delta_bic: 900.0,
        }];
        assert_eq!(
            a.sentence(),
            "The data prefer the model viscous+sliding to viscous, which was asked for. Sliding friction is present, \
             p < 1e-12, but the model viscous does not include it."
        );
        a.model = LossModel::VISCOUS_SLIDING;
        a.warnings = vec![Warning::ModelUndetermined {
            asked: LossModel::VISCOUS_SLIDING.with(LossTerm::Drag),
            reported: LossModel::VISCOUS_SLIDING,
        }];
        let sentence = a.sentence();
        let start = "The data do not determine all of viscous+sliding+drag; viscous+sliding is reported. ";
        assert!(sentence.starts_with(start), "{sentence}");
    }

    #[test]
    fn evidence_that_another_law_takes_up_is_left_open() {
        let mut a = example::answer();
        a.model = LossModel::VISCOUS_DRAG;
        a.sliding.p_value = 1e-4;
        assert_eq!(
            a.sentence(),
            "Viscous+drag describes the record best and contains no sliding friction, but the same law \
             with sliding friction describes the decay better, p = 1e-4; whether there is sliding \
             friction remains open."
        );
    }

    #[test]
    fn weak_evidence_is_called_weak() {
        let mut a = example::answer();
        a.sliding.detected = false;
        a.sliding.p_value = 0.03;
        a.sliding.share_at_highest = 0.05;
        assert_eq!(
            a.sentence(),
            "Sliding friction is possible but not certain, p = 0.03: the model viscous+sliding describes the \
             decay best; sliding friction would carry 5 % of the loss at the start."
        );
    }
}
