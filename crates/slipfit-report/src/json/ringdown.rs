//! The answer to a ring-down, turned into the contract's keys.

use super::contract::*;
use super::layout;
use crate::AnalysedRingdown;
use crate::Sentence;
use slipfit::Calibration;
use slipfit::Parameter;
use slipfit::ringdown::{Answer, Options};
use slipfit::{ClockReport, SignalKind};
use slipfit_io::{ColumnInfo, ColumnTaken, TimeSource};
use std::io::{self, Write};

/// Writes the whole answer.
pub fn ringdown(out: &mut dyn Write, analysed: &AnalysedRingdown<'_>) -> io::Result<()> {
    layout::write(out, &Document::new(analysed))
}

impl<'a> Document<'a> {
    fn new(analysed: &AnalysedRingdown<'a>) -> Self {
        let a = analysed.answer;
        Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            command: "ringdown",
            input: Input::new(analysed),
            options: Asked::new(analysed.options),
            model: a.model.name(),
            sentence: a.sentence(),
            parameters: &a.parameters,
            comparison: compared(a),
            sliding: sliding(a),
            correlations: a
                .correlations
                .iter()
                .map(|c| Correlated { parameters: c.parameters.map(|p| p.name()), value: c.value })
                .collect(),
            segment: segment(a),
            backbone: backbone(a),
            stop: stop(a),
            diagnostics: diagnostics(a),
            warnings: a.warnings.iter().map(|w| Doubt { code: w.code(), message: w.to_string() }).collect(),
            loss: loss(a),
            envelope: envelope(a),
        }
    }
}

impl<'a> Input<'a> {
    fn new(analysed: &AnalysedRingdown<'a>) -> Self {
        let report = &analysed.reading.report;
        let record = &analysed.reading.record;
        Self {
            path: analysed.file.display().to_string(),
            sha256: &report.sha256,
            bytes: report.bytes,
            rows_read: report.rows_read,
            rows_skipped: report.rows_skipped(),
            skipped: report
                .skipped
                .iter()
                .map(|s| Skipped { reason: &s.reason, rows: s.rows, first_row: s.first_row })
                .collect(),
            columns: report.columns.iter().map(column).collect(),
            table: report.table,
            tables: report.tables,
            run: report.run,
            runs: report.runs,
            time: time(&report.time),
            signal: taken(&report.signal),
            quadrature: report.quadrature.as_ref().map(taken),
            kind: kind(report.kind),
            unit: record.unit(),
            samples: record.len(),
            time_range_s: [record.time_s(0), record.time_s(record.len() - 1)],
            time_range_used_s: [analysed.answer.segment.start_s, analysed.answer.segment.end_s],
            clock: clock(record.clock_report(), record.clock().is_uniform()),
            notes: &report.notes,
        }
    }
}

fn column(info: &ColumnInfo) -> Column<'_> {
    Column { number: info.number, header: &info.header, unit: &info.unit }
}

fn taken(taken: &ColumnTaken) -> Taken<'_> {
    Taken { number: taken.column.number, header: &taken.column.header, unit: &taken.unit, why: &taken.why }
}

fn time(source: &TimeSource) -> Time<'_> {
    match source {
        TimeSource::Column(c) => Time { source: "column", column: Some(taken(c)), rate_hz: None },
        TimeSource::Intervals(c) => Time { source: "intervals", column: Some(taken(c)), rate_hz: None },
        TimeSource::Rate(rate) => Time { source: "rate", column: None, rate_hz: Some(*rate) },
        _ => Time { source: "other", column: None, rate_hz: None },
    }
}

pub(super) fn kind(kind: SignalKind) -> &'static str {
    match kind {
        SignalKind::Displacement => "displacement",
        SignalKind::Velocity => "velocity",
        SignalKind::Acceleration => "acceleration",
        SignalKind::Envelope => "envelope",
        SignalKind::LockIn => "lock-in",
        _ => "other",
    }
}

fn clock(report: &ClockReport, uniform: bool) -> ClockAccount {
    ClockAccount {
        uniform,
        median_step_s: report.median_step_s,
        step_spread: report.step_spread,
        nonfinite_rows: report.nonfinite(),
        repeated_stamps: report.repeated_stamps,
        reordered_rows: report.reordered,
        corrupt_stamps: report.corrupt_stamps,
        resets: report.resets,
        other_run_rows: report.other_run_rows,
        gaps: report.gaps,
        longest_gap_s: report.longest_gap.map(|g| g.length_s),
        rebuilt_quantum_s: report.rebuilt_quantum_s,
    }
}

impl Asked {
    fn new(options: &Options) -> Self {
        Self {
            start_s: options.start_s,
            end_s: options.end_s,
            min_amplitude: options.min_amplitude,
            band_hz: options.band_hz,
            model: options.model.map(|m| m.name()),
            lockin_time_constant_s: options.lockin.map(|l| l.time_constant_s),
            lockin_order: options.lockin.map(|l| l.order),
            frequency_hz: options.frequency_hz,
            calibration: options.calibration.and_then(|c| match c {
                Calibration::Stiffness { value, std_error } => {
                    Some(Constant { kind: "stiffness", value, std_error })
                }
                Calibration::Mass { value, std_error } => Some(Constant { kind: "mass", value, std_error }),
                _ => None,
            }),
        }
    }
}

