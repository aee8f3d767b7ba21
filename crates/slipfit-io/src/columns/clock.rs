//! Choice of the times of the rows.

use super::{
    chooser::{Chooser, ChosenColumn},
    name, named,
    role::Role,
    units::{self, Measures, Seconds},
};
use crate::{
    error::{OptionProblem, ReadProblem},
    report::Note,
};

/// Source of the times.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Time {
    Column(ChosenColumn, Seconds),
    /// Times since the previous row.
    Intervals(ChosenColumn, Seconds),
    /// A sampling rate (Hz).
    Rate(f64),
}

impl Time {
    /// The column of times, if there is one.
    pub(crate) fn column(&self) -> Option<&ChosenColumn> {
        match self {
            Self::Column(chosen, _) | Self::Intervals(chosen, _) => Some(chosen),
            Self::Rate(_) => None,
        }
    }
}

/// Unit of times since 1970, determined by their magnitude, for the years 2001 to 2286.
fn epoch(time: f64) -> Option<(&'static str, Seconds)> {
    const UNITS: [(f64, &str, Seconds); 4] = [
        (1.0, "s", Seconds::Same),
        (1e3, "ms", Seconds::Over(1e3)),
        (1e6, "us", Seconds::Over(1e6)),
        (1e9, "ns", Seconds::Over(1e9)),
    ];
    let within = |&(per_second, ..): &(f64, &str, Seconds)| (1e9..1e10).contains(&(time / per_second));
    UNITS.into_iter().find(within).map(|(_, unit, seconds)| (unit, seconds))
}

/// Longest step between rows of a counting clock without a unit: 1 s in ns.
const COUNTS: f64 = 1e9;

/// Day numbers of the years 1982 to 2064, as used by spreadsheets and by MATLAB.
const DAYS: [std::ops::Range<f64>; 2] = [30e3..60e3, 724e3..754e3];
/// Longest step between rows with day numbers, about a quarter of an hour.
const DAYS_APART: f64 = 0.01;

/// Units of counting clocks that are not units of time.
const COUNTED: &str = "ticks tick samples sample frames frame points counts count";

