//! How a file is read, if it does not say so itself.

use super::count;
use super::value::{FormatName, Positive, Text, number, text};
use clap::{Args, ValueEnum};
use serde::Deserialize;
use slipfit::SignalKind;
use slipfit_io::ReadOptions;

// A doc comment here would replace that of the command.
#[derive(Debug, Clone, Default, Args, Deserialize)]
#[serde(default)]
pub(crate) struct ReadingArgs {
    /// Format, if the first bytes do not identify it: text, wav, mat, hdf5, parquet, arrow, ...
    #[arg(long, value_name = "NAME", help_heading = "Reading")]
    pub(crate) format: Option<FormatName>,

    /// Column of the times, by number (from 1) or name
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    pub(crate) time: Option<Text>,

    /// Column of the signal (for a lock-in: its X output)
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    pub(crate) signal: Option<Text>,

    /// Column of a lock-in's Y output
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    pub(crate) quadrature: Option<Text>,

    /// Unit of the times: s, ms, us, ns, min, h, or the rate of the clock that counts ticks, such as 60MHz
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    pub(crate) time_unit: Option<Text>,

    /// Unit of the signal, such as rad, deg, mm, V, dBm
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    pub(crate) unit: Option<Text>,

    /// What the signal is
    #[arg(long, value_enum, value_name = "KIND", help_heading = "Reading", hide_possible_values = false)]
    pub(crate) kind: Option<Kind>,

    /// Samples per second, if the file has no times
    #[arg(long, value_name = "RATE", help_heading = "Reading")]
    pub(crate) rate_hz: Option<Positive>,

    /// Which sheet, variable, group or track of the file, by name or number
    #[arg(long, value_name = "NAME", visible_aliases = ["variable", "group", "track"], help_heading = "Reading")]
    #[serde(alias = "variable", alias = "group", alias = "track")]
    pub(crate) sheet: Option<Text>,

    /// Which of several tables side by side, from 1
    #[arg(long, value_name = "N", value_parser = count, help_heading = "Reading")]
    pub(crate) part: Option<usize>,

    /// Which of several runs, in groups of columns or one after the other, from 1
    #[arg(long, value_name = "N", value_parser = count, help_heading = "Reading")]
    pub(crate) run: Option<usize>,

    /// Maximum number of samples held; longer records are averaged while they are read (default
    /// 33554432, half a gigabyte)
    #[arg(long, value_name = "N", value_parser = count, help_heading = "Reading")]
    pub(crate) most_samples: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// Position or angle
    Displacement,
    /// Its first derivative
    Velocity,
    /// Its second derivative
    Acceleration,
    /// Amplitude of the oscillation
    Envelope,
    /// X and Y outputs of a lock-in
    LockIn,
}

impl From<Kind> for SignalKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Displacement => Self::Displacement,
            Kind::Velocity => Self::Velocity,
            Kind::Acceleration => Self::Acceleration,
            Kind::Envelope => Self::Envelope,
            Kind::LockIn => Self::LockIn,
        }
    }
}

/// A word quoted for a shell.
pub(crate) fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "./_-:".contains(c) || (cfg!(windows) && c == '\\');
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else if cfg!(windows) || !text.contains(['$', '`', '"', '\\', '!']) {
        format!("\"{text}\"")
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

impl ReadingArgs {
    /// The same for a resonance curve; `None` if a flag applies to records only.
    pub(crate) fn curve_options(&self) -> Option<ReadOptions> {
        let record_only = self.time.is_some()
            || self.signal.is_some()
            || self.quadrature.is_some()
            || self.time_unit.is_some()
            || self.kind.is_some()
            || self.rate_hz.is_some()
            || self.part.is_some()
            || self.most_samples.is_some();
        (!record_only).then(|| ReadOptions {
            format: self.format.as_ref().map(|f| f.format),
            unit: text(&self.unit),
            sheet: text(&self.sheet),
            run: self.run,
            ..ReadOptions::default()
        })
    }

    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.format.as_ref().map(|f| f.format),
            time: text(&self.time),
            signal: text(&self.signal),
            quadrature: text(&self.quadrature),
            time_unit: text(&self.time_unit),
            unit: text(&self.unit),
            kind: self.kind.map(Into::into),
            rate_hz: number(self.rate_hz),
            sheet: text(&self.sheet),
            part: self.part,
            run: self.run,
            most_samples: self.most_samples,
            ..ReadOptions::default()
        }
    }

    /// The flags as they were typed, for a follow-up command.
    pub(crate) fn as_flags(&self) -> String {
        let quoted = |text: &Text| quoted(&text.0);
        let count = |n: Option<usize>| n.map(|n| n.to_string());
        [
            ("--format", self.format.as_ref().map(|f| f.typed.clone())),
            ("--time", self.time.as_ref().map(quoted)),
            ("--signal", self.signal.as_ref().map(quoted)),
            ("--quadrature", self.quadrature.as_ref().map(quoted)),
            ("--time-unit", self.time_unit.as_ref().map(quoted)),
            ("--unit", self.unit.as_ref().map(quoted)),
            ("--kind", self.kind.and_then(|k| k.to_possible_value()).map(|k| k.get_name().to_owned())),
            ("--rate-hz", self.rate_hz.map(|r| r.0.to_string())),
            ("--sheet", self.sheet.as_ref().map(quoted)),
            ("--most-samples", count(self.most_samples)),
            ("--part", count(self.part)),
            ("--run", count(self.run)),
        ]
        .into_iter()
        .filter_map(|(flag, value)| Some(format!(" {flag} {}", value?)))
        .collect()
    }
}
