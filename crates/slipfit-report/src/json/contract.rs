//! The keys of the JSON answer: docs/json.md, docs/schema/ringdown-1.json.
//!
//! Written apart from the core's types so that a change of those cannot change
//! the contract unseen.

use serde::{Serialize, Serializer};
use slipfit::Parameters;
use slipfit::Quantity;

/// Name and version of the contract: the number grows when a key changes its
/// meaning or vanishes; new keys may come at any time.
pub(super) const SCHEMA: &str = "slipfit/ringdown-1";

#[derive(Serialize)]
pub(super) struct Document<'a> {
    pub(super) schema: &'static str,
    pub(super) version: &'static str,
    pub(super) command: &'static str,
    pub(super) input: Input<'a>,
    pub(super) options: Asked,
    pub(super) model: &'static str,
    pub(super) sentence: String,
    #[serde(serialize_with = "by_name")]
    pub(super) parameters: &'a Parameters,
    pub(super) comparison: Vec<Compared>,
    pub(super) sliding: Sliding,
    pub(super) correlations: Vec<Correlated>,
    pub(super) segment: Stretch,
    pub(super) backbone: Option<Backbone>,
    pub(super) stop: Option<Stopped>,
    pub(super) diagnostics: Diagnostics,
    pub(super) warnings: Vec<Doubt>,
    pub(super) loss: Loss,
    pub(super) envelope: Envelope,
}

#[derive(Serialize)]
pub(super) struct Input<'a> {
    pub(super) path: String,
    pub(super) sha256: &'a str,
    pub(super) bytes: u64,
    pub(super) rows_read: u64,
    pub(super) rows_skipped: u64,
    pub(super) skipped: Vec<Skipped<'a>>,
    pub(super) columns: Vec<Column<'a>>,
    pub(super) table: usize,
    pub(super) tables: usize,
    pub(super) run: usize,
    pub(super) runs: usize,
    pub(super) time: Time<'a>,
    pub(super) signal: Taken<'a>,
    pub(super) quadrature: Option<Taken<'a>>,
    pub(super) kind: &'static str,
    pub(super) unit: &'a str,
    pub(super) samples: usize,
    pub(super) time_range_s: [f64; 2],
    pub(super) time_range_used_s: [f64; 2],
    pub(super) clock: ClockAccount,
    pub(super) notes: &'a [String],
}

#[derive(Serialize)]
pub(super) struct Skipped<'a> {
    pub(super) reason: &'a str,
    pub(super) rows: u64,
    pub(super) first_row: u64,
}

#[derive(Serialize)]
pub(super) struct Column<'a> {
    pub(super) number: usize,
    pub(super) header: &'a str,
    pub(super) unit: &'a str,
}

#[derive(Serialize)]
pub(super) struct Taken<'a> {
    pub(super) number: usize,
    pub(super) header: &'a str,
    pub(super) unit: &'a str,
    pub(super) why: &'a str,
}

#[derive(Serialize)]
pub(super) struct Time<'a> {
    pub(super) source: &'static str,
    pub(super) column: Option<Taken<'a>>,
    pub(super) rate_hz: Option<f64>,
}

#[derive(Serialize)]
pub(super) struct ClockAccount {
    pub(super) uniform: bool,
    pub(super) median_step_s: f64,
    pub(super) step_spread: f64,
    pub(super) nonfinite_rows: usize,
    pub(super) repeated_stamps: usize,
    pub(super) reordered_rows: usize,
    pub(super) corrupt_stamps: usize,
    pub(super) resets: usize,
    pub(super) other_run_rows: usize,
    pub(super) gaps: usize,
    pub(super) longest_gap_s: Option<f64>,
    pub(super) rebuilt_quantum_s: Option<f64>,
}

/// What the person fixed; `null` is left to the analysis.
#[derive(Serialize)]
pub(super) struct Asked {
    pub(super) start_s: Option<f64>,
    pub(super) end_s: Option<f64>,
    pub(super) min_amplitude: Option<f64>,
    pub(super) band_hz: Option<[f64; 2]>,
    pub(super) model: Option<&'static str>,
    pub(super) lockin_time_constant_s: Option<f64>,
    pub(super) lockin_order: Option<u32>,
    pub(super) frequency_hz: Option<f64>,
    pub(super) calibration: Option<Constant>,
}

