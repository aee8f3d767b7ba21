//! One measurement of a series, analysed by itself.

use super::Data;
use super::answer::SingleAnswer;
use crate::model::loss::{LossModel, LossTerm};
use crate::{Error, levels, resonance, ringdown};

/// Viscous damping and sliding friction of a measurement, with its other terms.
pub(super) struct ComparedAnswers {
    pub(super) without_drag: SingleAnswer,
    /// The same with drag, if it may or may not have it.
    pub(super) with_drag: Option<SingleAnswer>,
}

/// The answer for the given options, and the answers compared with other measurements.
pub(super) fn analyse_one(data: &Data) -> (Result<SingleAnswer, Error>, Option<ComparedAnswers>) {
    match data {
        Data::RingDown { record, options } => {
            let analyse = |model: Option<LossModel>| {
                ringdown::analyse(record, &ringdown::Options { model, ..(**options).clone() })
            };
            let answer = match analyse(options.model) {
                Ok(answer) => answer,
                Err(e) => return (Err(e), None),
            };
            let by = |model: LossModel| {
                let found = if answer.model == model && options.model.is_some() {
                    Some(answer.clone())
                } else {
                    analyse(Some(model)).ok()
                };
                found.map(|found| SingleAnswer::RingDown(Box::new(found)))
            };
            let both = answer.model.with(LossTerm::Viscous).with(LossTerm::Sliding);
            let compared = if options.model.is_some() {
                by(both).map(ComparedAnswers::alone)
            } else {
                let without = both.without(&[LossTerm::Drag]).and_then(by);
                let with_drag = by(both.with(LossTerm::Drag));
                match (without, with_drag) {
                    (Some(without_drag), with_drag) => Some(ComparedAnswers { without_drag, with_drag }),
                    (None, with_drag) => with_drag.map(ComparedAnswers::alone),
                }
            };
            (Ok(SingleAnswer::RingDown(Box::new(answer))), compared)
        }
        Data::Sweep { curve, options } => {
            let analyse = |model: Option<LossModel>| {
                resonance::analyse(curve, &resonance::Options { model, ..(**options).clone() })
            };
            let answer = match analyse(options.model) {
                Ok(answer) => answer,
                Err(e) => return (Err(e), None),
            };
            const BOTH: LossModel = LossModel::VISCOUS_SLIDING;
            let both = if answer.model == BOTH { Some(answer.clone()) } else { analyse(Some(BOTH)).ok() };
            let single = |answer| SingleAnswer::Sweep(Box::new(answer));
            let with_drag =
                if options.model.is_none() { analyse(Some(BOTH.with(LossTerm::Drag))).ok() } else { None };
            let compared = both
                .map(|both| ComparedAnswers { without_drag: single(both), with_drag: with_drag.map(single) });
            (Ok(single(answer)), compared)
        }
        // Levels have no other model.
        Data::Levels { levels, options } => match levels::analyse(levels, options) {
            Ok(answer) => {
                let single = SingleAnswer::Levels(Box::new(answer));
                (Ok(single.clone()), Some(ComparedAnswers::alone(single)))
            }
            Err(e) => (Err(e), None),
        },
    }
}

impl ComparedAnswers {
    fn alone(without_drag: SingleAnswer) -> Self {
        Self { without_drag, with_drag: None }
    }
}