fn compared(a: &Answer) -> Vec<Compared> {
    let one = |c: &slipfit::answer::Candidate| Compared {
        model: c.model.name(),
        bic: c.bic,
        delta_bic: c.delta_bic,
        rms: c.rms,
        free_parameters: c.free_parameters,
        converged: c.converged,
        at_limit: c.at_limit.map(|p| p.name()),
        initial_amplitude: c.value(Parameter::InitialAmplitude),
        decay_rate_per_s: c.value(Parameter::DECAY_RATE),
        friction_displacement: c.value(Parameter::FRICTION_DISPLACEMENT),
        drag_rate: c.value(Parameter::DRAG_RATE),
    };
    a.comparison.iter().map(one).collect()
}

fn sliding(a: &Answer) -> Sliding {
    let s = &a.sliding;
    Sliding {
        detected: s.detected,
        p_value: s.p_value,
        delta_bic: s.delta_bic,
        share_at_highest: s.share_at_highest,
        share_at_lowest: s.share_at_lowest,
        dominates_from_s: s.dominates_from_s,
        viscous_only_p_value: s.viscous_only_p_value,
    }
}

fn segment(a: &Answer) -> Stretch {
    let s = &a.segment;
    Stretch {
        start_s: s.start_s,
        end_s: s.end_s,
        samples: s.samples,
        cycles: s.cycles,
        start_reason: s.start_reason.as_str(),
        end_reason: s.end_reason.as_str(),
    }
}

fn backbone(a: &Answer) -> Option<Backbone> {
    a.backbone.as_ref().map(|b| Backbone {
        frequency_at_zero_hz: b.frequency_at_zero_hz,
        frequency_at_start_hz: b.frequency_at_start_hz,
        quadratic: b.quadratic,
        quartic: b.quartic,
        drift_per_s: b.drift_per_s,
    })
}

fn stop(a: &Answer) -> Option<Stopped> {
    a.stop.as_ref().map(|s| Stopped {
        time_s: s.time_s,
        position: s.position,
        position_std_error: s.position_std_error,
        static_displacement: s.static_displacement,
    })
}

fn diagnostics(a: &Answer) -> Diagnostics {
    let d = &a.diagnostics;
    Diagnostics {
        method: d.method,
        noise_rms: d.noise_rms,
        residual_rms: d.residual_rms,
        residual_excess: d.residual_excess,
        residual_autocorrelation: d.residual_autocorrelation,
        signal_to_noise_db: d.signal_to_noise_db,
        decay_times: d.decay_times,
        left_out: d.left_out,
        other_modes: d
            .other_modes
            .iter()
            .map(|m| Mode { frequency_hz: m.frequency_hz, relative_amplitude: m.relative_amplitude })
            .collect(),
    }
}

fn loss(a: &Answer) -> Loss {
    let column = |of: fn(&slipfit::ringdown::LossPoint) -> f64| a.loss.iter().map(of).collect();
    Loss {
        amplitude: column(|p| p.amplitude),
        loss_per_cycle: column(|p| p.loss_per_cycle),
        std_error: column(|p| p.std_error),
        fitted: column(|p| p.fitted),
        fitted_sliding: column(|p| p.fitted_sliding),
    }
}

fn envelope(a: &Answer) -> Envelope {
    let column = |of: fn(&slipfit::ringdown::EnvelopePoint) -> f64| a.envelope.iter().map(of).collect();
    Envelope {
        time_s: column(|p| p.time_s),
        amplitude: column(|p| p.amplitude),
        std_error: column(|p| p.std_error),
        fitted: column(|p| p.fitted),
        frequency_hz: column(|p| p.frequency_hz),
        used: a.envelope.iter().map(|p| p.used).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::by_hand;

    #[test]
    fn what_is_no_number_is_null() {
        let spoil = |answer: &mut Answer| {
            let frequency = answer.parameters.get_mut(Parameter::Frequency).unwrap();
            frequency.value = f64::NAN;
            frequency.interval_95 = [f64::NEG_INFINITY, f64::INFINITY];
            answer.sliding.p_value = f64::NAN;
            answer.envelope[0].fitted = f64::NAN;
        };
        let mut text = Vec::new();
        by_hand(spoil, |analysed| ringdown(&mut text, analysed)).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let frequency = &json["parameters"]["frequency_hz"];
        assert!(frequency["value"].is_null(), "{frequency}");
        assert_eq!(frequency["interval_95"], serde_json::json!([null, null]));
        assert!(json["sliding"]["p_value"].is_null() && json["envelope"]["fitted"][0].is_null());
    }
}
