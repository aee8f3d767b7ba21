//! Options that override what a file suggests.

use std::path::Path;

use slipfit::SignalKind;

use crate::{
    Format,
    error::{OptionProblem, ReadProblem},
};

/// How to read a file, for everything that it does not state itself. With the default everything is taken from the
/// file; each reader uses the fields that concern it.
///
/// A column is given by its number, from 1, or by its name: the whole header or the header without its unit, in upper
/// or lower case, or a part of it that occurs in no other header.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// The format, if the first bytes do not identify it or suggest another one; for a gzip file, the format of its
    /// content.
    pub format: Option<Format>,
    /// One of several sheets, variables, groups, data sets or tracks: its name, a part of the name that occurs in no
    /// other, or its number from 1.
    pub sheet: Option<String>,
    /// One of several tables side by side, from 1.
    pub part: Option<usize>,
    /// One of several runs, from 1. Runs are in groups of columns or, if there is one group, follow each other with a
    /// clock that restarts; of the latter the longest is read by default. Also one of several curves in groups of
    /// columns.
    pub run: Option<usize>,
    /// Time column.
    pub time: Option<String>,
    /// Unit of the times: `s`, `ms`, `us`, `ns`, `min`, `h`, or the rate of the clock whose ticks they count, such as
    /// `60MHz`.
    pub time_unit: Option<String>,
    /// Samples per second (Hz), instead of a time column.
    pub rate_hz: Option<f64>,
    /// Column of the signal of a record; for a lock-in, its in-phase output.
    pub signal: Option<String>,
    /// Column of the quadrature output of a lock-in.
    pub quadrature: Option<String>,
    /// Unit of the signal or of the amplitudes. `dB` and `dBm` are converted to linear values.
    pub unit: Option<String>,
    /// Kind of the signal or of the response. The response of a curve is divided by `i omega` once if it is a velocity,
    /// twice if it is an acceleration.
    pub kind: Option<SignalKind>,
    /// Maximum number of samples held, [`ReadOptions::MOST_SAMPLES`] by default: longer records with an even clock are
    /// averaged while they are read ([`slipfit::record::Averaging`]).
    pub most_samples: Option<usize>,
    /// Column of the frequencies of a curve, of their periods, or of frequency shifts.
    pub frequency: Option<String>,
    /// Unit of the frequencies: `Hz`, `kHz`, `MHz`, `rad/s`, `rpm`; `s` or `ms` for periods; `log10 Hz`, `log10 kHz`,
    /// `ln rad/s` for logarithms; or the reference frequency of a column of ratios, such as `80.1 Hz`.
    pub frequency_unit: Option<String>,
    /// Reference frequency (Hz) of the shifts.
    pub centre_hz: Option<f64>,
    /// Column of the amplitudes of a curve, or of the response in driven records.
    pub amplitude: Option<String>,
    /// Column of the phases.
    pub phase: Option<String>,
    /// Unit of the phases: `deg`, `rad`, `cycles`, or `pi` for multiples of pi.
    pub phase_unit: Option<String>,
    /// Column of the real part of the response, of a curve or at drive levels.
    pub real: Option<String>,
    /// Column of its imaginary part.
    pub imaginary: Option<String>,
    /// Column of the standard errors of the amplitudes.
    pub std_error: Option<String>,
    /// Column of the drive: its level at each point, or its signal in driven records; `none` if a curve has no drive.
    pub drive: Option<String>,
    /// Unit of the drive levels.
    pub drive_unit: Option<String>,
}

impl ReadOptions {
    /// Half a gigabyte of times and values.
    pub const MOST_SAMPLES: usize = 1 << 25;

    /// The options for `paths` if `others` are read with the same options, as a curve and its reference are. One file
    /// contains a curve; several files or a folder are driven records. If only one of the two is a curve, each is read
    /// with the options that concern it; otherwise the options do not change.
    ///
    /// ```
    /// use slipfit_io::ReadOptions;
    /// let options = ReadOptions { rate_hz: Some(1e3), phase: Some("3".into()), ..Default::default() };
    /// let (curve, records) = (["free.csv"], ["1.csv", "2.csv"]);
    /// let of_curve = options.beside(&curve, &records);
    /// assert_eq!((of_curve.rate_hz, of_curve.phase.as_deref()), (None, Some("3")));
    /// let of_records = options.beside(&records, &curve);
    /// assert_eq!((of_records.rate_hz, of_records.phase), (Some(1e3), None));
    /// assert_eq!(options.beside(&curve, &curve), options);
    /// ```
    #[must_use]
    pub fn beside(&self, paths: &[impl AsRef<Path>], others: &[impl AsRef<Path>]) -> Self {
        match [are_driven_records(paths), are_driven_records(others)] {
            [true, false] => Self {
                frequency: None,
                frequency_unit: None,
                centre_hz: None,
                phase: None,
                phase_unit: None,
                real: None,
                imaginary: None,
                std_error: None,
                kind: None,
                ..self.clone()
            },
            [false, true] => Self { time: None, time_unit: None, rate_hz: None, ..self.clone() },
            _ => self.clone(),
        }
    }

    /// Checks that no option is given that has no effect on a curve.
    pub(crate) fn check_for_curve(&self) -> Result<(), ReadProblem> {
        let rate_hz = self.rate_hz.map(|rate_hz| rate_hz.to_string());
        let without_effect = [("time", &self.time), ("time_unit", &self.time_unit), ("rate_hz", &rate_hz)];
        refuse_given(&without_effect, OptionProblem::NotOfCurve)
    }

    /// Checks that no option is given that has no effect on driven records.
    pub(crate) fn check_for_driven_records(&self) -> Result<(), ReadProblem> {
        let centre_hz = self.centre_hz.map(|centre_hz| centre_hz.to_string());
        let kind = self.kind.map(|kind| kind.name().to_owned());
        let without_effect = [
            ("frequency", &self.frequency),
            ("frequency_unit", &self.frequency_unit),
            ("centre_hz", &centre_hz),
            ("phase", &self.phase),
            ("phase_unit", &self.phase_unit),
            ("real", &self.real),
            ("imaginary", &self.imaginary),
            ("std_error", &self.std_error),
            ("kind", &kind),
        ];
        refuse_given(&without_effect, OptionProblem::NotOfDrivenRecords)
    }
}

/// Whether these paths of a resonance are driven records, one per frequency, and not a file that contains a curve.
pub(crate) fn are_driven_records(paths: &[impl AsRef<Path>]) -> bool {
    !matches!(paths, [one] if !one.as_ref().is_dir())
}

fn refuse_given(
    options: &[(&'static str, &Option<String>)],
    problem: OptionProblem,
) -> Result<(), ReadProblem> {
    let given = options.iter().find_map(|(option, value)| Some((*option, (*value).clone()?)));
    given.map_or(Ok(()), |(option, value)| Err(ReadProblem::Option { option, value, problem }))
}
