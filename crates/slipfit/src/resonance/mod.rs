//! Resonance curves: viscous and sliding loss from amplitudes (and phases) versus frequency.

mod alternatives;
mod analyse;
mod answer;
mod assemble;
mod averaged;
mod background_minima;
mod bias;
mod block;
mod criteria;
mod curve;
mod direct;
mod fitted;
mod fitted_models;
mod force;
mod free_gain;
mod hypothesis;
mod hypothesis_fit;
mod instrument_start;
mod lag;
mod lanes;
mod lost_curvature;
mod measured_columns;
mod models;
mod noise;
mod options;
mod paper;
mod peak;
mod prepared;
mod presence;
mod problem;
mod quantities;
mod reference;
mod residuals;
mod response;
mod search;
mod selection;
mod start;
mod sums;
mod term_sets;
#[cfg(test)]
mod term_sets_tests;
mod terms;
mod warnings;
mod work;
#[cfg(test)]
mod work_tests;

pub use analyse::{analyse, analyse_with};
pub use answer::{
    Answer, CurvePoint, Diagnostics, DriveSource, ForceLine, ForcePoint, Instrument, PaperEstimate,
    ReferenceFit,
};
pub use criteria::{
    AnswerCriteria, ColumnCriteria, Criteria, ForceCriteria, InstrumentCriteria, LagCriteria,
    LossModelCriteria, NoiseCriteria, PeakCriteria, PreparationCriteria, ReferenceCriteria, ResidualCriteria,
    SearchCriteria, SelectionCriteria, TermCriteria,
};
pub use curve::{Curve, CurveBuilder, Dropped, Response, Run, RunDirection};
pub use direct::{CurveFit, fit};
pub use fitted::FittedCurve;
pub use options::{DriveAmplitude, Method, Options, Terms};
