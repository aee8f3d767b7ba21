//! The options set by the user, under the names of the libraries' options.

use crate::refusal::Refusal;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use slipfit::resonance::{DriveAmplitude, Method, Terms};
use slipfit::ringdown::LowPass;
use slipfit::{Calibration, SignalKind, levels, resonance, ringdown};
use slipfit_io::{Format, ReadOptions};

/// The analysis made of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Analysis {
    /// A free decay.
    Ringdown,
    /// A resonance curve.
    Resonance,
    /// Amplitudes over drive levels.
    Levels,
}

impl Analysis {
    /// Name of the command.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.core().name()
    }

    pub(crate) fn core(self) -> slipfit::answer::hint::Analysis {
        match self {
            Self::Ringdown => slipfit::answer::hint::Analysis::Ringdown,
            Self::Resonance => slipfit::answer::hint::Analysis::Resonance,
            Self::Levels => slipfit::answer::hint::Analysis::Levels,
        }
    }

    /// Names of the options it takes.
    fn takes(self) -> &'static [&'static str] {
        match self {
            Self::Ringdown => &[
                "band_hz",
                "end_s",
                "format",
                "frequency_hz",
                "inertia",
                "kind",
                "law",
                "mass",
                "min_amplitude",
                "model",
                "lockin_order",
                "part",
                "quadrature",
                "rate_hz",
                "run",
                "sheet",
                "signal",
                "start_s",
                "stiffness",
                "time",
                "lockin_time_constant_s",
                "time_unit",
                "torsion_stiffness",
                "unit",
            ],
            Self::Resonance => &[
                "amplitude",
                "amplitude_offset",
                "background",
                "band_hz",
                "centre_hz",
                "delay",
                "drive",
                "drive_amplitude",
                "duffing",
                "format",
                "frequency",
                "frequency_unit",
                "imaginary",
                "inertia",
                "kind",
                "mass",
                "method",
                "model",
                "noise_floor",
                "phase",
                "phase_offset",
                "phase_unit",
                "real",
                "run",
                "sheet",
                "std_error",
                "stiffness",
                "torsion_stiffness",
                "unit",
            ],
            Self::Levels => &[
                "amplitude",
                "drive",
                "drive_gain",
                "drive_unit",
                "format",
                "frequency_hz",
                "imaginary",
                "inertia",
                "mass",
                "q_factor",
                "real",
                "sheet",
                "std_error",
                "stiffness",
                "torsion_stiffness",
                "unit",
            ],
        }
    }
}

/// A value and its standard error, which is zero if the value is exact.
type Uncertain = [f64; 2];

/// All options that a user can set; what is not given is left to the file and the analysis. The names are those
/// of `slipfit_io::ReadOptions` and of the analyses' options, so that a hint can be applied as it is. Options of
/// another analysis than the requested one are kept, but not used.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Options {
    /// The analysis; chosen by the content of the file if it is not given.
    pub analysis: Option<Analysis>,
    /// The other options, by name.
    #[serde(flatten)]
    chosen: Map<String, Value>,
}

/// The options of one analysis, typed.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Chosen {
    format: Option<String>,
    sheet: Option<String>,
    part: Option<usize>,
    run: Option<usize>,
    time: Option<String>,
    time_unit: Option<String>,
    rate_hz: Option<f64>,
    signal: Option<String>,
    quadrature: Option<String>,
    unit: Option<String>,
    kind: Option<String>,
    frequency: Option<String>,
    frequency_unit: Option<String>,
    centre_hz: Option<f64>,
    amplitude: Option<String>,
    phase: Option<String>,
    phase_unit: Option<String>,
    real: Option<String>,
    imaginary: Option<String>,
    std_error: Option<String>,
    drive: Option<String>,
    drive_unit: Option<String>,
    start_s: Option<f64>,
    end_s: Option<f64>,
    min_amplitude: Option<f64>,
    band_hz: Option<[f64; 2]>,
    model: Option<String>,
    law: Option<String>,
    lockin_time_constant_s: Option<f64>,
    lockin_order: Option<u32>,
    frequency_hz: Option<f64>,
    drive_amplitude: Option<Uncertain>,
    method: Option<String>,
    background: Option<bool>,
    delay: Option<bool>,
    amplitude_offset: Option<bool>,
    noise_floor: Option<bool>,
    phase_offset: Option<bool>,
    duffing: Option<bool>,
    drive_gain: Option<Uncertain>,
    q_factor: Option<Uncertain>,
    stiffness: Option<Uncertain>,
    mass: Option<Uncertain>,
    torsion_stiffness: Option<Uncertain>,
    inertia: Option<Uncertain>,
}

