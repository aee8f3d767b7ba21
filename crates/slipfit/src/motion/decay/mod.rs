//! Free decay: exact, half cycle by half cycle, and as a slow envelope.
//!
//! - [`FreeDecay`]: viscous and sliding friction in closed form, at any time and for any quality factor, including
//!   the stop.
//! - [`AmplitudeLaw`]: amplitude against time for sliding, viscous and drag loss together, averaged over a cycle.
//! - [`law`]: the loss rate of any other friction law.
//! - [`averaged`]: the ring-down of Vitorino, Vieira and Rodrigues, eqs. (15) to (18), next to the exact forms that
//!   they approximate.

pub(crate) mod amplitude;
pub mod averaged;
pub(crate) mod backbone;
pub(crate) mod closed_path;
pub(crate) mod closed_sums;
mod dense;
pub(crate) mod drag;
mod exact;
pub(crate) mod half_cycle;
pub mod law;
pub(crate) mod parameters;
pub(crate) mod path;
mod turns;
mod waveform;
pub(crate) mod window;

pub use amplitude::{AmplitudeLaw, drag_rate, sliding_rate};
pub use exact::{FreeDecay, HalfCycleLoss, Stop, TurningPoint, TurningPoints};
