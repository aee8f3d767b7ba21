//! The JSON answer: docs/json.md; schemas in docs/schema.
//!
//! An answer serialises as it is (feature `serde` of the core); around it stand the version of the
//! contract, what was read, what was asked, and the answer in a sentence.

mod input;
mod layout;
mod options;
mod series;

pub use layout::write;
pub use series::series;

use crate::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, Sentence};
use input::{CurveInput, LevelsInput, RecordInput};
use options::{CurveOptions, LevelsOptions, RecordOptions};
use serde::Serialize;
use std::io::{self, Write};

/// Version of the program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What stands around an answer.
#[derive(Serialize)]
struct Envelope<'a, I, O, A> {
    /// Name and version of this contract: the number grows when a key changes its meaning or
    /// vanishes; new keys may come at any time.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    /// The command that wrote it.
    command: &'static str,
    /// The file and how it was read.
    input: I,
    #[serde(flatten)]
    more: Option<Reference<'a>>,
    /// What the person fixed; null was left to the analysis.
    options: O,
    /// The answer in words.
    sentence: String,
    #[serde(flatten)]
    answer: &'a A,
}

/// What a resonance curve has beside its own file.
#[derive(Serialize)]
struct Reference<'a> {
    /// The friction-free reference and how it was read; null without one.
    reference_input: Option<CurveInput<'a>>,
}

/// Writes the whole answer to a ring-down.
pub fn ringdown(out: &mut dyn Write, analysed: &AnalysedRingdown<'_>) -> io::Result<()> {
    let envelope = Envelope {
        schema: "slipfit/ringdown-1",
        version: VERSION,
        command: "ringdown",
        input: RecordInput::new(analysed),
        more: None,
        options: RecordOptions::new(analysed.options),
        sentence: analysed.answer.sentence(),
        answer: analysed.answer,
    };
    write(out, &envelope)
}

/// Writes the whole answer to a resonance curve.
pub fn resonance(out: &mut dyn Write, analysed: &AnalysedCurve<'_>) -> io::Result<()> {
    let envelope = Envelope {
        schema: "slipfit/resonance-1",
        version: VERSION,
        command: "resonance",
        input: CurveInput::new(analysed.reading),
        more: Some(Reference { reference_input: analysed.reference.map(CurveInput::new) }),
        options: CurveOptions::new(analysed.options),
        sentence: analysed.answer.sentence(),
        answer: analysed.answer,
    };
    write(out, &envelope)
}

/// Writes the whole answer to drive levels.
pub fn levels(out: &mut dyn Write, analysed: &AnalysedLevels<'_>) -> io::Result<()> {
    let envelope = Envelope {
        schema: "slipfit/levels-1",
        version: VERSION,
        command: "levels",
        input: LevelsInput::new(analysed),
        more: None,
        options: LevelsOptions::new(analysed.options),
        sentence: analysed.answer.sentence(),
        answer: analysed.answer,
    };
    write(out, &envelope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::by_hand;
    use serde_json::{Value, json};
    use slipfit::Parameter;
    use slipfit::ringdown::Answer;

    #[test]
    fn what_is_not_finite_is_null() {
        let spoil = |answer: &mut Answer| {
            let frequency = answer.parameters.get_mut(Parameter::Frequency).unwrap();
            frequency.value = f64::NAN;
            frequency.interval_95 = [f64::NEG_INFINITY, f64::INFINITY];
            answer.sliding.p_value = f64::NAN;
            answer.envelope[0].fitted = f64::NAN;
        };
        let mut text = Vec::new();
        by_hand(spoil, |analysed| ringdown(&mut text, analysed)).unwrap();
        let json: Value = serde_json::from_slice(&text).unwrap();
        let frequency = &json["parameters"]["frequency_hz"];
        assert_eq!(frequency["value"], Value::Null);
        assert_eq!(frequency["interval_95"], json!([null, null]));
        assert_eq!(json["sliding"]["p_value"], Value::Null);
        assert_eq!(json["envelope"]["fitted"][0], Value::Null);
    }
}
