//! Options fixed before an analysis.

use crate::failure::{Failure, core_error, option_error};
use pyo3::prelude::*;
use slipfit::answer::hint::Analysis;
use slipfit::model::displacement::Coordinate;
use slipfit::resonance::{DriveAmplitude, Method, Terms};
use slipfit::ringdown::{LawOption, LowPass};
use slipfit::{Calibration, LossModel, levels, resonance, ringdown};
use slipfit_io::LevelReading;

/// A value with its standard error; a bare number is exact.
#[derive(FromPyObject, Clone, Copy)]
pub(crate) enum Uncertain {
    #[pyo3(transparent)]
    Exact(f64),
    #[pyo3(transparent)]
    Pair((f64, f64)),
}

impl Uncertain {
    pub(super) fn parts(self) -> [f64; 2] {
        match self {
            Self::Exact(value) => [value, 0.0],
            Self::Pair((value, std_error)) => [value, std_error],
        }
    }
}

/// At most one mechanical constant.
#[derive(FromPyObject, Clone, Copy)]
#[pyo3(from_item_all)]
pub(crate) struct Constants {
    stiffness: Option<Uncertain>,
    mass: Option<Uncertain>,
    torsion_stiffness: Option<Uncertain>,
    inertia: Option<Uncertain>,
}

impl Constants {
    pub(super) fn given(self, py: Python<'_>) -> PyResult<Option<(&'static str, Calibration, Coordinate)>> {
        let stiffness = |[value, std_error]: [f64; 2]| Calibration::Stiffness { value, std_error };
        let mass = |[value, std_error]: [f64; 2]| Calibration::Mass { value, std_error };
        let given: Vec<_> = [
            ("stiffness", self.stiffness.map(|u| stiffness(u.parts())), Coordinate::Length),
            ("mass", self.mass.map(|u| mass(u.parts())), Coordinate::Length),
            ("torsion_stiffness", self.torsion_stiffness.map(|u| stiffness(u.parts())), Coordinate::Angle),
            ("inertia", self.inertia.map(|u| mass(u.parts())), Coordinate::Angle),
        ]
        .into_iter()
        .filter_map(|(name, constant, coordinate)| Some((name, constant?, coordinate)))
        .collect();
        match given[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            [(a, ..), (b, ..), ..] => Err(option_error(
                py,
                b,
                format!("{a} and {b} are both given: one of them calibrates the forces"),
            )),
        }
    }

    /// The constant, which must apply to a signal in `unit`.
    pub(super) fn calibration(self, py: Python<'_>, unit: &str) -> PyResult<Option<Calibration>> {
        let Some((name, constant, coordinate)) = self.given(py)? else { return Ok(None) };
        coordinate.check_unit(unit).map_err(|error| {
            let message = error.to_string().replacen("the constant", name, 1);
            let failure = Failure::new(py, "OptionError", "option", message).with("option", name);
            failure.hints(error.hints(Analysis::Ringdown)).into_error()
        })?;
        Ok(Some(constant))
    }
}

fn loss_model(py: Python<'_>, word: Option<String>) -> PyResult<Option<LossModel>> {
    word.map(|word| {
        word.parse::<LossModel>().map_err(|e| option_error(py, "model", format!("model={word:?}: {e}")))
    })
    .transpose()
}

fn law(py: Python<'_>, word: &str) -> PyResult<LawOption> {
    word.parse().map_err(|e| option_error(py, "law", format!("law={word:?}: {e}")))
}

/// Options of the analysis of a ring-down.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RingdownChoices {
    start_s: Option<f64>,
    end_s: Option<f64>,
    min_amplitude: Option<f64>,
    band_hz: Option<(f64, f64)>,
    model: Option<String>,
    law: Option<String>,
    lockin_time_constant_s: Option<f64>,
    lockin_order: Option<u32>,
    frequency_hz: Option<f64>,
}

impl RingdownChoices {
    pub(crate) fn options(self, py: Python<'_>) -> PyResult<ringdown::Options> {
        let mut options = ringdown::Options::default();
        options.start_s = self.start_s;
        options.end_s = self.end_s;
        options.min_amplitude = self.min_amplitude;
        options.band_hz = self.band_hz.map(<[f64; 2]>::from);
        options.model = loss_model(py, self.model)?;
        options.law = self.law.map(|word| law(py, &word)).transpose()?;
        options.lockin = match (self.lockin_time_constant_s, self.lockin_order) {
            (Some(time_constant_s), Some(order)) => Some(LowPass { time_constant_s, order }),
            (None, None) => None,
            _ => {
                let message = "lockin_time_constant_s and lockin_order describe one filter: give both";
                return Err(option_error(py, "lockin_order", message));
            }
        };
        options.frequency_hz = self.frequency_hz;
        options.check().map_err(|error| core_error(py, Analysis::Ringdown, &error))?;
        Ok(options)
    }
}

/// Options of the analysis of a resonance curve.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ResonanceChoices {
    band_hz: Option<(f64, f64)>,
    method: String,
    model: Option<String>,
    drive_amplitude: Option<Uncertain>,
    background: Option<bool>,
    delay: Option<bool>,
    amplitude_offset: Option<bool>,
    noise_floor: Option<bool>,
    phase_offset: Option<bool>,
    duffing: Option<bool>,
}

impl ResonanceChoices {
    pub(super) fn options(self, py: Python<'_>) -> PyResult<resonance::Options> {
        let mut options = resonance::Options::default();
        options.band_hz = self.band_hz.map(<[f64; 2]>::from);
        options.method = match self.method.as_str() {
            "exact" => Method::Exact,
            "leading" => Method::Leading,
            "paper" => Method::Paper,
            other => {
                let message = format!("method={other:?}: one of exact, leading, paper");
                return Err(option_error(py, "method", message));
            }
        };
        options.model = loss_model(py, self.model)?;
        options.drive_amplitude = self.drive_amplitude.map(|u| {
            let [value, std_error] = u.parts();
            DriveAmplitude { value, std_error }
        });
        let mut terms = Terms::default();
        terms.background = self.background;
        terms.delay = self.delay;
        terms.amplitude_offset = self.amplitude_offset;
        terms.noise_floor = self.noise_floor;
        terms.phase_offset = self.phase_offset;
        terms.duffing = self.duffing;
        options.terms = terms;
        Ok(options)
    }
}

/// Options of the analysis of drive levels.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct LevelsChoices {
    frequency_hz: Option<f64>,
    drive_gain: Option<Uncertain>,
    q_factor: Option<Uncertain>,
}

impl LevelsChoices {
    pub(super) fn options(self, reading: &LevelReading) -> levels::Options {
        let mut options = levels::Options::default();
        options.frequency_hz = self.frequency_hz.or_else(|| reading.named_frequency_hz());
        options.drive_gain = self.drive_gain.map(Uncertain::parts);
        options.q_factor = self.q_factor.map(Uncertain::parts);
        options
    }
}
