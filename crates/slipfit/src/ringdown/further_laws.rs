//! Laws tried where those that every analysis compares leave a misfit with a name.

use super::Answer;
use super::criteria::MisfitCriteria;
use crate::answer::{MisfitShape, Warning};
use crate::model::loss::{LossModel, LossTerm};

/// Whether the misfit is one that a missing loss leaves: a second mode and disturbances leave others.
fn lacks_a_loss(answer: &Answer) -> bool {
    let shape = answer.diagnostics.misfit.map(|m| m.shape);
    let of_a_loss =
        matches!(shape, Some(MisfitShape::Bow | MisfitShape::Kink { .. } | MisfitShape::End { .. }));
    // Where no law holds at all the search for one takes a hundred times as long, for nothing.
    of_a_loss && answer.diagnostics.law_holds && answer.second_mode.is_none()
}

/// Tries each loss whose shape is fitted beside viscous, sliding and drag loss, and says of the best that it
/// describes the decay better: by its BIC among all models on the same data, its parameter of the shape
/// counted, and by what it leaves. The answer stays that of the laws compared.
///
/// `refit` is the answer with the terms of a model compared as well.
pub(crate) fn try_further_laws(
    answer: &mut Answer,
    criteria: &MisfitCriteria,
    refit: impl Fn(LossModel) -> Option<Answer>,
) {
    if !lacks_a_loss(answer) {
        return;
    }
    let (left, length_s) =
        (answer.diagnostics.residual_excess, answer.segment.end_s - answer.segment.start_s);
    let better = |term: &LossTerm| {
        let found = refit(LossModel::VISCOUS_SLIDING_DRAG.with(*term))?;
        let model = found.preferred_model;
        let plain = found.comparison.iter().filter(|c| !c.model.has(*term));
        let plain = plain.map(|c| c.bic).fold(f64::INFINITY, f64::min);
        let own = found.comparison.iter().find(|c| c.model == model)?.bic;
        let excess = found.diagnostics.residual_excess;
        let explains = excess < criteria.further_law_left * left
            && found.segment.end_s - found.segment.start_s > criteria.further_law_window * length_s;
        let better = model.has(*term) && plain - own > criteria.further_law_bic;
        (better && explains).then(|| Warning::FurtherLaw {
            model,
            delta_bic: plain - own,
            ratio: excess.sqrt(),
        })
    };
    let gain = |w: &Warning| if let Warning::FurtherLaw { delta_bic, .. } = w { *delta_bic } else { 0.0 };
    let found = LossTerm::shaped().iter().filter_map(better);
    answer.warnings.extend(found.max_by(|a, b| gain(a).total_cmp(&gain(b))));
}
