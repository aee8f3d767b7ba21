//! The report of a ring-down.

use super::content::{Document, Input, file_name, warnings};
use super::facts::Facts;
use super::method;
use super::models::Comparison;
use super::parameter::ParameterRow;
use super::reading::{clock, columns_taken, rows_read};
use crate::format::{Rounded, decay_times, instant, plain, times};
use crate::{AnalysedRingdown, Sentence, plot};
use slipfit::answer::hint::Spelling;
use slipfit::ringdown::{FreeLaw, SensorCurve};
use slipfit::{Quantity, SignalKind};

pub(super) fn document<'a>(analysed: &'a AnalysedRingdown<'a>, spell: Spelling<'_>) -> Document<'a> {
    let answer = analysed.answer;
    let models = Comparison {
        candidates: &answer.comparison,
        reported: answer.model,
        parameters: &answer.parameters,
        unit: &answer.signal_unit,
        heading: "model",
    };
    let file = analysed.file.display().to_string();
    Document {
        command: "ringdown",
        title: None,
        subject: file_name(&file),
        sentence: answer.sentence(),
        parameters: ParameterRow::list(&answer.parameters, Some(answer.model)),
        tables: vec![models.table(&[])],
        facts: facts(analysed, spell),
        warnings: warnings(&answer.warnings, spell),
        method: method::of_ringdown(answer, holds_amplitudes(analysed.reading.record.kind())),
        inputs: vec![Input { path: file, sha256: analysed.reading.report.sha256.clone() }],
        pictures: Box::new(|| plot::ringdown_panels(analysed)),
    }
}

/// The model-free loss law: its limit, its slope, and the range over which it was measured.
fn free_law(facts: &mut Facts, law: &FreeLaw, unit: &str) {
    let interval = |q: &Quantity| {
        let [low, high] = q.interval_95.map(|v| plain(v, 3, &q.unit));
        format!("{} (95 %: {low} to {high})", plain(q.value, 3, &q.unit))
    };
    let x_f = law.friction_displacement.as_ref().map_or_else(String::new, |x_f| {
        let [low, high] = x_f.interval_95.map(|v| plain(v, 3, &x_f.unit));
        format!(", which corresponds to x_F between {low} and {high}")
    });
    facts.add("law", format!("without a model, at vanishing amplitude: loss {}{x_f}", interval(&law.limit)));
    facts.add("", format!("slope there {}", interval(&law.slope)));
    let shape = if law.effective_parameters < 2.5 {
        "straight within the confidence band".to_owned()
    } else {
        format!("curved, {} effective parameters", plain(law.effective_parameters, 2, ""))
    };
    let rising = if law.rising { "; constrained to rise with the amplitude" } else { "" };
    facts.add("", format!("{shape}; smallest amplitude {}{rising}", plain(law.lowest_amplitude, 3, unit)));
}

/// Response curve of the sensor in the unit of the signal: `reads x + 0.05 x² - 0.1 x³/(1 + 0.4 x²)`.
fn sensor_curve(curve: &SensorCurve, unit: &str) -> String {
    let term = |coefficient: f64, power: &str| match coefficient {
        0.0 => String::new(),
        c => format!(" {} {} {power}", if c < 0.0 { '-' } else { '+' }, plain(c.abs(), 3, "")),
    };
    let unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
    let [quadratic, cubic] = [term(curve.quadratic, "x²"), term(curve.cubic, "x³")];
    let saturation = match term(curve.saturation, "x²") {
        none if none.is_empty() => none,
        some => format!("/(1{some})"),
    };
    format!("reads x{quadratic}{cubic}{saturation} for a displacement x{unit} from the middle: linearised")
}

/// Whether the record holds amplitudes instead of the motion itself.
fn holds_amplitudes(kind: SignalKind) -> bool {
    matches!(kind, SignalKind::Envelope | SignalKind::LockIn)
}

/// What was read, what was used, and how well the model describes it.
fn facts(analysed: &AnalysedRingdown<'_>, spell: Spelling<'_>) -> Facts {
    let report = &analysed.reading.report;
    let answer = analysed.answer;
    let mut facts = Facts::default();
    facts.add("read", format!("{}: {}", analysed.file.display(), rows_read(report, spell)));
    columns_taken(&mut facts, report);
    if let Some(clock) = clock(analysed.reading.record.clock_report()) {
        facts.add("clock", clock);
    }
    facts.notes(&report.notes, spell);
    if let Some(f) =
        analysed.reading.named_frequency_hz().filter(|f| analysed.options.frequency_hz == Some(*f))
    {
        let named = format!(
            "frequency {}, as stated in the first lines of the file ({} overrides it)",
            plain(f, 6, "Hz"),
            spell("frequency_hz", None)
        );
        facts.add("note", named);
    }
    let s = &answer.segment;
    let span_s = s.end_s - s.start_s;
    let cycles = if s.cycles > 0.0 { format!("{} cycles, ", plain(s.cycles, 3, "")) } else { String::new() };
    facts.add(
        "used",
        format!(
            "{} ({}) to {} ({}): {cycles}{} samples",
            instant(s.start_s, span_s),
            s.start_reason,
            instant(s.end_s, span_s),
            s.end_reason,
            s.samples
        ),
    );
    if let Some(stop) = &answer.stop {
        let position = Rounded::new(stop.position, stop.position_std_error, &answer.signal_unit);
        let hold = stop.static_displacement.map_or_else(String::new, |[low, high]| {
            let unit = &answer.signal_unit;
            format!("; static friction holds between {} and {}", plain(low, 3, unit), plain(high, 3, unit))
        });
        facts.add("stop", format!("at {}, {position} from the middle{hold}", instant(stop.time_s, span_s)));
    }
    if let Some(mode) = &answer.second_mode {
        let [frequency, decay_rate, amplitude] = [&mode.frequency, &mode.decay_rate, &mode.amplitude]
            .map(|q| Rounded::new(q.value, q.std_error, &q.unit));
        facts.add(
            "mode 2",
            format!("{frequency}, decay rate {decay_rate}, amplitude {amplitude}: subtracted"),
        );
    }
    if let Some(curve) = &answer.sensor_curve {
        facts.add("sensor", sensor_curve(curve, &answer.signal_unit));
    }
    if let Some(law) = &answer.free_law {
        free_law(&mut facts, law, &answer.signal_unit);
    }
    let d = &answer.diagnostics;
    let left_out = match d.left_out {
        0 => String::new(),
        1 => "; 1 short part that fits no law was left out".to_owned(),
        n => format!("; {n} short parts that fit no law were left out"),
    };
    let at_turns = match d.samples_at_turns {
        0 => String::new(),
        1 => "; 1 sample next to a turning point left out".to_owned(),
        n => format!("; {n} samples next to turning points left out"),
    };
    let coloured = match d.noise_inflation {
        1.0 => String::new(),
        f => format!(" and {:.1} times that near the frequency of the motion", f.sqrt()),
    };
    facts.add(
        "fit",
        format!(
            "of the {}; noise {}, {:.0} dB below the start{coloured}; residuals {} times the noise; \
             {}{left_out}{at_turns}",
            d.method,
            plain(d.noise_rms, 2, &answer.signal_unit),
            d.signal_to_noise_db,
            times(d.residual_excess.max(0.0).sqrt()),
            decay_times(d.decay_times)
        ),
    );
    facts.counted_losses(d.counted_losses, "record");
    facts
}