#[derive(Serialize)]
pub(super) struct Constant {
    pub(super) kind: &'static str,
    pub(super) value: f64,
    pub(super) std_error: f64,
}

#[derive(Serialize)]
pub(super) struct Measured<'a> {
    pub(super) value: f64,
    pub(super) std_error: f64,
    pub(super) interval_95: [f64; 2],
    pub(super) unit: &'a str,
    pub(super) unbounded_value: f64,
}

#[derive(Serialize)]
pub(super) struct Compared {
    pub(super) model: &'static str,
    pub(super) bic: f64,
    pub(super) delta_bic: f64,
    pub(super) rms: f64,
    pub(super) free_parameters: usize,
    pub(super) converged: bool,
    pub(super) at_limit: Option<&'static str>,
    pub(super) initial_amplitude: f64,
    pub(super) decay_rate_per_s: f64,
    pub(super) friction_displacement: f64,
    pub(super) drag_rate: f64,
}

#[derive(Serialize)]
pub(super) struct Sliding {
    pub(super) detected: bool,
    pub(super) p_value: f64,
    pub(super) delta_bic: f64,
    pub(super) share_at_highest: f64,
    pub(super) share_at_lowest: f64,
    pub(super) dominates_from_s: Option<f64>,
    pub(super) viscous_only_p_value: f64,
}

#[derive(Serialize)]
pub(super) struct Correlated {
    pub(super) parameters: [&'static str; 2],
    pub(super) value: f64,
}

#[derive(Serialize)]
pub(super) struct Stretch {
    pub(super) start_s: f64,
    pub(super) end_s: f64,
    pub(super) samples: usize,
    pub(super) cycles: f64,
    pub(super) start_reason: &'static str,
    pub(super) end_reason: &'static str,
}

#[derive(Serialize)]
pub(super) struct Backbone {
    pub(super) frequency_at_zero_hz: f64,
    pub(super) frequency_at_start_hz: f64,
    pub(super) quadratic: f64,
    pub(super) quartic: f64,
    pub(super) drift_per_s: f64,
}

#[derive(Serialize)]
pub(super) struct Stopped {
    pub(super) time_s: f64,
    pub(super) position: f64,
    pub(super) position_std_error: f64,
    pub(super) static_displacement: Option<[f64; 2]>,
}

#[derive(Serialize)]
pub(super) struct Diagnostics {
    pub(super) method: &'static str,
    pub(super) noise_rms: f64,
    pub(super) residual_rms: f64,
    pub(super) residual_excess: f64,
    pub(super) residual_autocorrelation: f64,
    pub(super) signal_to_noise_db: f64,
    pub(super) decay_times: f64,
    pub(super) left_out: usize,
    pub(super) other_modes: Vec<Mode>,
}

#[derive(Serialize)]
pub(super) struct Mode {
    pub(super) frequency_hz: f64,
    pub(super) relative_amplitude: f64,
}

#[derive(Serialize)]
pub(super) struct Doubt {
    pub(super) code: &'static str,
    pub(super) message: String,
}

/// Columns rather than rows: a notebook wants arrays.
#[derive(Serialize)]
pub(super) struct Loss {
    pub(super) amplitude: Vec<f64>,
    pub(super) loss_per_cycle: Vec<f64>,
    pub(super) std_error: Vec<f64>,
    pub(super) fitted: Vec<f64>,
    pub(super) fitted_sliding: Vec<f64>,
}

#[derive(Serialize)]
pub(super) struct Envelope {
    pub(super) time_s: Vec<f64>,
    pub(super) amplitude: Vec<f64>,
    pub(super) std_error: Vec<f64>,
    pub(super) fitted: Vec<f64>,
    pub(super) frequency_hz: Vec<f64>,
    pub(super) used: Vec<bool>,
}

fn by_name<S: Serializer>(parameters: &&Parameters, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(parameters.iter().map(|(p, q)| (p.name(), measured(q))))
}

fn measured(q: &Quantity) -> Measured<'_> {
    Measured {
        value: q.value,
        std_error: q.std_error,
        interval_95: q.interval_95,
        unit: &q.unit,
        unbounded_value: q.unbounded_value,
    }
}
