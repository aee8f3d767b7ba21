//! From fits to the answer a person reads.

use super::along::{backbone, envelope_points, fitted_motion, loss_points, stop};
use super::envelope::{A0, DELTA, DRAG, X_F, law_of};
use super::fits::{Described, Problem};
use super::law::LossLaw;
use super::measure::{Measured, Samples};
use super::quantities::{angular_frequency, parameters};
use super::ranked::Entry;
use super::waveform::OMEGA;
use super::{
    Answer, Candidate, Diagnostics, Distortion, LossModel, Options, OtherMode, Segment, SlidingEvidence,
};
use crate::numeric::roots::border;
use crate::signal::blocks::Block;
use crate::signal::spectrum;
use crate::{Error, Record, SignalKind};
use std::f64::consts::TAU;

/// All that was found out.
pub(crate) struct Evidence<'a> {
    pub(crate) record: &'a Record,
    pub(crate) options: &'a Options,
    pub(crate) samples: &'a Samples<'a>,
    pub(crate) measured: &'a Measured,
    pub(crate) described: &'a Described<'a>,
    pub(crate) cycles: f64,
}

/// p value below which sliding friction counts as seen.
const DETECTED: f64 = 0.01;

pub(crate) fn answer(e: &Evidence) -> Result<Answer, Error> {
    let comparison = &e.described.comparison;
    let preferred = comparison.best().ok_or(Error::NoFit { reason: "no model converged" })?;
    let (p_value, delta_bic) = comparison.sliding_evidence(e.described.scale);
    let chosen = match e.options.model {
        Some(model) => comparison.get(model).ok_or(Error::NoFit {
            reason: "the model asked for has more parameters than the record determines",
        })?,
        // Either alone would look far surer than it is. A viscous loss that BIC spares may be four
        // standard errors large, and sliding friction would be given what is its.
        None if matches!(preferred.model, LossModel::Viscous | LossModel::Sliding) => comparison
            .get(LossModel::ViscousSliding)
            .filter(|both| {
                preferred.model == LossModel::Sliding || super::doubts::undecided(e, both, p_value)
            })
            .unwrap_or(preferred),
        None => preferred,
    };
    let omega = angular_frequency(e, chosen);
    let law = law_of(&chosen.bounded.parameters, omega);
    let duration = e.described.end - e.described.origin;
    let sliding = SlidingEvidence {
        detected: p_value < DETECTED && delta_bic > 0.0,
        p_value,
        delta_bic,
        share_at_start: law.shares(law.amplitude_0)[0],
        share_at_end: law.shares(last_amplitude(e, &law))[0],
        dominates_from_s: dominates_from(&law, duration).map(|t| e.described.origin + t),
        viscous_only_p_value: comparison.viscous_only(chosen.model, e.described.scale),
    };
    let fit = fitted_motion(e, chosen, law, omega);
    let parameters = parameters(e, chosen, omega);
    let best_bic = comparison.entries.iter().map(|c| c.bic).fold(f64::INFINITY, f64::min);
    let mut candidates: Vec<Candidate> =
        comparison.entries.iter().map(|c| candidate(e, c, best_bic)).collect();
    candidates.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let correlations = correlations(e, chosen);
    let envelope = envelope_points(e, &fit);
    let diagnostics = diagnostics(e, chosen, &law);
    let stop = stop(e);
    let mut answer = Answer {
        model: chosen.model,
        parameters,
        comparison: candidates,
        sliding,
        correlations,
        segment: segment_of(e),
        loss: loss_points(e, &law, omega),
        envelope,
        backbone: backbone(e, chosen, &law, omega),
        stop,
        diagnostics,
        warnings: Vec::new(),
        signal_unit: e.record.unit().to_owned(),
        fit,
    };
    answer.warnings = super::doubts::doubts(e, &answer, preferred.model);
    Ok(answer)
}

fn candidate(e: &Evidence, entry: &Entry, best_bic: f64) -> Candidate {
    let p = &entry.bounded.parameters;
    let n = e.described.scale.observations;
    Candidate {
        model: entry.model,
        bic: entry.bic,
        delta_bic: entry.bic - best_bic,
        rms: match &e.described.problem {
            Problem::Waveform(_) => (entry.bounded.rss / n).sqrt(),
            Problem::Envelope(problem) => problem.unweighted_rms(p),
        },
        free_parameters: entry.fit.free.len(),
        converged: entry.fit.converged,
        at_limit: entry.at_limit.map(|t| match t {
            X_F => "friction_displacement",
            DELTA => "decay_rate_per_s",
            _ => "drag_rate",
        }),
        initial_amplitude: p[A0],
        decay_rate_per_s: p[DELTA],
        friction_displacement: p[X_F],
        drag_rate: p[DRAG],
    }
}

