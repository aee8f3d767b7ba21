//! The driven steady state: the paper's approximations next to the exact motion.
//!
//! - [`series`]: Fourier series with any number of terms, eqs. (1) to (7) of Vitorino, Vieira and Rodrigues
//! - [`leading`]: its leading term, eq. (8), and the same with drag
//! - [`lorentzian`]: effective quality factor and drive, eqs. (9) to (14), and their inversion
//! - [`exact`]: closed form with two turning points per cycle and no stop
//! - [`orbit`]: motions with stops, by shooting with the event machine; stability
//! - [`solve`]: the exact motion by whichever method holds
//! - [`validity()`]: the paper's limits, with the resulting errors
//! - [`scan`]: the readings of an instrument, point by point or swept
//! - [`atlas`]: errors of the approximations over `Q` and `beta`
//!
//! [`SteadyState::new`] gives them a common interface:
//!
//! ```
//! # use slipfit::{Oscillator, motion::steady::{HarmonicDrive, Method, SteadyState}};
//! let o = Oscillator::kinematic(1.0, 0.01, 0.7)?;
//! let drive = HarmonicDrive::new(1.0, 0.97)?;
//! let exact = SteadyState::new(&o, &drive, Method::Exact)?;
//! let leading = SteadyState::new(&o, &drive, Method::Leading)?;
//! // On the flank eq. (8) is low by some ten per cent.
//! assert!(leading.amplitude() < 0.93 * exact.amplitude());
//! # Ok::<(), slipfit::Error>(())
//! ```

pub mod atlas;
pub(crate) mod closed;
mod drive;
pub mod exact;
pub mod fundamental;
pub mod leading;
pub mod lorentzian;
mod lorentzian_fit;
mod one_stop;
pub mod orbit;
mod response;
pub mod scan;
pub mod series;
mod solve;
mod state;
mod stops;
pub mod validity;

pub use drive::HarmonicDrive;
pub use orbit::PeriodicOrbit;
pub use solve::{MethodComparison, Solution, SolutionMethod, compare_methods, solve, solve_with_friction};
pub use state::{CycleLoss, Method, SteadyState};
pub use validity::{Validity, validity};

use crate::model::oscillator::Oscillator;

/// Complex amplitude: `x = Re X e^(i n omega t)`, with `t = 0` at the crest of the drive.
pub type Phasor = nalgebra::Complex<f64>;

/// `D(omega)/k = 1 - omega²/omega_0² + 2 i delta omega/omega_0²`: dynamic over static stiffness.
pub fn dynamic_stiffness(oscillator: &Oscillator, omega: f64) -> Phasor {
    let w = oscillator.omega_0();
    Phasor::new((w - omega) / w * ((w + omega) / w), 2.0 * (oscillator.decay_rate_per_s() / w) * (omega / w))
}
