//! Hints for each warning.

use super::Warning;
use crate::answer::figures::figures;
use crate::answer::hint::Hint;

/// An instant rounded to six digits, enough to identify a sample of most records.
fn instant(time_s: f64) -> f64 {
    figures(time_s, 6).parse().unwrap_or(time_s)
}

/// Band about `main` that excludes `other`.
fn band_about(main: f64, other: f64, decimals: i32) -> [f64; 2] {
    let reach = 0.4 * (main - other).abs();
    let digits = 10f64.powi(decimals);
    [(main - reach).max(0.1 * main), main + reach].map(|v| (v * digits).round() / digits)
}

impl Warning {
    /// Hints: options, with values if they are known, or another measurement.
    pub fn hints(&self) -> Vec<Hint> {
        let either = |a: &'static str, b: &'static str, advice: &'static str| {
            vec![Hint::new(a, advice), Hint::new(b, advice)]
        };
        match self {
            Warning::NotSeparable { decay_times: Some(_), .. } => {
                vec![Hint::advice("record down to a smaller amplitude")]
            }
            Warning::NotSeparable { decay_times: None, .. } => {
                let mut hints = either("drive_amplitude", "reference", "separates them");
                hints.push(Hint::advice("so does a sweep at another drive level"));
                hints
            }
            Warning::SeveralModes { main_hz, other_hz, .. }
            | Warning::SecondMode { main_hz, other_hz, .. } => {
                vec![Hint::new("band_hz", "isolates the first").with(band_about(*main_hz, *other_hz, 4))]
            }
            Warning::SecondPeak { main_hz, other_hz, .. } => {
                vec![Hint::new("band_hz", "isolates the first").with(band_about(*main_hz, *other_hz, 6))]
            }
            Warning::ModelMisfit { misfit: Some(_), .. } => {
                vec![Hint::new("law", "shows the loss without a model").with("free")]
            }
            Warning::FurtherLaw { model, .. } => {
                vec![Hint::new("model", "reports it").with(model.name())]
            }
            Warning::LawChanges { time_s } | Warning::PhaseStep { time_s, .. } => vec![
                Hint::new("end_s", "analyses the part before").with(instant(*time_s)),
                Hint::new("start_s", "analyses the part after").with(instant(*time_s)),
            ],
            Warning::SquaredReading { along_pendulum: true } => {
                vec![Hint::new(
                    "signal",
                    "names a gyroscope or an axis across the pendulum, where the file has one",
                )]
            }
            Warning::TurningGravity => vec![Hint::advice("record a gyroscope or the linear acceleration")],
            Warning::OtherMotion { from_s, to_s } => vec![
                Hint::new("start_s", "analyses it from its beginning").with(instant(*from_s)),
                Hint::new("end_s", "analyses it up to its end").with(instant(*to_s)),
            ],
            Warning::SlowTail { .. } => vec![Hint::new("end_s", "sets the limit by hand")],
            Warning::Clipped { inside: true, .. } => vec![Hint::new("start_s", "skips them")],
            Warning::ClockRebuilt { .. } => vec![Hint::new("rate_hz", "gives the samples per second")],
            Warning::LossyCompression { .. } => vec![Hint::advice("record as WAV or FLAC")],
            Warning::AmbiguousModel { .. } => vec![Hint::new("model", "chooses the one to report")],
            Warning::LowQDerivative { .. } => either("start_s", "end_s", "limits it to the free decay"),
            Warning::Disturbance { .. } => either("start_s", "end_s", "chooses the part by hand"),
            Warning::FrequencyUnknown => {
                vec![Hint::new("frequency_hz", "turns it into a friction displacement")]
            }
            Warning::Undetermined { .. } => vec![Hint::advice("points across the peak would")],
            Warning::ShapeAlone { .. } => either("drive_amplitude", "reference", "narrows it"),
            Warning::RivalInstrument { other_minimum: true, .. } => {
                vec![Hint::advice("points farther from the peak decide")]
            }
            Warning::RivalInstrument { drag: true, background: true, .. } => {
                vec![Hint::new("delay", "leaves it out").with("off")]
            }
            Warning::RivalInstrument { offset: Some(true), .. } => {
                vec![Hint::new("amplitude_offset", "fits that model").with("on")]
            }
            Warning::RivalInstrument { offset: Some(false), background: false, .. } => {
                vec![Hint::new("amplitude_offset", "leaves it out").with("off")]
            }
            Warning::RivalInstrument { floor: Some(true), .. } => {
                vec![Hint::new("noise_floor", "fits that model").with("on")]
            }
            Warning::RivalInstrument { floor: Some(false), background: false, .. } => {
                vec![Hint::new("noise_floor", "leaves it out").with("off")]
            }
            Warning::RivalInstrument { background, delay, duffing, .. } => {
                let (option, on) = duffing.map_or(("background", *background), |on| ("duffing", on));
                let fits = if *delay && duffing.is_none() { "fits them" } else { "fits that model" };
                let (word, effect) = if on { ("on", fits) } else { ("off", "leaves it out") };
                vec![Hint::new(option, effect).with(word)]
            }
            Warning::Jump { .. } => vec![Hint::new("band_hz", "selects one branch")],
            Warning::OneFlank { .. } => vec![Hint::advice("measure across the peak")],
            Warning::NegativeDelay { .. } => vec![
                Hint::new("kind", "gives the quantity that was measured"),
                Hint::advice("check that the phases are those of the response relative to the drive"),
            ],
            Warning::DriveDiffers { .. } => {
                vec![Hint::new(
                    "drive_amplitude",
                    "can be left out: the curve then gives it; check that the value is neither rms nor \
                     peak to peak",
                )]
            }
            Warning::ReferenceGain { .. } => {
                vec![Hint::new("drive_amplitude", "gives that of this curve")]
            }
            Warning::ScatteredErrors { .. } => {
                vec![Hint::advice("errors pooled over neighbouring points are more reliable")]
            }
            Warning::DriveReadback { .. } => {
                vec![Hint::new("drive", "takes it as constant").with("none")]
            }
            Warning::FewLevels { .. } => {
                vec![Hint::advice("standard errors of the levels, or more levels, make it more reliable")]
            }
            Warning::AboveZero { .. } => {
                vec![Hint::advice("levels down to zero drive show what is read at rest")]
            }
            Warning::ThresholdExtrapolated { .. } => vec![Hint::advice("lower levels would show it")],
            Warning::DriveUncalibrated => {
                either("drive_gain", "q_factor", "gives Q and the friction displacement")
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::hint::HintValue;

    #[test]
    fn a_band_that_is_advised_leaves_the_other_mode_outside() {
        let band = |main_hz, other_hz| {
            let modes = Warning::SeveralModes { main_hz, other_hz, relative_amplitude: 0.18 };
            modes.hints().remove(0).value
        };
        assert_eq!(band(80.52, 297.667), Some(HintValue::Range([8.052, 167.3788])));
        assert_eq!(band(0.59547, 0.86035), Some(HintValue::Range([0.4895, 0.7014])));
    }
}
