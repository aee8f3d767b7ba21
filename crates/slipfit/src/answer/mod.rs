//! What every analysis returns: parameters with uncertainties, and the evidence for them.

pub(crate) mod averaged;
pub mod calibration;
pub(crate) mod columns;
pub mod comparison;
pub(crate) mod criteria;
pub(crate) mod describe;
mod error_hints;
pub(crate) mod figures;
pub mod hint;
mod misfit;
mod p_value;
pub mod parameter;
pub mod quantity;
pub mod rounded;
#[cfg(feature = "serde")]
pub(crate) mod serialise;
pub mod warning;

pub use comparison::{Candidate, Correlation, SlidingEvidence, Values};
pub use criteria::ReportCriteria;
pub use hint::Hint;
pub use misfit::{Misfit, MisfitShape};
pub(crate) use p_value::p_value;
pub use parameter::{Parameter, Parameters};
pub use warning::Warning;
