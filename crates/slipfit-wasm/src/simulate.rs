//! The exact motion and the paper's approximations, for pages with sliders.

use crate::refusal::Refusal;
use rand::SeedableRng as _;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution as _, StandardNormal};
use serde::{Deserialize, Serialize};
use slipfit::Oscillator;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::decay::averaged::ring_down_amplitude;
use slipfit::motion::steady::{HarmonicDrive, leading, lorentzian, solve};
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Version of the program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Maximum number of samples that a page may request.
const MOST_SAMPLES: f64 = 1e6;
/// Maximum number of points of a curve.
const MOST_POINTS: usize = 2000;

/// Parameters of a release from rest and its record.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DecayChoice {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Quality factor of the viscous loss.
    pub q_factor: f64,
    /// `beta = 4F/(pi k x_0)` for a drive amplitude `x_0` of one, in the unit of the amplitude.
    pub friction_ratio: f64,
    /// Amplitude at the release.
    pub amplitude: f64,
    /// Length of the record, s.
    pub duration_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// White noise, root mean square.
    pub noise_rms: f64,
    /// Seed of the noise.
    pub seed: u64,
}

/// The record of a release.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Decay {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// The exact motion with noise.
    pub displacement: Vec<f64>,
    /// Eq. (16) of the paper; null after it becomes negative, where it no longer holds.
    pub paper: Vec<Option<f64>>,
    /// Time at which the mass stops for good, s; null if it does not.
    pub stop_s: Option<f64>,
    /// The record as a file.
    pub csv: String,
}

/// An exact free decay with noise, and the paper's amplitude (eq. (16)).
///
/// # Errors
/// [`Refusal`] if a parameter is out of range, or more than a million samples are requested.
///
/// ```
/// use slipfit_wasm::simulate::{DecayChoice, decay};
/// let choice = DecayChoice {
///     frequency_hz: 1.0, q_factor: 50.0, friction_ratio: 0.0127, amplitude: 1.0,
///     duration_s: 60.0, rate_hz: 20.0, noise_rms: 0.0, seed: 1,
/// };
/// let decay = decay(&choice).unwrap();
/// assert_eq!((decay.time_s.len(), decay.displacement[0]), (1201, 1.0));
/// assert!(decay.stop_s.is_some_and(|s| s < 30.0));
/// ```
pub fn decay(choice: &DecayChoice) -> Result<Decay, Refusal> {
    let samples = (choice.duration_s * choice.rate_hz).floor() + 1.0;
    if !(1.0..=MOST_SAMPLES).contains(&samples) {
        return Err(Refusal::new(format!("{samples} samples: 1 to {MOST_SAMPLES} can be shown")));
    }
    let refused = |e: slipfit::Error| Refusal::new(e.to_string());
    let oscillator = oscillator(choice.frequency_hz, choice.q_factor, choice.friction_ratio)?;
    let motion = FreeDecay::from_rest(&oscillator, choice.amplitude).map_err(refused)?;
    let mut generator = ChaCha12Rng::seed_from_u64(choice.seed);
    let mut made = Decay {
        time_s: Vec::new(),
        displacement: Vec::new(),
        paper: Vec::new(),
        stop_s: motion.stop().map(|stop| stop.time_s),
        csv: "time (s),displacement\n".to_owned(),
    };
    for i in 0..samples as u64 {
        let time_s = i as f64 / choice.rate_hz;
        let unit: f64 = StandardNormal.sample(&mut generator);
        let displacement = motion.displacement(time_s) + choice.noise_rms * unit;
        // Writing to a String cannot fail.
        let _ = writeln!(made.csv, "{time_s},{displacement}");
        made.time_s.push(time_s);
        made.displacement.push(displacement);
        made.paper
            .push(Some(ring_down_amplitude(&oscillator, choice.amplitude, time_s)).filter(|a| *a >= 0.0));
    }
    Ok(made)
}

/// Parameters of a drive of fixed amplitude one, swept over the resonance.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResonanceChoice {
    /// Quality factor of the viscous loss.
    pub q_factor: f64,
    /// `beta = 4F/(pi k x_0)`.
    pub friction_ratio: f64,
    /// Points of the curve.
    pub points: usize,
}

/// Amplitudes over frequency, in units of the drive amplitude and of the natural frequency.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Resonance {
    /// Frequency over the natural frequency.
    pub frequency: Vec<f64>,
    /// The exact fundamental; null if no motion that repeats with the drive was found.
    pub exact: Vec<Option<f64>>,
    /// The leading term, eq. (8).
    pub leading: Vec<f64>,
    /// The effective Lorentzian, eq. (14).
    pub lorentzian: Vec<f64>,
    /// Without friction.
    pub without_friction: Vec<f64>,
}

/// Fig. 1 of the paper for any quality factor and friction, over five line widths on either side.
///
/// # Errors
/// [`Refusal`] if a parameter is out of range.
///
/// ```
/// use slipfit_wasm::simulate::{ResonanceChoice, resonance};
/// let curve = resonance(&ResonanceChoice { q_factor: 50.0, friction_ratio: 0.5, points: 101 }).unwrap();
/// // Eq. (9): Q (1 - beta) at the peak.
/// assert!((curve.exact[50].unwrap() - 25.0).abs() < 0.1);
/// ```
pub fn resonance(choice: &ResonanceChoice) -> Result<Resonance, Refusal> {
    if !(3..=MOST_POINTS).contains(&choice.points) {
        return Err(Refusal::new(format!("{} points: 3 to {MOST_POINTS} can be shown", choice.points)));
    }
    let rubbing = oscillator(1.0, choice.q_factor, choice.friction_ratio)?;
    let free = oscillator(1.0, choice.q_factor, 0.0)?;
    let mut made = Resonance {
        frequency: Vec::new(),
        exact: Vec::new(),
        leading: Vec::new(),
        lorentzian: Vec::new(),
        without_friction: Vec::new(),
    };
    for i in 0..choice.points {
        let place = 2.0 * i as f64 / (choice.points - 1) as f64 - 1.0;
        let frequency = (1.0 + 5.0 * place / choice.q_factor).max(0.05);
        let drive = HarmonicDrive::new(1.0, TAU * frequency).map_err(|e| Refusal::new(e.to_string()))?;
        made.frequency.push(frequency);
        made.exact.push(solve(&rubbing, &drive).ok().map(|s| s.state.harmonic(1).norm()));
        made.leading.push(leading::leading_amplitude(&rubbing, &drive));
        made.lorentzian.push(lorentzian::lorentzian_amplitude(&rubbing, &drive, lorentzian::PAPER_A));
        made.without_friction.push(leading::leading_amplitude(&free, &drive));
    }
    Ok(made)
}

fn oscillator(frequency_hz: f64, q_factor: f64, friction_ratio: f64) -> Result<Oscillator, Refusal> {
    let friction_displacement = Oscillator::friction_displacement_for(friction_ratio, 1.0);
    let builder = Oscillator::builder().frequency_hz(frequency_hz).q_factor(q_factor);
    let built = builder.friction_displacement(friction_displacement).build();
    built.map_err(|e| Refusal::new(e.to_string()))
}
