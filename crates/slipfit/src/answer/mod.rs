//! What every analysis answers with: parameters with uncertainties, and what they rest on.

pub mod comparison;
pub(crate) mod describe;
pub mod hint;
pub mod parameter;
pub mod quantity;
#[cfg(feature = "serde")]
mod serialise;

pub use comparison::{Candidate, Correlation, SlidingEvidence, Values};
pub use hint::Hint;
pub use parameter::{Parameter, Parameters, UnitRule};