fn correlations(e: &Evidence, chosen: &Entry) -> Vec<(&'static str, &'static str, f64)> {
    let mut named = vec![
        (A0, "initial_amplitude"),
        (DELTA, "decay_rate_per_s"),
        (X_F, "friction_displacement"),
        (DRAG, "drag_rate"),
    ];
    if matches!(e.described.problem, Problem::Waveform(_)) {
        named.push((OMEGA, "frequency_hz"));
    }
    let mut list = Vec::new();
    for (i, &(a, name_a)) in named.iter().enumerate() {
        for &(b, name_b) in &named[i + 1..] {
            if chosen.fit.free.contains(&a) && chosen.fit.free.contains(&b) {
                list.push((name_a, name_b, chosen.fit.correlation(a, b)));
            }
        }
    }
    let pair = ("decay_rate_per_s", "friction_displacement");
    if !list.iter().any(|c| (c.0, c.1) == pair)
        && let Some(both) = e.described.comparison.get(LossModel::ViscousSliding)
    {
        list.push((pair.0, pair.1, both.fit.correlation(DELTA, X_F)));
    }
    list
}

fn segment_of(e: &Evidence) -> Segment {
    let points = &e.measured.points;
    Segment {
        start_s: e.described.origin,
        end_s: e.described.end.min(e.samples.time[e.samples.time.len() - 1]),
        samples: points[points.len() - 1].end - points[0].first,
        start_reason: e.measured.stretch.start_reason,
        end_reason: e.measured.stretch.end_reason,
        cycles: if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
            0.0
        } else {
            e.cycles
        },
    }
}

/// Last amplitude of the law inside the segment, never below zero.
pub(crate) fn last_amplitude(e: &Evidence, law: &LossLaw) -> f64 {
    law.amplitude(e.described.end - e.described.origin)
}

/// First time from which sliding carries more than 95 % of the loss to the end.
fn dominates_from(law: &LossLaw, duration: f64) -> Option<f64> {
    let share = |t: f64| law.shares(law.amplitude(t))[0];
    if !(law.a0 > 0.0) || share(duration) <= 0.95 {
        return None;
    }
    if share(0.0) > 0.95 {
        return Some(0.0);
    }
    // The share grows as the amplitude falls.
    Some(border(duration, 0.0, |t| share(t) > 0.95).0)
}

fn diagnostics(e: &Evidence, chosen: &Entry, law: &LossLaw) -> Diagnostics {
    let variance = e.described.scale.variance_of(&chosen.bounded);
    let residual_rms = match &e.described.problem {
        Problem::Waveform(_) => (chosen.bounded.rss / e.described.scale.observations).sqrt(),
        Problem::Envelope(_) => variance.sqrt(),
    };
    let noise = e.measured.noise_rms;
    let (other_modes, distortion) = other_modes(e);
    Diagnostics {
        method: e.described.problem.method(),
        noise_rms: noise,
        residual_rms,
        residual_excess: e.described.excess,
        residual_autocorrelation: e.described.autocorrelation,
        signal_to_noise_db: 20.0
            * (law.amplitude_0 / std::f64::consts::SQRT_2 / noise.max(f64::MIN_POSITIVE)).log10(),
        decay_times: (law.amplitude_0 / last_amplitude(e, law).max(1e-9 * law.amplitude_0)).ln().max(0.0),
        left_out: e.described.outliers,
        other_modes,
        distortion,
    }
}

/// Lines of the free decay that are neither the main one nor its harmonics.
fn other_modes(e: &Evidence) -> (Vec<OtherMode>, Option<Distortion>) {
    if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
        return (Vec::new(), None);
    }
    let points = &e.measured.points;
    let range = points[0].first..points[points.len() - 1].end;
    let (time, signal) = (&e.samples.time[range.clone()], &e.samples.signal[range]);
    let main = e.measured.law.mean_omega / TAU;
    // The main line is as wide as its own frequency wanders from start to end.
    let mean = |part: &[Block]| part.iter().map(|b| b.omega).sum::<f64>() / part.len() as f64 / TAU;
    let quarter = points.len().div_ceil(4);
    let spread = (mean(&points[..quarter]) - mean(&points[points.len() - quarter..])).abs() / main;
    let Some(periodogram) = spectrum::Periodogram::of(time, signal) else { return (Vec::new(), None) };
    let Some(own) = spectrum::dominant_of(&periodogram, time, signal, None) else {
        return (Vec::new(), None);
    };
    let others = spectrum::other_lines(&periodogram, main, (2.0 * spread).max(0.02), 0.05 * own.amplitude)
        .into_iter()
        .map(|l| OtherMode { frequency_hz: l.frequency_hz, relative_amplitude: l.amplitude / own.amplitude })
        .collect();
    let distortion = spectrum::strongest_harmonic(&periodogram, main)
        .map(|(order, amplitude)| Distortion { order, relative_amplitude: amplitude / own.amplitude });
    (others, distortion)
}
