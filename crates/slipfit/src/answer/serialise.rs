//! JSON forms that derives do not provide: names for parameters and models, maps for lists of pairs, columns for lists
//! of points.

use super::comparison::{SlidingEvidence, Values};
use super::hint::{Hint, HintValue};
use super::parameter::{Parameter, Parameters};
use super::warning::Warning;
use crate::model::loss::LossModel;
use serde::{Serialize, Serializer};

impl Serialize for Parameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

/// A warning with its text and hints.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "Warning"))]
struct WarningText {
    /// Machine-readable code.
    #[cfg_attr(feature = "schema", schemars(extend("pattern" = "^[a-z_]+$")))]
    code: &'static str,
    /// What was found.
    message: String,
    /// Hints on what to do.
    hints: Vec<HintText>,
}

/// An option that helps, named by its field, with a value if known.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "Hint"))]
struct HintText {
    /// The option, by its name in the library; null if no option helps.
    option: Option<&'static str>,
    /// A value for it; null if none is known.
    value: Option<ValueText>,
    /// What the option does.
    advice: String,
}

/// A number or a range in the unit of the option, or a word.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "HintValue"))]
#[serde(untagged)]
enum ValueText {
    Number(f64),
    Range([f64; 2]),
    Text(String),
}

impl From<Hint> for HintText {
    fn from(hint: Hint) -> Self {
        let value = hint.value.map(|value| match value {
            HintValue::Number(number) => ValueText::Number(number),
            HintValue::Range(limits) => ValueText::Range(limits),
            HintValue::Text(word) => ValueText::Text(word),
        });
        Self { option: hint.option, value, advice: hint.advice.into_owned() }
    }
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let hints = self.hints().into_iter().map(HintText::from).collect();
        WarningText { code: self.code(), message: self.to_string(), hints }.serialize(serializer)
    }
}

impl Serialize for LossModel {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// Evidence for sliding friction in a decay; its shares of the loss are named by their place in the decay.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct DecayEvidence {
    /// Whether sliding friction is detected: `p_value` is below 0.01 and the BIC prefers it.
    detected: bool,
    /// p value of the data without sliding friction, one-sided.
    p_value: f64,
    /// BIC of the best model without sliding friction minus that of the best model with it.
    delta_bic: f64,
    /// Share of sliding friction in the loss at the start.
    share_at_start: f64,
    /// Share of sliding friction in the loss at the end.
    share_at_end: f64,
    /// Instant, s, from which sliding friction accounts for more than 95 % of the loss.
    dominates_from_s: Option<f64>,
    /// p value of a purely viscous loss.
    viscous_only_p_value: f64,
}

pub(crate) fn decay_evidence<S: Serializer>(e: &SlidingEvidence, serializer: S) -> Result<S::Ok, S::Error> {
    let named = DecayEvidence {
        detected: e.detected,
        p_value: e.p_value,
        delta_bic: e.delta_bic,
        share_at_start: e.share_at_highest,
        share_at_end: e.share_at_lowest,
        dominates_from_s: e.dominates_from_s,
        viscous_only_p_value: e.viscous_only_p_value,
    };
    named.serialize(serializer)
}

/// Evidence for sliding friction in a resonance curve; its shares of the loss are named by their place in the curve.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct CurveEvidence {
    /// Whether sliding friction is detected: `p_value` is below 0.01 and the BIC prefers it.
    detected: bool,
    /// p value of the data without sliding friction, one-sided.
    p_value: f64,
    /// BIC of the best model without sliding friction minus that of the best model with it.
    delta_bic: f64,
    /// Share of sliding friction in the loss at the peak.
    share_at_peak: f64,
    /// Share of sliding friction in the loss at the lowest amplitude used.
    share_at_lowest: f64,
    /// p value of a purely viscous loss.
    viscous_only_p_value: f64,
}

pub(crate) fn curve_evidence<S: Serializer>(e: &SlidingEvidence, serializer: S) -> Result<S::Ok, S::Error> {
    let named = CurveEvidence {
        detected: e.detected,
        p_value: e.p_value,
        delta_bic: e.delta_bic,
        share_at_peak: e.share_at_highest,
        share_at_lowest: e.share_at_lowest,
        viscous_only_p_value: e.viscous_only_p_value,
    };
    named.serialize(serializer)
}

/// A value with its standard error as two keys.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct ConditionValue {
    /// Value of the condition; null if it is not a number.
    value: Option<f64>,
    /// Its standard error.
    value_std_error: Option<f64>,
}

pub(crate) fn condition_value<S: Serializer>(
    value: &Option<[f64; 2]>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    ConditionValue { value: value.map(|v| v[0]), value_std_error: value.map(|v| v[1]) }.serialize(serializer)
}

#[cfg(feature = "schema")]
mod schema {
    use super::*;
    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
    use std::borrow::Cow;
    use std::collections::BTreeMap;

    macro_rules! names {
        ($type:ty, $name:literal, $all:expr) => {
            impl JsonSchema for $type {
                fn schema_name() -> Cow<'static, str> {
                    $name.into()
                }

                fn json_schema(_: &mut SchemaGenerator) -> Schema {
                    let names: Vec<&str> = $all.map(|item| item.name()).collect();
                    json_schema!({ "type": "string", "enum": names })
                }
            }
        };
    }

    names!(Parameter, "Parameter", Parameter::all());
    names!(LossModel, "LossModel", LossModel::all());

    impl JsonSchema for Warning {
        fn schema_name() -> Cow<'static, str> {
            WarningText::schema_name()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            WarningText::json_schema(generator)
        }
    }

    /// Values by parameter.
    macro_rules! map_of {
        ($type:ty, $name:literal, $value:ty) => {
            impl JsonSchema for $type {
                fn schema_name() -> Cow<'static, str> {
                    $name.into()
                }

                fn json_schema(generator: &mut SchemaGenerator) -> Schema {
                    let value = generator.subschema_for::<$value>();
                    let known = |parameter: Parameter| {
                        let mut value = value.clone();
                        let text = format!("{} {}", parameter.label(), parameter.symbol());
                        value.insert("description".to_owned(), text.trim().into());
                        (parameter.name(), value)
                    };
                    let known: BTreeMap<&str, Schema> = Parameter::all().map(known).collect();
                    json_schema!({ "type": "object", "properties": known, "additionalProperties": value })
                }
            }
        };
    }

    map_of!(Parameters, "Parameters", crate::Quantity);
    map_of!(Values, "Values", Option<f64>);
}
