//! The drive of `slipfit simulate driven`: one harmonic, several, or a waveform from a file.

use super::oscillator::{base_amplitude, in_flags};
use super::sheet::{Parameters, number};
use crate::args::{DrivenArgs, Tone, WaveArgs};
use crate::failure::Failure;
use slipfit::Oscillator;
use slipfit::motion::simulate::{Drive, Harmonic};
use slipfit::motion::steady::HarmonicDrive;
use slipfit_io::{ReadOptions, Reading};
use std::f64::consts::TAU;

/// The drive and its description in the header.
pub(super) struct Wave {
    pub(super) drive: Drive,
    pub(super) kind: Kind,
    /// Skipped rows of a file, with the reason.
    pub(super) warnings: Vec<String>,
}

pub(super) enum Kind {
    /// One harmonic at phase zero, which `--beta` and `--from steady` need.
    Harmonic {
        drive: HarmonicDrive,
    },
    Tones(Vec<Tone>),
    File {
        name: String,
        samples: usize,
        sha256: String,
    },
}

/// Amplitude `x_0` of the harmonic of the base (of a force: over the stiffness); `None` if there is none.
pub(super) fn amplitude(
    args: &WaveArgs,
    oscillator: &Oscillator,
    unit: &str,
) -> Result<Option<f64>, Failure> {
    match (args.drive_amplitude, args.drive_force) {
        (None, None) => Ok(None),
        (drive_amplitude, drive_force) => {
            let one = crate::args::DriveArgs { drive_amplitude, drive_force };
            base_amplitude(&one, oscillator, unit).map(Some)
        }
    }
}

/// The amplitude to which `--beta` refers.
pub(super) fn reference(args: &WaveArgs, oscillator: &Oscillator, unit: &str) -> Result<f64, Failure> {
    amplitude(args, oscillator, unit)?.ok_or_else(|| {
        Failure::new("--beta is a ratio to --drive-amplitude or --drive-force, and neither is given")
            .hint("--friction-displacement or --coulomb-force gives friction by itself")
    })
}

pub(super) fn wave(args: &DrivenArgs, o: &Oscillator) -> Result<Wave, Failure> {
    if let Some(path) = &args.drive.drive_file {
        let reading = slipfit_io::read(path, &ReadOptions::default())?;
        return from_file(reading);
    }
    let mut tones = args.drive.tone.clone();
    if let Some(amplitude) = amplitude(&args.drive, o, &args.sample.unit)? {
        let frequency_hz = args.drive_frequency_hz.unwrap_or(o.frequency_hz());
        tones.insert(0, Tone { frequency_hz, amplitude, phase_deg: 0.0 });
    } else if args.drive_frequency_hz.is_some() {
        return Err(Failure::new("--drive-frequency-hz belongs to --drive-amplitude or --drive-force")
            .hint("--tone HZ,X names its own frequency"));
    }
    let harmonics: Vec<Harmonic> = tones
        .iter()
        .map(|t| Harmonic {
            amplitude: t.amplitude,
            omega: TAU * t.frequency_hz,
            phase: t.phase_deg.rem_euclid(360.0).to_radians(),
        })
        .collect();
    let drive = Drive::harmonics(0.0, &harmonics).map_err(in_flags)?;
    let kind = match tones[..] {
        [t] if t.phase_deg == 0.0 && t.amplitude > 0.0 => {
            let drive = HarmonicDrive::new(t.amplitude, TAU * t.frequency_hz).map_err(in_flags)?;
            Kind::Harmonic { drive }
        }
        _ => Kind::Tones(tones),
    };
    Ok(Wave { drive, kind, warnings: Vec::new() })
}

fn from_file(reading: Reading) -> Result<Wave, Failure> {
    let Reading { record, report, .. } = reading;
    let samples = record.len();
    let mut times = record.times_s(0..samples);
    let mut values = record.signal().to_vec();
    // Of repeated time stamps the later sample is used: a drive has one value at a time.
    let mut warnings: Vec<String> =
        report.skipped.iter().map(|skipped| format!("{}: skipped {skipped}", report.path)).collect();
    let keep: Vec<bool> = (0..samples).map(|i| i + 1 == samples || times[i] < times[i + 1]).collect();
    let doubled = keep.iter().filter(|k| !**k).count();
    if doubled > 0 {
        warnings.push(format!(
            "{}: {doubled} times are repeated; the later sample of each was taken",
            report.path
        ));
        let mut of = keep.iter();
        times.retain(|_| *of.next().unwrap_or(&true));
        let mut of = keep.iter();
        values.retain(|_| *of.next().unwrap_or(&true));
    }
    let kind = Kind::File { name: report.path, samples: times.len(), sha256: report.sha256 };
    let drive = Drive::sampled(times, values).map_err(in_flags)?;
    Ok(Wave { drive, kind, warnings })
}

impl Wave {
    /// Adds the description of the drive to the parameters.
    pub(super) fn describe(&self, args: &DrivenArgs, o: &Oscillator, all: &mut Parameters) {
        let unit = &args.sample.unit;
        match &self.kind {
            Kind::Harmonic { drive } => {
                all.number("drive_amplitude", drive.amplitude(), unit);
                if let Some(p) = args.drive.drive_force {
                    all.force("drive_force", p, o);
                }
                all.number("drive_frequency_hz", drive.omega() / TAU, "");
                all.number("friction_ratio", o.friction_ratio(drive.amplitude()), "");
            }
            Kind::Tones(tones) => {
                let one = |t: &Tone| {
                    format!(
                        "{} cos(2 pi {} t + {} deg)",
                        number(t.amplitude),
                        number(t.frequency_hz),
                        number(t.phase_deg)
                    )
                };
                let sum: Vec<String> = tones.iter().map(one).collect();
                all.text("drive", format!("{} {unit}", sum.join(" + ")));
            }
            Kind::File { name, samples, sha256 } => {
                all.text("drive", format!("{name}, {samples} samples, sha256 {sha256}"));
            }
        }
    }
}
