//! Windows in which the exact motion may describe every sample, and the choice among them.

use super::amplitude_fit::fit_amplitudes;
use super::compare::Models;
use super::criteria::Criteria;
use super::envelope::law_of;
use super::measured::MeasuredDecay;
use super::options::Options;
use super::oscillation::from_the_first_block;
use super::samples::Samples;
use super::waveform_fit::{fit_waveform, start_values};
use super::window::by_waveform::{agreeing_end, agrees};
use super::window::{EndReason, StartReason};
use super::window_fit::WindowFit;
use crate::model::loss::LossModel;
use std::f64::consts::TAU;

/// The first 1/50 to 1/4 of the blocks, which may still belong to a drive.
const LEAD_IN_PARTS: [usize; 7] = [50, 25, 16, 12, 8, 6, 4];

/// A free decay and the fit that describes it.
pub(crate) struct FittedDecay<'a> {
    pub(crate) measured: MeasuredDecay,
    pub(crate) fit: WindowFit<'a>,
}

/// The decay described sample by sample, or by its amplitudes if no exact motion describes it.
///
/// The first of the following hypotheses whose residuals are noise is accepted:
///
/// 1. the decay begins with the record: what looked like a lead-in in the amplitudes of single blocks was
///    their noise;
/// 2. it begins where the amplitudes indicate;
/// 3. it begins later, with more and more of the first blocks left out: blocks that still belong to a
///    drive distort the law slightly and remain undetected.
///
/// If none is accepted, the law is in error, and the second hypothesis is used; likewise if the record itself
/// or an option determines the start of the decay.
pub(crate) fn by_waveform<'a>(
    samples: &'a Samples,
    by_amplitudes: FittedDecay<'a>,
    options: &Options,
    criteria: &Criteria,
) -> FittedDecay<'a> {
    let fit = |mut measured: MeasuredDecay| {
        let amplitudes = fit_amplitudes(&mut measured, options, criteria).ok()?;
        let fit = to_the_end(samples, &measured, &amplitudes, options.model, criteria)?;
        Some(FittedDecay { measured, fit })
    };
    let agrees = |d: &FittedDecay| agrees(&d.fit, samples, &d.measured, &criteria.agreement);
    let in_doubt =
        options.start_s.is_none() && by_amplitudes.measured.window.start_reason == StartReason::LeadIn;
    if in_doubt
        && let Some(whole) =
            from_the_first_block(samples, &by_amplitudes.measured, criteria).and_then(fit).filter(agrees)
    {
        return whole;
    }
    let exact = to_the_end(samples, &by_amplitudes.measured, &by_amplitudes.fit, options.model, criteria)
        .filter(|fit| reaches_the_noise(fit, &by_amplitudes.measured, criteria));
    let as_measured = match exact {
        Some(fit) => FittedDecay { fit, ..by_amplitudes },
        None => by_amplitudes,
    };
    if !in_doubt || agrees(&as_measured) {
        return as_measured;
    }
    let later = later_starts(&as_measured.measured, criteria.lead_in.spare_blocks);
    let later = later.filter_map(fit).find(agrees);
    later.unwrap_or(as_measured)
}

/// The decay without some of its first blocks; none can be spared if there are few blocks.
fn later_starts(measured: &MeasuredDecay, spare: usize) -> impl Iterator<Item = MeasuredDecay> {
    let n = measured.points.len();
    let parts = if n < spare { &[] } else { &LEAD_IN_PARTS[..] };
    parts.iter().map(move |part| {
        let mut later = measured.clone();
        later.points.drain(..n.div_ceil(*part));
        later
    })
}

/// Whether the residuals of the exact waveform are as small as the noise of the samples.
fn reaches_the_noise(fit: &WindowFit, measured: &MeasuredDecay, criteria: &Criteria) -> bool {
    let Some(best) = fit.comparison.preferred() else { return false };
    let variance = fit.comparison.noise.residual_variance(&best.bounded);
    variance <= criteria.waveform.variance_ratio * measured.noise_rms.powi(2)
}

/// The waveform fitted to every sample from the first block on. If the decay fades, the window ends with the
/// record if one motion agrees with all samples, otherwise where the agreement ends: samples and rest
/// position carry information even below the noise of single blocks.
fn to_the_end<'a>(
    samples: &'a Samples,
    measured: &MeasuredDecay,
    by_amplitudes: &WindowFit,
    asked: Option<LossModel>,
    criteria: &Criteria,
) -> Option<WindowFit<'a>> {
    let (from, to) = (measured.points.first()?.first, measured.points.last()?.end);
    let best = by_amplitudes.comparison.preferred()?;
    let law = law_of(&best.bounded.parameters, measured.law.omega);
    let loss_per_cycle = law.rate(law.initial) / law.initial * TAU / measured.law.omega;
    if to - from > criteria.waveform.most_samples
        || !measured.phase_follows_law
        || loss_per_cycle < criteria.waveform.least_loss
    {
        return None;
    }
    let n = samples.len();
    let fit =
        |end, start, models| fit_waveform(samples, measured, from..end, start, (asked, models), criteria);
    // A record that ends during the free decay is used to its last sample rather than its last whole block.
    let ends_free = measured.all.last().is_some_and(|b| b.end == to);
    let to = if ends_free { n } else { to };
    let first = start_values(samples, measured, by_amplitudes)?;
    let fades = matches!(measured.window.end_reason, EndReason::Noise | EndReason::Rest);
    if !fades || ends_free {
        return fit(to, first, Models::All);
    }
    // This window is seldom the final one.
    let rivals = Models::Rivals { within: criteria.waveform.not_fitted };
    let found = fit(to, first.clone(), rivals)?;
    let start = &found.comparison.preferred()?.bounded.parameters;
    if n - from <= criteria.waveform.most_samples
        && let Some(whole) = fit(n, start.clone(), Models::All)
        && agrees(&whole, samples, measured, &criteria.agreement)
    {
        return Some(whole);
    }
    let end = agreeing_end(samples, measured, &found, from, to, &criteria.agreement)?;
    let longer = if end > to { fit(end, start.clone(), Models::All) } else { None };
    longer.or_else(|| fit(to, first, Models::All))
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};
    use std::f64::consts::{PI, TAU};

    /// Friction causes most of the loss and ends the motion after about ten cycles, at 60 dB: the phases of
    /// the last blocks lag by hundreds of their errors.
    #[test]
    fn the_last_swings_before_a_rest_are_fitted_sample_by_sample() {
        let (q, share, noise) = (100.0, 0.7, 7e-4);
        let total = TAU / (2.0 * q);
        let x_f = share / (1.0 - share) * total * PI / (2.0 * TAU);
        let oscillator = Oscillator::kinematic(TAU, total, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        assert!(decay.stop().is_some_and(|stop| stop.time_s < 40.0));
        let time: Vec<f64> = (0..2387).map(|i| i as f64 / 30.0).collect();
        for repeat in 0..20 {
            let noisy =
                |(i, &t): (usize, &f64)| decay.displacement(t) + noise * jitter(repeat * time.len() + i, 11);
            let record = Record::new(time.clone(), time.iter().enumerate().map(noisy).collect());
            let answer = analyse(&record.expect("valid"), &Options::default()).expect("a ring-down");
            assert_eq!(answer.diagnostics.method, "waveform", "record {repeat}");
        }
    }
}
