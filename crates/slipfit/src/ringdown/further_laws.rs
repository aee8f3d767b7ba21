//! Laws tried where those that every analysis compares leave a misfit with a name.

use super::Answer;
use super::criteria::MisfitCriteria;
use super::window::EndReason;
use crate::answer::{MisfitShape, Warning};
use crate::model::loss::{LossModel, LossTerm};

/// Whether the free decay ends where the amplitudes leave the laws compared.
fn is_cut(answer: &Answer) -> bool {
    matches!(answer.segment.end_reason, EndReason::LawChange | EndReason::SlowTail)
}

/// Whether the misfit is one that a missing loss leaves: a second mode and disturbances leave others.
fn lacks_a_loss(answer: &Answer, criteria: &MisfitCriteria) -> bool {
    let shape = answer.diagnostics.misfit.map(|m| m.shape);
    let of_a_loss =
        matches!(shape, Some(MisfitShape::Bow | MisfitShape::Kink { .. } | MisfitShape::End { .. }));
    // Where the motion is nowhere near a law the search for one takes a hundred times as long, for nothing.
    let near_a_law = answer.diagnostics.misfit.is_none_or(|m| m.relative_rms < criteria.further_law_misfit);
    let enough = answer.segment.cycles > criteria.further_law_cycles;
    (of_a_loss || is_cut(answer)) && near_a_law && enough && answer.second_mode.is_none()
}

/// Tries each loss whose shape is fitted beside viscous, sliding and drag loss, and says of the best that it
/// describes the decay better: by its BIC among all models on the same data, its parameter of the shape
/// counted, and by what it leaves, or by how much more of the decay it holds where the laws compared end
/// before it does. The answer stays that of the laws compared.
///
/// `refit` is the answer with the terms of a model compared as well.
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
