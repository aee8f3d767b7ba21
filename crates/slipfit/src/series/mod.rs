//! Several measurements of one oscillator: each alone, all together, and the agreement of the methods (the paper's
//! Table 1); friction against load.

mod analyse;
mod answer;
mod comparison;
mod criteria;
mod drag;
mod joint;
mod law;
mod likelihood;
mod measurement;
mod scatter;
mod single;
mod solved;

pub use analyse::{analyse, analyse_with};
pub use answer::{Answer, ConditionRow, Consistency, Estimate, Joint, RepeatScatter, SingleAnswer};
pub use criteria::Criteria;
pub use law::{LawFit, LoadLaw, LoadPoint, friction_against_load};
pub use measurement::{Condition, Data, Measurement, Options, Shared, common_unit};
