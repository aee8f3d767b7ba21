//! Any motion, event by event, with closed forms between events.
//!
//! [`Motion`] simulates an [`Oscillator`](crate::Oscillator) under a [`Drive`]: at rest, harmonic, several harmonics,
//! a frequency sweep, samples, or several of these in sequence. Friction may be asymmetric ([`Friction`]). Laws that
//! depend on speed, which have no closed form, are in [`smooth`].

mod arc;
mod certify;
mod drive;
mod event;
mod local;
mod motion;
#[cfg(feature = "smooth-laws")]
pub mod smooth;
mod tangent;
mod transition;

pub use drive::{Drive, Harmonic};
pub use event::{Event, EventKind, Friction, State};
pub use motion::Motion;
pub use tangent::Tangent;
