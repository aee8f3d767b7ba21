//! The JSON of a simulated record.

use super::VERSION;
use serde::Serialize;
use std::collections::BTreeMap;

/// A simulated record: all parameters of the simulation, and its columns.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SimulatedRecord<'a> {
    /// Name and version of this contract.
    schema: &'static str,
    /// The program that made it.
    #[cfg_attr(test, schemars(extend("const" = "slipfit")))]
    program: &'static str,
    /// Version of the program.
    version: &'static str,
    /// The command that wrote it.
    #[cfg_attr(test, schemars(extend("enum" = COMMANDS)))]
    command: String,
    /// What the record is, in words.
    title: &'a str,
    /// Parameters of the simulation, by name, in SI or the unit named.
    #[cfg_attr(test, schemars(extend("minProperties" = 1)))]
    parameters: BTreeMap<&'a str, SimulatedParameter<'a>>,
    /// Number of rows of every column.
    rows: usize,
    /// The numbers.
    #[cfg_attr(test, schemars(length(min = 2, max = 3)))]
    columns: Vec<SimulatedColumn<'a>>,
}

/// A parameter of a simulated record.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
#[serde(untagged)]
pub enum SimulatedParameter<'a> {
    /// A number.
    Number {
        /// Infinite values, such as a quality factor without viscous damping, are null.
        value: f64,
        /// Its unit; empty if the name contains it.
        unit: &'a str,
    },
    /// A parameter that is not a number.
    Text {
        /// Its value in words.
        text: &'a str,
    },
}

/// A column of a simulated record.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SimulatedColumn<'a> {
    /// Name of the quantity.
    #[cfg_attr(test, schemars(extend("enum" = COLUMNS)))]
    pub name: &'a str,
    /// Unit of its values.
    pub unit: &'a str,
    /// The values, row by row; the phase of a mass at rest is null.
    pub values: Vec<f64>,
}

#[cfg(test)]
const COMMANDS: [&str; 4] = ["simulate decay", "simulate driven", "simulate sweep", "simulate levels"];
#[cfg(test)]
const COLUMNS: [&str; 7] =
    ["time", "displacement", "amplitude", "turning point", "frequency", "drive amplitude", "phase"];

impl<'a> SimulatedRecord<'a> {
    /// The record made by `slipfit simulate <command>`.
    ///
    /// - `title`: what the record is, in words
    /// - `parameters`: names and values
    /// - `columns`: of one length
    #[must_use]
    pub fn new(
        command: &str,
        title: &'a str,
        parameters: impl IntoIterator<Item = (&'a str, SimulatedParameter<'a>)>,
        columns: Vec<SimulatedColumn<'a>>,
    ) -> Self {
        Self {
            schema: "slipfit/simulate-1",
            program: "slipfit",
            version: VERSION,
            command: format!("simulate {command}"),
            title,
            parameters: parameters.into_iter().collect(),
            rows: columns.first().map_or(0, |c| c.values.len()),
            columns,
        }
    }
}
