//! What JavaScript calls. Every function takes and gives JSON text: an object of the result, or
//! `{"error": {"message", "hints"}}`.
#![allow(unsafe_code, reason = "the glue that wasm-bindgen writes around each function")]
#![allow(unreachable_pub, reason = "exported by wasm-bindgen, from wherever they stand")]

use crate::simulate::{VERSION, decay, resonance};
use crate::{File, Options, Refusal};
use serde::{Serialize, de::DeserializeOwned};
use wasm_bindgen::prelude::wasm_bindgen;

/// A refusal as JSON.
#[derive(Serialize)]
struct Failed {
    error: Refusal,
}

fn told<T: Serialize>(result: Result<T, Refusal>) -> String {
    match result {
        Ok(value) => serde_json::to_string(&value),
        Err(error) => serde_json::to_string(&Failed { error }),
    }
    .unwrap_or_default()
}

fn parsed<T: DeserializeOwned>(choice: &str) -> Result<T, Refusal> {
    serde_json::from_str(choice).map_err(|e| Refusal::new(e.to_string()))
}

/// Runs when the module is loaded. Every browser that accepts the module has lanes of 128 bits: the kernels that
/// use them are part of it.
#[wasm_bindgen(start)]
pub fn use_lanes() {
    pulp_wasm_simd_flag::enable_simd128();
}

/// [`crate::preview`].
#[wasm_bindgen]
pub fn preview(bytes: &[u8], name: &str, options: &str) -> String {
    told(Options::parse(options).and_then(|options| crate::preview(&File { name, bytes }, &options)))
}

/// [`crate::analyse`]; an empty `reference_name` stands for none.
#[wasm_bindgen]
pub fn analyse(bytes: &[u8], name: &str, options: &str, reference: &[u8], reference_name: &str) -> String {
    let free = File { name: reference_name, bytes: reference };
    let free = (!reference_name.is_empty()).then_some(&free);
    told(Options::parse(options).and_then(|options| crate::analyse(&File { name, bytes }, free, &options)))
}

/// [`crate::simulate::decay`].
#[wasm_bindgen(js_name = simulateDecay)]
pub fn simulate_decay(choice: &str) -> String {
    told(parsed(choice).and_then(|choice| decay(&choice)))
}

/// [`crate::simulate::resonance`].
#[wasm_bindgen(js_name = simulateResonance)]
pub fn simulate_resonance(choice: &str) -> String {
    told(parsed(choice).and_then(|choice| resonance(&choice)))
}

/// Style rules that turn the colours of the panels for a dark screen.
#[wasm_bindgen(js_name = darkRules)]
pub fn dark_rules() -> String {
    slipfit_report::plot::dark_rules()
}

/// Version of the program.
#[wasm_bindgen]
pub fn version() -> String {
    VERSION.to_owned()
}