impl Chooser<'_> {
    pub(super) fn time(&mut self, asked: Option<usize>, signal: Option<usize>) -> Result<Time, ReadProblem> {
        if let Some(rate) = self.options.rate_hz {
            if let Some(&named) = self.near.iter().find(|&&c| self.roles[c] == Role::Time) {
                let label = self.label(named);
                self.notes.push(format!("{label} was not read: the given rate replaces it").into());
            }
            return Ok(Time::Rate(rate));
        }
        if let Some((whole, fraction)) =
            self.split_clock().filter(|(whole, _)| asked.is_none_or(|a| a == *whole))
        {
            return Ok(self.clock_of_two(whole, fraction));
        }
        if let Some(index) = asked {
            return self.time_taken(index, "asked for");
        }
        if let Some(rate) = self.head.rate_hz {
            return Ok(Time::Rate(rate));
        }
        let others =
            || self.near.iter().copied().filter(|&c| Some(c) != signal && self.contents[c].filled > 0.0);
        let named: Vec<usize> = others().filter(|&c| self.roles[c] == Role::Time).collect();
        let usable = |c: usize| self.contents[c].is_monotone() || self.is_interval(c);
        // A row counter is not a time.
        let steady = |&c: &usize| {
            self.contents[c].is_monotone() && self.roles[c] != Role::Never && !self.contents[c].counts
        };
        let by_content = others().find(steady).filter(|_| others().count() > 1 || signal.is_some());
        // Times since the start have more decimal places than times since 1970 and are preferred.
        let since_1970 =
            |c: usize| self.head.names[c].unit.is_empty() && epoch(self.contents[c].least).is_some();
        let best = || named.iter().copied().filter(|&c| usable(c));
        if let Some(index) = best().find(|&c| !since_1970(c)).or_else(|| best().next()) {
            return self.time_taken(index, "named like a time");
        }
        const STEADY: &str = "its numbers increase steadily";
        match (named.first().copied(), by_content) {
            (Some(wrong), Some(index)) => {
                self.roles[wrong] = Role::Unknown;
                let (wrong, right) = (self.label(wrong), self.label(index));
                self.notes
                    .push(format!("{wrong} is named like a time but does not increase; {right} does").into());
                self.by_content = true;
                self.time_taken(index, STEADY)
            }
            (Some(index), None) => self.time_taken(index, "named like a time"),
            (None, Some(index)) => {
                self.by_content = true;
                self.time_taken(index, STEADY)
            }
            (None, None) => {
                // A column named as another quantity is not a time, even if it is constant.
                let unnamed = |c: usize| self.roles[c] == Role::Unknown || self.head.names[c].is_step();
                let interval = others().rfind(|&c| unnamed(c) && self.is_interval(c));
                let rate_hz = named::named_rate_hz(&self.head.named_values);
                match interval {
                    Some(index) if self.values.len() > 1 => self.time_taken(
                        index,
                        "its numbers are nearly constant, as time steps from row to row are",
                    ),
                    _ => {
                        match rate_hz.filter(|_| self.head.has_variables).or_else(|| self.stated_rate_hz()) {
                            Some(rate) => {
                                let text = format!(
                                    "no column of times: the rate that the file names, {rate} Hz, was taken"
                                );
                                self.notes.push(Note::new(text).hint("rate_hz", "gives another"));
                                Ok(Time::Rate(rate))
                            }
                            None => {
                                let columns = self.head.list(&self.near);
                                Err(self
                                    .not_over_time("no column of times")
                                    .unwrap_or(ReadProblem::NoTime { columns, rate_hz }))
                            }
                        }
                    }
                }
            }
        }
    }

    /// The sampling rate stated by the instrument, for a table that is not a curve over frequency.
    fn stated_rate_hz(&self) -> Option<f64> {
        let of_curve = |c: &usize| {
            let role = Role::in_curve(&self.head.names[*c]);
            matches!(role, Role::Frequency | Role::Shift | Role::Period)
        };
        self.head.stated_rate_hz.filter(|_| !self.near.iter().any(of_curve))
    }

    /// The sampling rate named in the file.
    fn named_rate_hz(&self) -> Option<f64> {
        self.head.stated_rate_hz.or_else(|| named::named_rate_hz(&self.head.named_values))
    }

    /// Unit of counts with this mean step, from the rate named in the file, if it is a power of ten other than the
    /// guess.
    fn unit_by_rate(&self, mean_step: f64, guess: Seconds) -> Option<(f64, String, Seconds)> {
        /// Tolerance in decades for the change of the mean step by lost rows: 1 %.
        const WITHIN: f64 = 0.005;
        let rate_hz = self.named_rate_hz()?;
        let decades = (rate_hz * mean_step).log10();
        let per_second = 10f64.powi(decades.round() as i32);
        let by_rate = (decades - decades.round()).abs() < WITHIN && decades.round() >= 1.0;
        let seconds = Seconds::Over(per_second);
        (by_rate && seconds != guess).then(|| (rate_hz, format!("1/{per_second} s"), seconds))
    }

    /// Whether a column holds the time steps between rows.
    fn is_interval(&self, index: usize) -> bool {
        let content = self.contents[index];
        let named = self.head.names[index].is_step() && content.least >= 0.0 && content.greatest > 0.0;
        !content.is_monotone() && (content.is_interval() || named)
    }

    /// The times of the signal's own sensor, if each sensor has its own time column: `Time A`, `Pos A`, `Time B`,
    /// `Pos B`.
    pub(super) fn nearer_time(&self, time: &Time, signal: usize) -> Option<usize> {
        let Time::Column(taken, _) = time else { return None };
        let before = signal.checked_sub(1)?;
        let unit = |c: usize| &self.head.names[c].unit;
        let is_time = self.roles[before] == Role::Time && self.contents[before].is_monotone();
        (taken.index + 1 < before && is_time && unit(before) == unit(taken.index)).then_some(before)
    }

    pub(super) fn time_taken(&mut self, index: usize, why: &str) -> Result<Time, ReadProblem> {
        let interval = self.is_interval(index);
        let (unit, seconds) = match &self.options.time_unit {
            Some(unit) => match units::measures(unit) {
                Some(Measures::Time(seconds)) => (unit.clone(), seconds),
                _ => {
                    let known = "s, ms, us, ns, min, h, days or the rate of a clock such as 60MHz";
                    let problem = OptionProblem::UnknownUnit(known);
                    return Err(ReadProblem::Option { option: "time_unit", value: unit.clone(), problem });
                }
            },
            None => self.time_unit(index, interval)?,
        };
        let chosen = ChosenColumn { unit, ..self.choose_column(index, why) };
        Ok(if interval { Time::Intervals(chosen, seconds) } else { Time::Column(chosen, seconds) })
    }

    /// Unit of the times, from their header or their numbers.
    fn time_unit(&mut self, index: usize, interval: bool) -> Result<(String, Seconds), ReadProblem> {
        let (content, name, label) = (self.contents[index], &self.head.names[index], self.label(index));
        let milliseconds = || ("ms".to_owned(), Seconds::Over(1e3));
        let microseconds = || ("us".to_owned(), Seconds::Over(1e6));
        let nanoseconds = || ("ns".to_owned(), Seconds::Over(1e9));
        if !name.unit.is_empty() {
            return match units::measures(&name.unit) {
                Some(Measures::Time(seconds)) => Ok((name.unit.clone(), seconds)),
                _ if units::listed(COUNTED, &name.unit.to_lowercase()) => {
                    let rate_hz = self.named_rate_hz().ok_or(ReadProblem::NoTickRate { column: label })?;
                    let unit = name.unit.clone();
                    let text = format!("the rate that the file names, {rate_hz} Hz, is that of its {unit}");
                    self.notes.push(Note::new(text).hint("rate_hz", "gives another"));
                    Ok((unit, Seconds::Over(rate_hz)))
                }
                other => {
                    let what = if other.is_some() { "not a unit of time" } else { "not a known unit" };
                    let text = format!("{label}: {} is {what}: seconds were taken", name.unit);
                    self.notes.push(Note::new(text).hint("time_unit", "gives another"));
                    Ok(("s".to_owned(), Seconds::Same))
                }
            };
        }
        let bare = name.bare.to_lowercase();
        let words = name::words(&bare);
        let of_words = words.iter().find_map(|word| match units::measures(word) {
            Some(Measures::Time(seconds @ Seconds::Over(_))) if word != "ps" => Some((word.clone(), seconds)),
            _ => None,
        });
        if let Some(named) = of_words {
            return Ok(named);
        }
        if bare.starts_with("milli") {
            return Ok(milliseconds());
        }
        if bare.starts_with("micro") {
            return Ok(microseconds());
        }
        if words.iter().any(|word| matches!(word.as_str(), "second" | "seconds" | "sec" | "secs")) {
            return Ok(("s".to_owned(), Seconds::Same));
        }
        let counted = epoch(content.least).filter(|_| !interval);
        let (text, taken) = if let Some((unit, seconds)) = counted {
            let text = format!("{label} names no unit and counts from 1970: its times were taken as {unit}");
            (text, (unit.to_owned(), seconds))
        } else if interval && content.greatest >= 1.0 {
            let text = format!(
                "{label}: its numbers, up to {:.0}, were taken as steps in milliseconds",
                content.greatest
            );
            (text, milliseconds())
        } else if !interval && content.whole && (2.0..=COUNTS).contains(&content.mean_step) {
            // Microcontrollers count milliseconds and microseconds; an oscillator is not sampled only every few
            // seconds.
            let (of_what, taken) = match content.mean_step {
                step if step <= 1e3 => ("milliseconds", milliseconds()),
                step if step <= 1e6 => ("microseconds", microseconds()),
                _ => ("nanoseconds", nanoseconds()),
            };
            let apart =
                format!("{label} names no unit and holds whole numbers {:.1} apart", content.mean_step);
            match self.unit_by_rate(content.mean_step, taken.1) {
                Some((rate_hz, unit, seconds)) => {
                    let text = format!(
                        "{apart}: they were taken as {unit}, by the rate that the file names, {rate_hz} Hz"
                    );
                    (text, (unit, seconds))
                }
                None => (format!("{apart}: they were taken as {of_what}"), taken),
            }
        } else {
            let text = format!("{label} names no unit: its times were taken as seconds");
            (text, ("s".to_owned(), Seconds::Same))
        };
        // Day numbers since 1900 or since the year 0, with rows less than a day apart.
        let in_days = !content.whole && DAYS.iter().any(|days| days.contains(&content.least)) && !interval;
        let advice = if in_days && content.mean_step < DAYS_APART {
            "gives another, such as days for the day numbers of a spreadsheet"
        } else {
            "gives another"
        };
        self.notes.push(Note::new(text).hint("time_unit", advice));
        Ok(taken)
    }
}
