//! Preparation of a curve: checks, peak and noise, means of dense points.

use super::Options;
use super::block::Block;
use super::criteria::Criteria;
use super::instrument_start::{InstrumentStart, baseline};
use super::peak::{self, Peak};
use crate::Error;
use crate::motion::steady::Phasor;

/// A curve before any hypothesis about it.
#[derive(Clone)]
pub(super) struct PreparedCurve {
    /// The points that are fitted.
    pub(super) main: Block,
    pub(super) reference: Option<Block>,
    /// All points, if the fit uses means of neighbours.
    pub(super) all: Option<Block>,
    /// Number of points in each mean.
    pub(super) group: usize,
    /// Shift of each mean due to the curvature within its group; empty if not yet determined.
    pub(super) lost: Vec<Phasor>,
    /// The peak of the points, or of the points with the baseline subtracted.
    pub(super) peak: Peak,
    /// The straight baseline of the peak.
    pub(super) baseline: Option<InstrumentStart>,
    /// Noise of one measured amplitude.
    pub(super) noise: f64,
    /// The same for the points that are fitted.
    pub(super) fitted_noise: f64,
}

impl PreparedCurve {
    pub(super) fn new(
        mut main: Block,
        reference: Option<Block>,
        options: &Options,
        criteria: &Criteria,
    ) -> Result<Self, Error> {
        let no = |reason| Error::NoResonance { reason };
        let mut peak = peak::find(&main).ok_or(no("every amplitude is zero"))?;
        if main.len() < criteria.preparation.least_points {
            let parameters = criteria.preparation.least_points - 1;
            return Err(Error::TooFewPoints { points: main.len(), parameters });
        }
        let noise = peak::noise(&main);
        if peak::is_flat(&main, &criteria.peak) {
            return Err(no("every point has the same response"));
        }
        let allowed = options.terms.background != Some(false);
        let baseline = baseline(&main, &peak, &criteria.instrument).filter(|_| allowed);
        if let Some(baseline) = &baseline {
            peak = baseline.peak;
        }
        // A dense curve is fitted by means of neighbours whose spacing is much smaller than the width of the peak.
        let spacing = (main.omega[main.len() - 1] - main.omega[0]) / main.len() as f64;
        let width = criteria.preparation.group_width * peak.half_width;
        let most = (width / spacing.max(f64::MIN_POSITIVE)) as usize;
        let group = (main.len() / criteria.preparation.dense_points).min(most).max(1);
        let all = (group > 1).then(|| {
            let means = main.grouped(group);
            peak.index /= group;
            std::mem::replace(&mut main, means)
        });
        let fitted_noise = if all.is_some() { peak::noise(&main) } else { noise };
        Ok(Self { main, reference, all, group, lost: Vec::new(), peak, baseline, noise, fitted_noise })
    }

    /// The same curve with these weights of the fitted points.
    pub(super) fn weighted(&self, weight: &[f64]) -> Self {
        let main = Block { weight: weight.to_vec(), ..self.main.clone() };
        Self { main, ..self.clone() }
    }

    /// All points, fitted or part of a mean.
    pub(super) fn every_point(&self) -> &Block {
        self.all.as_ref().unwrap_or(&self.main)
    }
}
