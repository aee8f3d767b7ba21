//! Separates sliding (Coulomb, dry) friction from viscous damping in any oscillator.
//!
//! The oscillator is `m x'' + gamma x' + k x + F sgn(x') = k x_0 cos(omega t)`. The question is how much of its loss
//! is viscous, how much is sliding friction, and how certain the separation is. The data may be a free decay, a
//! resonance curve, amplitudes over drive levels, or several of these for one oscillator. Each analysis is one
//! function that takes data and options and returns an answer with parameters, intervals, a comparison of loss models
//! and warnings. A poor fit is an answer with warnings; an [`Error`] means that nothing could be computed.
//!
//! The model and its approximations are those of M. V. Vitorino, A. Vieira and M. S. Rodrigues, *Effect of sliding
//! friction in harmonic oscillators*, Sci. Rep. 7 (2017), doi:10.1038/s41598-017-03999-w; [`motion`] contains the
//! exact solutions for comparison, [`paper`] the paper's own statements.
//!
//! # A free decay
//!
//! ```
//! use slipfit::{Oscillator, Parameter, Record, motion::decay::FreeDecay, ringdown};
//!
//! let oscillator = Oscillator::kinematic(6.0, 0.03, 0.002)?; // rad/s, 1/s, rad
//! let decay = FreeDecay::from_rest(&oscillator, 0.5)?;
//! let time_s: Vec<f64> = (0..2000).map(|i| 0.02 * f64::from(i)).collect();
//! let noise = |i: usize| 1e-3 * (7.7 * (i * i) as f64).sin();
//! let angle = time_s.iter().enumerate().map(|(i, &t)| decay.displacement(t) + noise(i)).collect();
//! let record = Record::new(time_s, angle)?.with_unit("rad");
//!
//! let answer = ringdown::analyse(&record, &ringdown::Options::default())?;
//! let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("always reported");
//! assert!((x_f.value - 0.002).abs() < 4.0 * x_f.std_error);
//! assert!(answer.sliding.detected);
//! # Ok::<(), slipfit::Error>(())
//! ```
//!
//! # A resonance curve
//!
//! ```
//! use slipfit::motion::steady::scan;
//! use slipfit::resonance::{self, Curve, DriveAmplitude};
//! use slipfit::{Oscillator, Parameter};
//!
//! let oscillator =
//!     Oscillator::builder().frequency_hz(1.0).q_factor(50.0).friction_displacement(0.3).build()?;
//! let mut points = Vec::new();
//! for i in 0..81 {
//!     points.push(scan::reading(&oscillator, 1.0, 0.9 + 0.0025 * f64::from(i))?);
//! }
//! let frequency_hz = points.iter().map(|p| p.frequency_hz).collect();
//! let noise = |i: usize| 0.01 * (7.7 * (i * i) as f64).sin();
//! let amplitude = points.iter().enumerate().map(|(i, p)| p.amplitude() + noise(i)).collect();
//! let curve = Curve::builder(frequency_hz, amplitude).unit("mm").build()?;
//!
//! let mut options = resonance::Options::default();
//! options.drive_amplitude = Some(DriveAmplitude { value: 1.0, std_error: 0.0 });
//! let answer = resonance::analyse(&curve, &options)?;
//! let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("always reported");
//! assert!((x_f.value - 0.3).abs() < 0.01);
//! # Ok::<(), slipfit::Error>(())
//! ```
//!
//! # Amplitudes over drive levels, and several measurements
//!
//! ```
//! use slipfit::levels::{self, Levels};
//! use slipfit::series::{self, Condition, Data, Measurement};
//! use slipfit::Parameter;
//!
//! // Q = 40, threshold 0.35 mm.
//! let drive: Vec<f64> = (1..=12).map(|i| 0.1 * f64::from(i)).collect();
//! let noise = |i: usize| 0.02 * (i * 7 % 5) as f64;
//! let amplitude = drive.iter().enumerate().map(|(i, x)| (40.0 * (x - 0.35)).max(0.0) + noise(i)).collect();
//! let levels = Levels::builder(drive, amplitude).unit("mm").drive_unit("mm").build()?;
//! let options = levels::Options::default();
//! let answer = levels::analyse(&levels, &options)?;
//! assert!((answer.parameter(Parameter::Threshold).expect("always reported").value - 0.35).abs() < 0.01);
//!
//! let measurement = Measurement {
//!     name: "levels".into(),
//!     condition: Condition { label: "9 nN".into(), value: None },
//!     data: Data::Levels { levels: Box::new(levels), options: Box::new(options) },
//!     scale: 1.0,
//! };
//! let all = series::analyse(&[measurement], &series::Options::default())?;
//! assert!(all.singles[0].1.is_ok());
//! # Ok::<(), slipfit::Error>(())
//! ```
//!
//! # Modules
//!
//! | module | what it holds |
//! |---|---|
//! | [`ringdown`], [`resonance`], [`levels`], [`series`] | the analyses: `analyse`, options, answers; the bare fits |
//! | [`answer`] | what they share: parameters, quantities with intervals, model comparison, warnings with hints |
//! | [`model`] | the oscillator, the kinds of loss, calibration to forces |
//! | [`motion`] | exact free decay, any motion event by event, the driven steady state |
//! | [`record`], [`signal`] | samples with a clean clock; a driven record as one point of a curve |
//! | [`paper`] | the statements of the paper, computed beside the exact motion |
//!
//! # Features
//!
//! | feature | default | what it adds |
//! |---|---|---|
//! | `threads` | yes | long sums on all cores (rayon); off for wasm32 |
//! | `smooth-laws` | yes | motion under drag, Stribeck and other smooth friction laws, by an integrator |
//! | `serde` | no | answers serialise as the JSON of docs/json.md |
//! | `schema` | no | JSON schemas of the answers |

pub mod answer;
pub mod error;
mod inference;
pub mod levels;
pub mod model;
pub mod motion;
#[cfg(test)]
mod noise;
mod numeric;
pub mod paper;
pub mod record;
pub mod resonance;
pub mod ringdown;
pub mod series;
pub mod signal;

pub use answer::calibration::Calibration;
pub use answer::quantity::Quantity;
pub use answer::{Parameter, Parameters};
pub use error::Error;
pub use inference::criteria::{Criterion, InferenceCriteria};
pub use model::loss::{LossModel, LossTerm};
pub use model::oscillator::Oscillator;
pub use record::{Clock, ClockReport, Gap, Record, SignalKind};
