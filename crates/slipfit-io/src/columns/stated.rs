//! The sampling step or rate that an instrument states above its samples.

use super::{
    name::Name,
    units::{self, Measures},
};
use crate::report::Decimal;

/// Names of the time between samples, reduced to letters and digits.
const STEPS: &str = "sampleinterval samplinginterval sampleperiod samplingperiod samplecycle samplingcycle samplingstep \
                     recordinginterval storageinterval timeinterval timestep timeincrement horizontalinterval \
                     abtastintervall abtastperiode abtastzeit xincrement xincr xinc increment deltax deltat tinc dt \
                     hresolution";
/// Names of the sampling rate.
const RATES: &str = "samplerate samplingrate samplefrequency samplingfrequency samplefreq samplingfreq samplespersecond \
                     abtastrate abtastfrequenz scanrate srate updaterate fps framerate framespersecond";
/// Relative tolerance between statements, such as a rate rounded to four digits and a step.
const AGREE_WITHIN: f64 = 1e-3;

/// Samples per second (Hz), if lines state the rate or the step and agree.
pub(crate) fn rate_hz<'a>(
    lines: impl Iterator<Item = &'a str>,
    separators: &[char],
    decimal: Decimal,
) -> Option<f64> {
    let mut rates = lines.flat_map(|line| statements(line, separators, decimal));
    let first = rates.next()?;
    rates.all(|rate| (rate / first - 1.0).abs() <= AGREE_WITHIN).then_some(first)
}

/// Sampling rates stated in a line: `Sample Interval,4e-06`, `SamplingCycle(us)=20`, `tInc = 0.0001s`.
fn statements(line: &str, separators: &[char], decimal: Decimal) -> Vec<f64> {
    let cells: Vec<&str> = line.split(separators).map(|c| c.trim().trim_matches('"').trim()).collect();
    let value = |i: usize| cells.get(i).copied().unwrap_or_default();
    let of_cell = |i: usize| {
        let cell = value(i).trim_start_matches(['#', '%', '!', '*', '/', ' ']);
        match cell.split_once(['=', ':']) {
            Some((name, stated)) if !stated.trim().is_empty() => rate(name, stated, value(i + 1), decimal),
            Some((name, _)) => rate(name, value(i + 1), value(i + 2), decimal),
            None => rate(cell, value(i + 1), value(i + 2), decimal),
        }
    };
    (0..cells.len()).filter_map(of_cell).collect()
}

fn rate(name: &str, stated: &str, behind: &str, decimal: Decimal) -> Option<f64> {
    let parsed = Name::parse(name);
    let plain = |text: &str| -> String {
        text.to_lowercase().chars().filter(|c| c.is_ascii_alphanumeric()).collect()
    };
    let bare = plain(&parsed.bare);
    let is_of = |list: &str| {
        list.split_ascii_whitespace().any(|known| bare == known || known.len() > 8 && bare.ends_with(known))
    };
    let (is_step, is_rate) = (is_of(STEPS), is_of(RATES));
    if !is_step && !is_rate {
        return None;
    }
    // Siglent writes the kind of channel first: `Analog:1.0e-04`.
    let stated = stated.rsplit(':').next().unwrap_or_default().trim();
    let stated = if decimal == Decimal::Comma { stated.replace(',', ".") } else { stated.to_owned() };
    let (number, used) = fast_float2::parse_partial::<f64, _>(&stated).ok()?;
    // A sentence may continue: `Sample Rate: 44100 Hz. Sample values on linear scale.`
    let suffix = stated[used..].split(". ").next().unwrap_or_default().trim().trim_end_matches('.');
    let of_unit = |unit: &str| {
        if is_rate {
            return sample_unit(unit).or_else(|| units::hertz(unit)).map(|factor| number * factor);
        }
        match units::measures(unit) {
            Some(Measures::Time(seconds)) => Some(over(seconds.of(number))),
            _ => None,
        }
    };
    let rate_hz = match (suffix, parsed.unit.as_str()) {
        ("", "") => of_unit(behind).unwrap_or(if is_rate { number } else { over(number) }),
        ("", unit) | (unit, _) => of_unit(unit)?,
    };
    (rate_hz > 0.0 && rate_hz.is_finite() && number > 0.0).then_some(rate_hz)
}

/// Reciprocal of a decimal step without rounding error: 100 kHz for 1e-5 s.
fn over(step_s: f64) -> f64 {
    let rate_hz = 1.0 / step_s;
    format!("{rate_hz:.13e}").parse().unwrap_or(rate_hz)
}

/// Factor to Hz of a number of samples per unit of time: `kS/s`, `MSa/s`, `SPS`.
fn sample_unit(unit: &str) -> Option<f64> {
    let lower = unit.to_lowercase();
    let end = ["samples/s", "sa/s", "s/s", "sps"].into_iter().find(|end| lower.ends_with(end))?;
    match lower[..lower.len() - end.len()].trim() {
        "" => Some(1.0),
        "k" => Some(1e3),
        "m" => Some(1e6),
        "g" => Some(1e9),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated(line: &str) -> Option<f64> {
        rate_hz(line.lines(), &[',', ';', '\t'], Decimal::Point)
    }

    #[test]
    fn steps_and_rates_are_read_as_instruments_state_them() {
        for (line, rate) in [
            ("Sample Interval,4e-06", 250e3),
            ("Sample Interval,Analog:1.000000e-04", 1e4),
            ("Sampling interval,1.0E-05,s", 1e5),
            ("\"Sampling interval\",\"20us\"", 50e3),
            ("SamplingCycle(us)=20000", 50.0),
            ("Sampling period [ms]: 5", 200.0),
            ("Time(s),CH1(V),t0 = -0.1s, tInc = 0.0001s,", 1e4),
            ("XInc:,0.0001", 1e4),
            ("Delta_X\t0.001\t0.001", 1e3),
            ("HResolution,2.0E-04", 5e3),
            ("# Sample rate: 10 kHz", 1e4),
            ("// Update Rate: 100.0Hz", 100.0),
            ("# fps: 240", 240.0),
            ("Sampling Rate;50 kS/s", 50e3),
            ("Sample Rate,1.25MSa/s", 1.25e6),
            ("Sampling frequency (Hz),100", 100.0),
            ("Sample Rate: 50 Hz. Sample values on linear scale.", 50.0),
            ("#Sample rate: 10000Hz\n#Sample interval: 100 us", 1e4),
        ] {
            let found = stated(line).unwrap_or_else(|| panic!("{line}"));
            assert!((found / rate - 1.0).abs() < 1e-12, "{line}: {found}");
        }
        assert_eq!(stated("Sampling interval,1.0E-05"), Some(1e5));
        for line in [
            "Sampling interval,auto",
            "Samples: 12000",
            "Sample rate: 1e6 Hz\nSample interval: 1e-4 s",
            "t, dt, x",
            "Sample interval,0",
            "angle, sample_rate, duration\n45, 1000, 5",
            "Sample rate,10 per cm",
        ] {
            assert_eq!(stated(line), None, "{line}");
        }
    }
}