impl Options {
    /// Parses JSON: `{"band_hz": [79, 82]}`. `null` counts as not given.
    ///
    /// # Errors
    /// [`Refusal`] for a name that is not an option, or a value of the wrong type.
    ///
    /// ```
    /// let error = slipfit_wasm::Options::parse(r#"{"bands": 3}"#).unwrap_err();
    /// assert!(error.message.contains("unknown field `bands`"), "{}", error.message);
    /// ```
    pub fn parse(json: &str) -> Result<Self, Refusal> {
        let refused = |e: serde_json::Error| Refusal::new(format!("options: {e}"));
        let mut options: Self = serde_json::from_str(json).map_err(refused)?;
        options.chosen.retain(|_, value| !value.is_null());
        // Every name and every value is checked, whichever analysis uses them.
        let chosen: Chosen =
            serde_json::from_value(Value::Object(options.chosen.clone())).map_err(refused)?;
        chosen.ringdown()?;
        chosen.resonance()?;
        chosen.read_options()?;
        Ok(options)
    }

    /// The options that an analysis takes, by name.
    pub(crate) fn of(&self, analysis: Analysis) -> impl Iterator<Item = (&str, &Value)> {
        let takes = analysis.takes();
        let taken = move |(name, _): &(&str, &Value)| takes.contains(name);
        self.chosen.iter().map(|(name, value)| (name.as_str(), value)).filter(taken)
    }

    fn typed(&self, analysis: Analysis) -> Result<Chosen, Refusal> {
        let kept: Map<String, Value> =
            self.of(analysis).map(|(name, value)| (name.to_owned(), value.clone())).collect();
        serde_json::from_value(Value::Object(kept)).map_err(|e| Refusal::new(format!("options: {e}")))
    }

    pub(crate) fn read_options(&self, analysis: Analysis) -> Result<ReadOptions, Refusal> {
        self.typed(analysis)?.read_options()
    }

    pub(crate) fn ringdown(&self) -> Result<ringdown::Options, Refusal> {
        self.typed(Analysis::Ringdown)?.ringdown()
    }

    pub(crate) fn resonance(&self) -> Result<resonance::Options, Refusal> {
        self.typed(Analysis::Resonance)?.resonance()
    }

    pub(crate) fn levels(&self) -> Result<levels::Options, Refusal> {
        let chosen = self.typed(Analysis::Levels)?;
        let mut options = levels::Options::default();
        options.frequency_hz = chosen.frequency_hz;
        options.drive_gain = chosen.drive_gain;
        options.q_factor = chosen.q_factor;
        options.calibration = chosen.calibration();
        Ok(options)
    }

    /// Whether a mechanical constant was given for an angle or for a length; `None` without one.
    pub(crate) fn coordinate(&self) -> Option<slipfit::model::displacement::Coordinate> {
        use slipfit::model::displacement::Coordinate;
        let given = |name: &str| self.chosen.contains_key(name);
        match () {
            () if given("stiffness") || given("mass") => Some(Coordinate::Length),
            () if given("torsion_stiffness") || given("inertia") => Some(Coordinate::Angle),
            () => None,
        }
    }
}

