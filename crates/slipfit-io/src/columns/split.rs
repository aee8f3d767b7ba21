//! Times in two columns: whole seconds, and fractions of a second to be added.

use super::{
    chooser::{Chooser, ChosenColumn, Fraction},
    clock::Time,
    name,
    role::Role,
    units::{self, Measures, Seconds},
};
use crate::report::Note;

impl Fraction {
    fn unit(self) -> &'static str {
        match self.per_second {
            1e3 => "ms",
            1e6 => "us",
            1e9 => "ns",
            _ => "s",
        }
    }
}

/// Share of rising steps of a clock; midnight is a step that does not rise.
const RISING: f64 = 0.98;

impl Chooser<'_> {
    /// Finds columns of whole seconds and of fractions to be added.
    pub(super) fn split_clock(&self) -> Option<(usize, Fraction)> {
        if self.options.time_unit.is_some() {
            return None;
        }
        self.seconds_and_nanoseconds().or_else(|| self.clock_and_fraction())
    }

    /// Times as written by ROS: `stamp.secs`, `stamp.nsecs`.
    fn seconds_and_nanoseconds(&self) -> Option<(usize, Fraction)> {
        let name = |c: usize| name::words(&self.head.names[c].header);
        let pair = |c: usize| {
            let words = name(c);
            let (last, before) = words.split_last().filter(|(last, _)| units::listed("sec secs", last))?;
            let content = self.contents[c];
            if !(content.whole && content.rising == 1.0 && content.filled > 0.0) {
                return None;
            }
            let fraction = [format!("n{last}"), format!("nano{last}")];
            self.near.iter().copied().find(|&other| {
                let (content, words) = (self.contents[other], name(other));
                let is_fraction =
                    content.whole && content.least >= 0.0 && (1e3..1e9).contains(&content.greatest);
                let [of_second @ .., last] = &words[..] else { return false };
                is_fraction && of_second == before && fraction.contains(last)
            })
        };
        self.near.iter().find_map(|&c| Some((c, Fraction { index: pair(c)?, per_second: 1e9 })))
    }

    /// Times as written by loggers and multimeters: a time of day `10:22:33` that is constant within a second, next to
    /// `ms` or `Fractional Seconds`.
    fn clock_and_fraction(&self) -> Option<(usize, Fraction)> {
        let in_seconds = |c: &usize| {
            let (content, name) = (self.contents[*c], &self.head.names[*c]);
            let is_time =
                self.roles[*c] == Role::Time && name.measures() == Some(Measures::Time(Seconds::Same));
            is_time && content.whole && content.moving < RISING
        };
        let fraction = |index: usize| {
            let (content, name) = (self.contents[index], &self.head.names[index]);
            let says_part =
                || name::words(&name.header).iter().any(|word| units::listed("fraction fractional", word));
            let per_second = match name.measures() {
                Some(Measures::Time(Seconds::Over(per_second))) => per_second,
                Some(Measures::Time(Seconds::Same)) | None if says_part() => 1.0,
                _ => return None,
            };
            (content.least >= 0.0 && content.greatest < per_second).then_some(Fraction { index, per_second })
        };
        self.near.iter().copied().filter(in_seconds).find_map(|whole| {
            let others = self.near.iter().copied().filter(|&other| other != whole);
            let found = others.filter_map(fraction).find(|part| self.is_clock(whole, *part));
            Some((whole, found?))
        })
    }

    /// Whether the sum of two columns increases from row to row.
    fn is_clock(&self, whole: usize, part: Fraction) -> bool {
        let rows = self.values[whole].iter().zip(&self.values[part.index]);
        let times: Vec<f64> = rows
            .map(|(whole, fraction)| whole + fraction / part.per_second)
            .filter(|t| t.is_finite())
            .collect();
        let up = times.windows(2).filter(|w| w[1] > w[0]).count();
        times.len() > 1 && up as f64 >= RISING * (times.len() - 1) as f64
    }

    /// Times as the sum of both columns.
    pub(super) fn clock_of_two(&mut self, whole: usize, fraction: Fraction) -> Time {
        self.roles[whole] = Role::Time;
        self.roles[fraction.index] = Role::Never;
        let (seconds, parts, unit) = (self.label(whole), self.label(fraction.index), fraction.unit());
        let text = format!("the times are the sum of {seconds} in s and {parts} in {unit}");
        self.notes.push(Note::new(text).hint("time", "names another column"));
        self.fraction = Some(fraction);
        Time::Column(
            ChosenColumn {
                unit: "s".to_owned(),
                ..self.choose_column(whole, "whole seconds, to which parts of one are added")
            },
            Seconds::Same,
        )
    }
}
