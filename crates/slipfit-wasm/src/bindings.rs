//! Functions called by JavaScript. Each takes JSON text and returns JSON text, which is the result or
//! `{"error": {"message", "hints"}}`; samples are passed as numbers.
#![allow(unsafe_code, reason = "the glue that wasm-bindgen writes around each function")]
#![allow(unreachable_pub, reason = "exported by wasm-bindgen, from wherever they stand")]

use crate::simulate::{VERSION, decay, resonance};
use crate::{Options, Output, Refusal, Session};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;
use wasm_bindgen::prelude::wasm_bindgen;

/// A refusal as JSON.
#[derive(Serialize)]
struct Failed {
    error: Refusal,
}

fn result_json<T: Serialize>(result: Result<T, Refusal>) -> String {
    match result {
        Ok(value) => serde_json::to_string(&value),
        Err(error) => serde_json::to_string(&Failed { error }),
    }
    .unwrap_or_default()
}

fn parsed<T: DeserializeOwned>(choice: &str) -> Result<T, Refusal> {
    serde_json::from_str(choice).map_err(|e| Refusal::new(e.to_string()))
}

/// Runs when the module is loaded. Every browser that accepts the module supports 128-bit SIMD, because the
/// kernels that use it are part of the module.
#[wasm_bindgen(start)]
pub fn use_lanes() {
    pulp_wasm_simd_flag::enable_simd128();
}

/// [`Session`].
#[wasm_bindgen(js_name = Session)]
pub struct SessionHandle(Session);

#[wasm_bindgen(js_class = Session)]
impl SessionHandle {
    /// [`Session::new`]; an empty `reference_name` means no reference.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: Vec<u8>, name: &str, reference: Vec<u8>, reference_name: &str) -> Self {
        let reference = (!reference_name.is_empty()).then_some((reference_name, reference));
        Self(Session::new(name, bytes, reference))
    }

    /// [`Session::preview`].
    pub fn preview(&mut self, options: &str) -> String {
        result_json(Options::parse(options).and_then(|options| self.0.preview(&options)))
    }

    /// [`Session::analyse`].
    pub fn analyse(&mut self, options: &str) -> String {
        result_json(Options::parse(options).and_then(|options| self.0.analyse(&options)))
    }

    /// [`Session::trace`]: times, signal and fit, of equal length, one after another.
    pub fn trace(&self) -> Option<Vec<f64>> {
        self.0.trace().map(|trace| [trace.time_s, trace.signal, trace.fitted].concat())
    }

    /// [`Session::output`], as a string of JSON.
    pub fn output(&self, what: &str) -> String {
        let output = serde_json::from_value::<Output>(Value::from(what));
        result_json(output.map_err(|e| Refusal::new(e.to_string())).and_then(|output| self.0.output(output)))
    }
}

/// [`crate::simulate::decay`].
#[wasm_bindgen(js_name = simulateDecay)]
pub fn simulate_decay(choice: &str) -> String {
    result_json(parsed(choice).and_then(|choice| decay(&choice)))
}

/// [`crate::simulate::resonance`].
#[wasm_bindgen(js_name = simulateResonance)]
pub fn simulate_resonance(choice: &str) -> String {
    result_json(parsed(choice).and_then(|choice| resonance(&choice)))
}

/// Style rules that convert the colours of the panels for a dark screen.
#[wasm_bindgen(js_name = darkRules)]
pub fn dark_rules() -> String {
    slipfit_report::plot::dark_rules()
}

/// Version of the program.
#[wasm_bindgen]
pub fn version() -> String {
    VERSION.to_owned()
}
