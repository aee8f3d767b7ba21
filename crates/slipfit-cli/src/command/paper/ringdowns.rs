//! Fig. 2 (a) and (b): ring-downs at three loads, fitted.

use crate::command::simulate::{Noise, lock_in};
use slipfit::LossModel;
use slipfit::Parameter;
use slipfit::motion::decay::{FreeDecay, averaged};
use slipfit::ringdown::{Options, analyse};
use slipfit::{Error, Oscillator, Quantity, Record, SignalKind};
use slipfit_report::plot::{Chart, Scaled, Series, SeriesStyle};
use std::f64::consts::TAU;

pub(super) const FREQUENCY_HZ: f64 = 32_700.0;
pub(super) const STIFFNESS: f64 = 1e4;
const AMPLITUDE_M: f64 = 25e-9;
const RATE_HZ: f64 = 10e3;
const DURATION_S: f64 = 0.1;
/// Spacing of the dots of a fit, so that the line below remains visible.
const DOT_SPACING_S: f64 = 1.6e-3;
/// Noise on each of X and Y.
pub(super) const NOISE_M: f64 = 0.03e-9;
/// Load as in the paper's table, F in N, gamma in N s/m.
const LOADS: [(&str, f64, f64); 3] = [("free", 0.0, 22e-6), ("9 nN", 15e-9, 20e-6), ("13 nN", 17e-9, 23e-6)];

pub(super) const CAPTION: &str = "(a), (b): exact ring-downs through a lock-in, F and γ of the paper's table, seeded \
     noise of 0.03 nm on each output (lines); fits of eq. (16) (dots).";

/// One simulated ring-down and its fit.
pub(super) struct RingDown {
    pub(super) load: &'static str,
    pub(super) coulomb_force: f64,
    pub(super) viscous: f64,
    /// Fitted values: F in N and gamma in N s/m.
    pub(super) found: [Quantity; 2],
    pub(super) stop_time_s: Option<f64>,
    data: Vec<[f64; 2]>,
    fit: Vec<[f64; 2]>,
}

impl RingDown {
    fn named(&self) -> String {
        if self.coulomb_force > 0.0 { format!("load {}", self.load) } else { self.load.to_owned() }
    }
}

pub(super) fn fork(coulomb_force: f64, viscous: f64) -> Result<Oscillator, Error> {
    Oscillator::builder()
        .frequency_hz(FREQUENCY_HZ)
        .stiffness(STIFFNESS)
        .viscous_coefficient(viscous)
        .coulomb_force(coulomb_force)
        .build()
}

pub(super) fn measure(seed: u64) -> Result<Vec<RingDown>, Error> {
    LOADS.iter().enumerate().map(|(i, load)| one(*load, seed.wrapping_add(i as u64))).collect()
}

fn one((load, coulomb_force, viscous): (&'static str, f64, f64), seed: u64) -> Result<RingDown, Error> {
    let o = fork(coulomb_force, viscous)?;
    let motion = FreeDecay::from_rest(&o, AMPLITUDE_M)?;
    let mut noise = Noise::new(seed, NOISE_M);
    let time_s: Vec<f64> = (1..=(DURATION_S * RATE_HZ) as u32).map(|i| f64::from(i) / RATE_HZ).collect();
    let amplitude: Vec<f64> = time_s
        .iter()
        .map(|t| {
            let [x, y] = lock_in(&motion, *t);
            (x + noise.next()).hypot(y + noise.next())
        })
        .collect();
    let record =
        Record::new(time_s.clone(), amplitude.clone())?.with_unit("m").with_kind(SignalKind::Envelope);
    let mut options = Options::default();
    options.model = Some(LossModel::VISCOUS_SLIDING);
    options.frequency_hz = Some(FREQUENCY_HZ);
    options.calibration = Some(slipfit::Calibration::Stiffness { value: STIFFNESS, std_error: 0.0 });
    let answer = analyse(&record, &options)?;
    let named = |name: Parameter| {
        answer.parameter(name).cloned().ok_or(Error::NoFit { reason: "a parameter of eq. (16) is missing" })
    };
    let fitted = Oscillator::builder()
        .frequency_hz(FREQUENCY_HZ)
        .decay_rate_per_s(named(Parameter::DECAY_RATE)?.value)
        .friction_displacement(named(Parameter::FRICTION_DISPLACEMENT)?.value)
        .build()?;
    let start = answer.segment.start_s;
    let initial = named(Parameter::InitialAmplitude)?.value;
    let omega = TAU * FREQUENCY_HZ;
    let velocity = |t: f64, a: f64| [t * 1e3, a * omega * 1e3];
    let fit = (0..)
        .map(|i| start + DOT_SPACING_S * f64::from(i))
        .take_while(|t| *t <= answer.segment.end_s)
        .map(|t| velocity(t, averaged::ring_down_amplitude(&fitted, initial, t - start)))
        .filter(|p| p[1] > 0.0)
        .collect();
    Ok(RingDown {
        load,
        coulomb_force,
        viscous,
        found: [named(Parameter::CoulombForce)?, named(Parameter::ViscousCoefficient)?],
        stop_time_s: motion.stop().map(|s| s.time_s),
        data: time_s.iter().zip(&amplitude).map(|(t, a)| velocity(*t, *a)).collect(),
        fit,
    })
}

pub(super) fn charts(all: &[RingDown]) -> Vec<Chart> {
    const COLORS: [usize; 3] = [1, 3, 0];
    let series = || {
        let mut series = Vec::new();
        for (r, c) in all.iter().zip(COLORS) {
            series.push(Series::new(r.named(), r.data.clone(), SeriesStyle::Line(c)));
        }
        for (r, c) in all.iter().zip(COLORS) {
            let name = format!("fit of eq. (16), {}", r.named());
            // One legend entry for all of them.
            let legend = if c == COLORS[2] { "fits of eq. (16)" } else { "" };
            series.push(Series::new(name, r.fit.clone(), SeriesStyle::LargeDots(c)).in_legend(legend));
        }
        series
    };
    let x = || Scaled::linear("time [ms]", [0.0, 1e3 * DURATION_S]);
    let label = "velocity amplitude [mm/s]";
    vec![
        Chart {
            file: "fig2_a",
            title: "(a) ring-down".to_owned(),
            x: x(),
            y: Scaled::linear(label, [0.0, 5.5]),
            series: series(),
        },
        Chart {
            file: "fig2_b",
            title: "(b) the same, logarithmic".to_owned(),
            x: x(),
            y: Scaled::log(label, [2e-3, 8.0]),
            series: series(),
        },
    ]
}
