//! Resonance curves: from amplitudes (and phases) over frequency to how much of the
//! loss is viscous and how much is sliding.

mod analyse;
mod answer;
mod assemble;
mod bias;
mod block;
mod curve;
mod described;
mod direct;
mod fits;
mod fitted;
mod force;
mod instrument_start;
mod lanes;
mod models;
mod options;
mod paper;
mod peak;
mod prepared;
mod problem;
mod reference;
mod residuals;
mod response;
mod search;
mod start;
mod sums;
mod terms;
mod warnings;

pub use analyse::analyse;
pub use answer::{
    Answer, CurvePoint, Diagnostics, DriveSource, ForceLine, ForcePoint, Instrument, PaperEstimate,
    ReferenceFit,
};
pub use curve::{Curve, CurveBuilder, Dropped, Response, Run, RunDirection};
pub use direct::{CurveFit, fit};
pub use fitted::FittedCurve;
pub use options::{DriveAmplitude, Method, Options, Terms};
