//! The JSON answer: docs/json.md; schemas in docs/schema.
//!
//! An answer is serialised as it is (feature `serde` of the core). It is wrapped in an envelope with the version
//! of the contract, what was read, which options were used, and the answer in a sentence.

mod input;
mod layout;
mod object;
mod options;
#[cfg(test)]
mod schema;
mod series;
mod simulated;

pub use series::series;
pub use simulated::{SimulatedColumn, SimulatedParameter, SimulatedRecord};

use crate::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, Sentence};
use input::{CurveInput, LevelsInput, RecordInput};
use layout::write;
use options::{CurveOptions, LevelsOptions, RecordOptions};
use serde::Serialize;
use std::io::{self, Write};

/// Version of the program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Envelope around an answer.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Envelope<'a, I, O, A> {
    /// Name and version of this contract. The version increases when a key changes its meaning or is removed; new
    /// keys may be added at any time.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    /// The command that wrote it.
    command: &'static str,
    #[serde(flatten)]
    read: I,
    /// Options fixed by the user; null was left to the analysis.
    options: O,
    /// The answer in words.
    sentence: String,
    #[serde(flatten)]
    answer: &'a A,
}

/// One file.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct OneFile<I> {
    /// The file and how it was read.
    input: I,
}

/// A curve and its reference.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CurveFiles<'a> {
    /// The curve and how it was read.
    input: CurveInput<'a>,
    /// The friction-free reference and how it was read; null if there is none.
    reference_input: Option<CurveInput<'a>>,
}

type RingdownEnvelope<'a> = Envelope<'a, OneFile<RecordInput<'a>>, RecordOptions, slipfit::ringdown::Answer>;
type CurveEnvelope<'a> = Envelope<'a, CurveFiles<'a>, CurveOptions, slipfit::resonance::Answer>;
type LevelsEnvelope<'a> = Envelope<'a, OneFile<LevelsInput<'a>>, LevelsOptions, slipfit::levels::Answer>;

/// Writes the whole answer to a ring-down.
pub fn ringdown(out: &mut dyn Write, analysed: &AnalysedRingdown<'_>) -> io::Result<()> {
    let envelope = RingdownEnvelope {
        schema: "slipfit/ringdown-1",
        version: VERSION,
        command: "ringdown",
        read: OneFile { input: RecordInput::new(analysed) },
        options: RecordOptions::new(analysed.options),
        sentence: analysed.answer.sentence(),
        answer: analysed.answer,
    };
    write(out, &envelope)
}

/// Writes the whole answer to a resonance curve.
pub fn resonance(out: &mut dyn Write, analysed: &AnalysedCurve<'_>) -> io::Result<()> {
    let envelope = CurveEnvelope {
        schema: "slipfit/resonance-1",
        version: VERSION,
        command: "resonance",
        read: CurveFiles {
            input: CurveInput::new(analysed.reading),
            reference_input: analysed.reference.map(CurveInput::new),
        },
        options: CurveOptions::new(analysed.options),
        sentence: analysed.answer.sentence(),
        answer: analysed.answer,
    };
    write(out, &envelope)
}

/// Writes the whole answer to drive levels.
pub fn levels(out: &mut dyn Write, analysed: &AnalysedLevels<'_>) -> io::Result<()> {
    let envelope = LevelsEnvelope {
        schema: "slipfit/levels-1",
        version: VERSION,
        command: "levels",
        read: OneFile { input: LevelsInput::new(analysed) },
        options: LevelsOptions::new(analysed.options),
        sentence: analysed.answer.sentence(),
        answer: analysed.answer,
    };
    write(out, &envelope)
}

/// Writes a simulated record.
pub fn simulated(out: &mut dyn Write, record: &SimulatedRecord<'_>) -> io::Result<()> {
    write(out, record)
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
