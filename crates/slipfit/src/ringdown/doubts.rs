//! Which warnings an answer deserves.

use super::assemble::Evidence;
use super::segment;
use super::{Answer, LossModel, Warning};
use crate::SignalKind;
use crate::signal::extremes;

/// Fewer cycles than this cannot separate the loss terms.
const FEW_CYCLES: f64 = 5.0;
/// Beyond this correlation delta and x_F are one number.
const INSEPARABLE: f64 = 0.99;

pub(crate) fn doubts(e: &Evidence, answer: &Answer, preferred: LossModel) -> Vec<Warning> {
    let mut list = Vec::new();
    let bare = matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    if !bare && e.cycles < FEW_CYCLES {
        list.push(Warning::TooFewCycles { cycles: e.cycles });
    }
    let correlation = answer.correlation("decay_rate_per_s", "friction_displacement").unwrap_or(0.0);
    let x_f_known = answer.sliding.p_value < 1e-4;
    if correlation.abs() > INSEPARABLE && !x_f_known {
        list.push(Warning::NotSeparable { correlation, decay_times: answer.diagnostics.decay_times });
    }
    if let Some(other) = answer.diagnostics.other_modes.iter().find(|m| m.relative_amplitude > 0.12) {
        list.push(Warning::SeveralModes {
            main_hz: answer.parameter("frequency_hz").map_or(f64::NAN, |q| q.value),
            other_hz: other.frequency_hz,
            relative_amplitude: other.relative_amplitude,
        });
    }
    let excess = answer.diagnostics.residual_excess;
    if excess > 4.0 {
        list.push(Warning::ModelMisfit { excess });
    }
    if e.measured.stretch.slow_tail {
        let end = answer.segment.end_s;
        list.push(Warning::SlowTail {
            amplitude: answer.fit.amplitude_at(end),
            time_s: end,
            unit: answer.signal_unit.clone(),
        });
    } else if e.measured.stretch.end_reason == segment::OTHER_LAW {
        list.push(Warning::LawChanges { time_s: answer.segment.end_s });
    }
    if e.measured.stretch.disturbed {
        list.push(Warning::Disturbance { time_s: answer.segment.end_s });
    }
    let clipped = clipped(&e.samples.signal);
    if !bare && clipped.0 > 0 {
        let first = e.measured.points[0].first;
        list.push(Warning::Clipped { samples: clipped.0, inside: clipped.1 > first });
    }
    if let Some(asked) = e.options.model {
        let worse = answer.comparison.iter().find(|c| c.model == asked).map_or(0.0, |c| c.delta_bic);
        if asked != preferred && worse > 2.0 {
            list.push(Warning::ModelNotPreferred { asked, preferred, delta_bic: worse });
        }
    } else if let Some(rival) = answer
        .comparison
        .iter()
        .find(|c| c.model != answer.model && c.at_limit.is_none() && c.delta_bic < 2.0)
        .filter(|r| r.model.has_sliding() != answer.model.has_sliding() || r.free_parameters == free(answer))
    {
        list.push(Warning::AmbiguousModel {
            chosen: answer.model,
            rival: rival.model,
            delta_bic: rival.delta_bic,
        });
    }
    if !bare {
        let points = &e.measured.points;
        let samples = points.iter().map(|b| b.end - b.first).sum::<usize>() as f64;
        let per_cycle = samples / e.cycles;
        if per_cycle < 3.0 {
            list.push(Warning::CoarseSampling { samples_per_cycle: per_cycle });
        }
    } else if e.options.frequency_hz.is_none() {
        list.push(Warning::FrequencyUnknown);
    }
    list
}

fn free(answer: &Answer) -> usize {
    answer.comparison.iter().find(|c| c.model == answer.model).map_or(0, |c| c.free_parameters)
}

/// Samples stuck at the extremes of the record in runs of at least four, and the index after the last.
pub(crate) fn clipped(signal: &[f64]) -> (usize, usize) {
    let extremes: Vec<(f64, f64)> = signal.chunks(CHUNK).map(extremes).collect();
    let (low, high) =
        extremes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), e| (a.min(e.0), b.max(e.1)));
    let (mut count, mut last, mut runs, mut run) = (0, 0, 0, 0);
    for (chunk, _) in extremes.iter().enumerate().filter(|(_, e)| e.0 == low || e.1 == high) {
        let first = chunk * CHUNK;
        for (i, &v) in signal.iter().enumerate().skip(first).take(CHUNK) {
            let stuck = v == high || v == low;
            // A run goes on across the edge of a chunk, for its value is an extreme of both.
            if stuck && (run == 0 || signal[i - 1] == v) {
                run += 1;
            } else {
                run = usize::from(stuck);
            }
            if run == 4 {
                runs += 1;
                count += 4;
                last = i + 1;
            } else if run > 4 {
                count += 1;
                last = i + 1;
            }
        }
    }
    if runs >= 3 { (count, last) } else { (0, 0) }
}

/// Samples whose extremes are found together.
const CHUNK: usize = 1024;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipping_is_counted_across_the_edges_of_chunks() {
        let mut signal: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.37).sin() * 0.9).collect();
        assert_eq!(clipped(&signal), (0, 0));
        signal[1020..1030].fill(1.0);
        signal[3000..3003].fill(1.0);
        signal[3500..3505].fill(-1.0);
        assert_eq!(clipped(&signal), (0, 0), "two runs are no clipping");
        signal[4990..4996].fill(-1.0);
        assert_eq!(clipped(&signal), (10 + 5 + 6, 4996));
    }
}
