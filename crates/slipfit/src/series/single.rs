//! One measurement of a series, analysed by itself.

use super::Data;
use super::answer::SingleAnswer;
use crate::model::loss::{LossModel, LossTerm};
use crate::{Error, levels, resonance, ringdown};

/// The answer as asked for, and the one with viscous damping and sliding friction, beside what else a ring-down has.
pub(super) fn analyse_one(data: &Data) -> (Result<SingleAnswer, Error>, Option<SingleAnswer>) {
    match data {
        Data::RingDown { record, options } => asked_and_both(
            |forced| {
                let model = forced.or(options.model);
                ringdown::analyse(record, &ringdown::Options { model, ..(**options).clone() })
            },
            |answer| answer.model.with(LossTerm::Viscous).with(LossTerm::Sliding),
            |answer| answer.model,
            |answer| SingleAnswer::RingDown(Box::new(answer)),
        ),
        Data::Sweep { curve, options } => asked_and_both(
            |forced| {
                let model = forced.or(options.model);
                resonance::analyse(curve, &resonance::Options { model, ..(**options).clone() })
            },
            |_| LossModel::VISCOUS_SLIDING,
            |answer| answer.model,
            |answer| SingleAnswer::Sweep(Box::new(answer)),
        ),
        // Levels know no other model.
        Data::Levels { levels, options } => asked_and_both(
            |_| levels::analyse(levels, options),
            |_| LossModel::VISCOUS_SLIDING,
            |_| LossModel::VISCOUS_SLIDING,
            |answer| SingleAnswer::Levels(Box::new(answer)),
        ),
    }
}

/// An analysis as asked for, and once more where its model is not the one that is `compared`.
fn asked_and_both<A: Clone>(
    analyse: impl Fn(Option<LossModel>) -> Result<A, Error>,
    compared: impl Fn(&A) -> LossModel,
    model: impl Fn(&A) -> LossModel,
    single: impl Fn(A) -> SingleAnswer,
) -> (Result<SingleAnswer, Error>, Option<SingleAnswer>) {
    let answer = match analyse(None) {
        Ok(answer) => answer,
        Err(e) => return (Err(e), None),
    };
    let compared = compared(&answer);
    let both = if model(&answer) == compared { Some(answer.clone()) } else { analyse(Some(compared)).ok() };
    (Ok(single(answer)), both.map(single))
}
