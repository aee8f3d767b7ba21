//! The amplitudes of a measured decay as input of the model-free law.

use super::answer::FreeLaw;
use super::estimate::{Amplitudes, estimate};
use crate::inference::model_selection::ModelFit;
use crate::ringdown::envelope::FLOOR;
use crate::ringdown::evidence::Evidence;
use crate::ringdown::lowpass::Kernel;
use crate::ringdown::options::LawOption;
use crate::ringdown::quantities::{angular_frequency, frequency_known};
use crate::ringdown::window_fit::Problem;

/// The model-free law, if it was requested and the amplitudes allow one.
pub(crate) fn free_law(e: &Evidence, chosen: &ModelFit) -> Option<FreeLaw> {
    let asked = e.options.law?;
    let points = &e.measured.points;
    let origin = e.measured.start_s();
    let floor = match &e.fit.problem {
        Problem::Envelope(problem) if problem.squared => Some(chosen.bounded.parameters[FLOOR].max(0.0)),
        _ => None,
    };
    let data = Amplitudes {
        time_s: points.iter().map(|b| b.time_s - origin).collect(),
        amplitude: points.iter().map(|b| b.amplitude).collect(),
        unit_variance: points.iter().map(|b| b.unit_variance).collect(),
        // A band-pass leaves no noise inside a block to be measured.
        noise_variance: if e.options.band_hz.is_some() { 0.0 } else { e.measured.noise_rms.powi(2) },
        floor,
        delays: e.options.lockin.map_or_else(Vec::new, |filter| Kernel::new(filter).nodes),
        omega: frequency_known(e).then(|| angular_frequency(e, chosen)),
        unit: e.record.unit().to_owned(),
    };
    let significance = e.criteria.inference.excess_significance;
    estimate(&data, asked == LawOption::Rising, significance, &e.criteria.free_law)
}
