//! Further loss laws, tried if the laws compared by default leave a misfit of a recognised shape.

use super::Answer;
use super::criteria::MisfitCriteria;
use super::window::EndReason;
use crate::answer::{Candidate, MisfitShape, Parameter, Warning};
use crate::model::loss::{LossModel, LossTerm};

/// Whether the free decay ends where the amplitudes depart from the laws compared.
fn is_cut(answer: &Answer) -> bool {
    matches!(answer.segment.end_reason, EndReason::LawChange | EndReason::SlowTail)
}

/// Whether the misfit has the shape caused by a missing loss; a second mode and disturbances cause other
/// shapes.
fn lacks_a_loss(answer: &Answer, criteria: &MisfitCriteria) -> bool {
    let shape = answer.diagnostics.misfit.map(|m| m.shape);
    let of_a_loss =
        matches!(shape, Some(MisfitShape::Bow | MisfitShape::Kink { .. } | MisfitShape::End { .. }));
    // If the motion is far from any law, the search takes a hundred times as long and finds nothing.
    let near_a_law = answer.diagnostics.misfit.is_none_or(|m| m.relative_rms < criteria.further_law_misfit);
    let enough = answer.segment.cycles > criteria.further_law_cycles;
    (of_a_loss || is_cut(answer)) && near_a_law && enough && answer.second_mode.is_none()
}

/// Tries each loss with a fitted shape in addition to viscous, sliding and drag loss. Warns that the best of
/// them describes the decay better if its BIC, with the shape parameter counted, is lower than that of all
/// other models on the same data, and if it leaves smaller residuals or, if the laws compared end before the
/// decay does, covers more of the decay. The answer itself remains that of the laws compared.
///
/// `refit` gives the answer with the terms of a further model included in the comparison.
pub(crate) fn try_further_laws(
    answer: &mut Answer,
    criteria: &MisfitCriteria,
    refit: impl Fn(LossModel) -> Option<Answer>,
) {
    if !lacks_a_loss(answer, criteria) {
        return;
    }
    let (left, length_s) =
        (answer.diagnostics.residual_excess, answer.segment.end_s - answer.segment.start_s);
    let answer_so_far: &Answer = answer;
    let better = |term: &LossTerm| {
        let found = refit(LossModel::VISCOUS_SLIDING.with(*term))?;
        let model = found.preferred_model;
        let plain = found.comparison.iter().filter(|c| !c.model.has(*term));
        let plain = plain.map(|c| c.bic).fold(f64::INFINITY, f64::min);
        let own = found.comparison.iter().find(|c| c.model == model)?.bic;
        let excess = found.diagnostics.residual_excess;
        let described = (found.segment.end_s - found.segment.start_s) / length_s;
        let explains = if is_cut(answer_so_far) {
            described > criteria.further_law_longer
        } else {
            excess < criteria.further_law_left * left && described > criteria.further_law_window
        };
        let better = model.has(*term) && plain - own > criteria.further_law_bic;
        (better && explains).then(|| Warning::FurtherLaw {
            model,
            delta_bic: plain - own,
            ratio: excess.sqrt(),
        })
    };
    let gain = |w: &Warning| if let Warning::FurtherLaw { delta_bic, .. } = w { *delta_bic } else { 0.0 };
    let found = LossTerm::shaped().iter().filter_map(better);
    let best = found.max_by(|a, b| gain(a).total_cmp(&gain(b)));
    answer.warnings.extend(best);
}

/// If the data prefer a model with drag, compares drag with each other loss of a fixed power of the
/// amplitude. Warns if one of them explains the decay equally well and gives a different viscous or sliding
/// loss: a few per cent of a loss proportional to the cube of the amplitude resemble drag plus friction.
///
/// `refit` gives the answer with the terms of a further model included in the comparison; both BIC refer to
/// the same data.
pub(crate) fn try_rivals_of_drag(
    answer: &mut Answer,
    rival_bic: f64,
    refit: impl Fn(LossModel) -> Option<Answer>,
) {
    let is_open = answer.warnings.iter().any(leaves_the_law_open);
    if !answer.preferred_model.has(LossTerm::Drag) || answer.second_mode.is_some() || is_open {
        return;
    }
    let preferred = answer.preferred_model;
    let rival = |term: &LossTerm| {
        let found = refit(LossModel::VISCOUS_SLIDING.with(*term))?;
        let own = found.comparison.iter().find(|c| c.model == preferred)?;
        let others = found.comparison.iter().filter(|c| c.model.has(*term) && !c.model.has(LossTerm::Drag));
        let rival = others.min_by(|a, b| a.bic.total_cmp(&b.bic))?;
        let delta_bic = rival.bic - own.bic;
        (delta_bic < rival_bic && !is_covered(answer, rival)).then_some(Warning::AmbiguousModel {
            chosen: own.model,
            rival: rival.model,
            delta_bic,
        })
    };
    let others = LossTerm::further().iter().filter(|term| !term.is_shaped());
    let found = others.filter_map(rival).next();
    answer.warnings.extend(found);
}

/// Whether a warning already states that the law is not determined.
fn leaves_the_law_open(warning: &Warning) -> bool {
    matches!(
        warning,
        Warning::AmbiguousModel { .. } | Warning::NotSeparable { .. } | Warning::ModelMisfit { .. }
    )
}

/// Whether viscous and sliding loss of a candidate lie within the intervals of an answer.
fn is_covered(answer: &Answer, candidate: &Candidate) -> bool {
    [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT].into_iter().all(|parameter| {
        let Some(reported) = answer.parameter(parameter) else { return true };
        let [low, high] = reported.interval_95;
        (low..=high).contains(&candidate.value(parameter).max(0.0))
    })
}

#[cfg(test)]
mod tests {
    use crate::noise::{jitter, motion};
    use crate::ringdown::{Options, analyse};
    use crate::{LossModel, LossTerm, Record, answer::Warning};

    const DELTA: f64 = 0.16;
    const OMEGA: f64 = 31.4;

    /// Number of records out of ten, each of 20 s with this noise, in which another power is reported as a
    /// rival of drag.
    fn count_warned(force: impl Fn(f64, f64) -> f64, noise: f64) -> usize {
        let restored = |x: f64, v: f64| -OMEGA * OMEGA * x - 2.0 * DELTA * v + force(x, v);
        let exact = motion(restored, 1.0, 4000, 0.005, 8);
        let warns = |repeat: &usize| {
            let noisy = exact.iter().enumerate().map(|(i, [x, _])| x + noise * jitter(i + 4000 * repeat, 2));
            let record = Record::uniform(200.0, noisy.collect()).expect("valid");
            let answer = analyse(&record, &Options::default()).expect("a ring-down");
            let cubic = LossModel::VISCOUS.with(LossTerm::Cubic);
            let is_rival =
                |w: &Warning| matches!(w, Warning::AmbiguousModel { rival, .. } if cubic.is_within(*rival));
            answer.warnings.iter().any(is_rival)
        };
        (0..10).filter(warns).count()
    }

    #[test]
    fn cubic_damping_that_resembles_drag_gives_a_warning() {
        assert!(count_warned(|x, v| -DELTA * x * x * v, 0.01) >= 8);
        assert_eq!(count_warned(|_, v| -0.004 * v.abs() * v, 0.001), 0);
        assert_eq!(count_warned(|_, _| 0.0, 0.01), 0);
    }
}
