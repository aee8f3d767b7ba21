//! The record as it is drawn, to zoom in and to drag a window over.

use serde::Serialize;
use slipfit::ringdown::Answer;
use slipfit_io::Reading;
use slipfit_report::plot::decimate;

/// Columns of a screen times the zoom that still shows every extreme.
const COLUMNS: usize = 4000;

/// Samples of a record and the fit at their instants.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trace {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// The signal; of a lock-in its modulus.
    pub signal: Vec<f64>,
    /// The fitted motion; null outside the fitted stretch.
    pub fitted: Vec<Option<f64>>,
    /// Unit of both.
    pub unit: String,
    /// First and last instant used, s.
    pub used_s: [f64; 2],
}

impl Trace {
    pub(crate) fn new(reading: &Reading, answer: &Answer) -> Self {
        let record = &reading.record;
        let value = |i: usize| match record.quadrature() {
            Some(quadrature) => record.signal()[i].hypot(quadrature[i]),
            None => record.signal()[i],
        };
        let points = (0..record.len()).map(|i| [record.time_s(i), value(i)]);
        let drawn = decimate(points, [record.time_s(0), record.time_s(record.len() - 1)], COLUMNS);
        let [start, end] = answer.fit.range_s();
        let fitted = |p: &[f64; 2]| (start..=end).contains(&p[0]).then(|| answer.fit.signal_at(p[0]));
        Self {
            time_s: drawn.iter().map(|p| p[0]).collect(),
            signal: drawn.iter().map(|p| p[1]).collect(),
            fitted: drawn.iter().map(fitted).collect(),
            unit: answer.signal_unit.clone(),
            used_s: [answer.segment.start_s, answer.segment.end_s],
        }
    }
}