impl Chosen {
    fn read_options(self) -> Result<ReadOptions, Refusal> {
        let format =
            |name: String| name.parse::<Format>().map_err(|e| Refusal::new(format!("format {name}: {e}")));
        Ok(ReadOptions {
            format: self.format.map(format).transpose()?,
            sheet: self.sheet,
            part: self.part,
            run: self.run,
            time: self.time,
            time_unit: self.time_unit,
            rate_hz: self.rate_hz,
            signal: self.signal,
            quadrature: self.quadrature,
            unit: self.unit,
            kind: self.kind.as_deref().map(kind).transpose()?,
            frequency: self.frequency,
            frequency_unit: self.frequency_unit,
            centre_hz: self.centre_hz,
            amplitude: self.amplitude,
            phase: self.phase,
            phase_unit: self.phase_unit,
            real: self.real,
            imaginary: self.imaginary,
            std_error: self.std_error,
            drive: self.drive,
            drive_unit: self.drive_unit,
            ..ReadOptions::default()
        })
    }

    fn model(&self) -> Result<Option<slipfit::LossModel>, Refusal> {
        let parse = |name: &String| name.parse().map_err(|e| Refusal::new(format!("model {name}: {e}")));
        self.model.as_ref().map(parse).transpose()
    }

    fn calibration(&self) -> Option<Calibration> {
        let stiffness = self.stiffness.or(self.torsion_stiffness);
        let mass = self.mass.or(self.inertia);
        stiffness
            .map(|[value, std_error]| Calibration::Stiffness { value, std_error })
            .or_else(|| mass.map(|[value, std_error]| Calibration::Mass { value, std_error }))
    }

    fn ringdown(&self) -> Result<ringdown::Options, Refusal> {
        let mut options = ringdown::Options::default();
        options.start_s = self.start_s;
        options.end_s = self.end_s;
        options.min_amplitude = self.min_amplitude;
        options.band_hz = self.band_hz;
        options.model = self.model()?;
        let law = |name: &String| name.parse().map_err(|e| Refusal::new(format!("law {name}: {e}")));
        options.law = self.law.as_ref().map(law).transpose()?;
        options.lockin = self
            .lockin_time_constant_s
            .zip(self.lockin_order)
            .map(|(time_constant_s, order)| LowPass { time_constant_s, order });
        options.frequency_hz = self.frequency_hz;
        options.calibration = self.calibration();
        Ok(options)
    }

    fn resonance(&self) -> Result<resonance::Options, Refusal> {
        let mut options = resonance::Options::default();
        options.band_hz = self.band_hz;
        options.model = self.model()?;
        options.method = match self.method.as_deref() {
            None | Some("exact") => Method::Exact,
            Some("leading") => Method::Leading,
            Some("paper") => Method::Paper,
            Some(other) => {
                return Err(Refusal::new(format!("method {other}: there are exact, leading, paper")));
            }
        };
        options.drive_amplitude =
            self.drive_amplitude.map(|[value, std_error]| DriveAmplitude { value, std_error });
        let mut terms = Terms::default();
        terms.background = self.background;
        terms.delay = self.delay;
        terms.amplitude_offset = self.amplitude_offset;
        terms.noise_floor = self.noise_floor;
        terms.phase_offset = self.phase_offset;
        terms.duffing = self.duffing;
        options.terms = terms;
        options.calibration = self.calibration();
        Ok(options)
    }
}

fn kind(name: &str) -> Result<SignalKind, Refusal> {
    match name {
        "displacement" => Ok(SignalKind::Displacement),
        "velocity" => Ok(SignalKind::Velocity),
        "acceleration" => Ok(SignalKind::Acceleration),
        "envelope" => Ok(SignalKind::Envelope),
        "lock-in" => Ok(SignalKind::LockIn),
        other => Err(Refusal::new(format!(
            "kind {other}: there are displacement, velocity, acceleration, envelope, lock-in"
        ))),
    }
}
