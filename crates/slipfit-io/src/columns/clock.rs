//! Where the times of the rows come from.

use super::{
    Chooser, Group, Taken, Time, named,
    names::Role,
    units::{self, Measures, Seconds},
};
use crate::ReadProblem;

impl Chooser<'_> {
    pub(super) fn time(
        &mut self,
        asked: Option<usize>,
        group: &Group,
        signal: Option<usize>,
    ) -> Result<Time, ReadProblem> {
        if let Some(rate) = self.options.rate_hz {
            if let Some(&named) = group.columns.iter().find(|&&c| self.role(c) == Role::Time) {
                let label = self.label(named);
                self.notes.push(format!("{label} was not read: the rate given stands in its place"));
            }
            return Ok(Time::Rate(rate));
        }
        if let Some(index) = asked {
            return self.time_taken(index, "asked for");
        }
        if let Some(rate) = self.head.rate_hz {
            return Ok(Time::Rate(rate));
        }
        let others =
            || group.columns.iter().copied().filter(|&c| Some(c) != signal && self.contents[c].filled > 0.0);
        let named: Vec<usize> = others().filter(|&c| self.role(c) == Role::Time).collect();
        let usable = |c: usize| self.contents[c].is_monotone() || self.is_interval(c);
        let monotone: Vec<usize> =
            others().filter(|&c| self.contents[c].is_monotone() && self.role(c) != Role::Never).collect();
        // A counter of rows tells no rate.
        let by_content = monotone
            .iter()
            .copied()
            .find(|&c| !self.contents[c].counts)
            .filter(|_| others().count() > 1 || signal.is_some());
        if let Some(index) = named.iter().copied().find(|&c| usable(c)) {
            return self.time_taken(index, "named like a time");
        }
        match (named.first().copied(), by_content) {
            (Some(wrong), Some(index)) => {
                self.misnamed = Some(wrong);
                let (wrong, right) = (self.label(wrong), self.label(index));
                self.notes.push(format!("{wrong} is named like a time but does not go up; {right} does"));
                self.by_content = true;
                self.time_taken(index, "its numbers go up steadily")
            }
            (Some(index), None) => self.time_taken(index, "named like a time"),
            (None, Some(index)) => {
                self.by_content = true;
                self.time_taken(index, "its numbers go up steadily")
            }
            (None, None) => {
                // What is named as something else is no time, however constant.
                let unnamed = |c: usize| self.role(c) == Role::Unknown || self.head.names[c].is_step();
                let interval = others().rfind(|&c| unnamed(c) && self.is_interval(c));
                match interval {
                    Some(index) if self.columns.len() > 1 => self.time_taken(
                        index,
                        "its numbers are nearly constant, as times since the row before are",
                    ),
                    _ => Err(ReadProblem::NoTime {
                        columns: self.list(&group.columns),
                        rate_hz: named::named_rate_hz(&self.head.named_values),
                    }),
                }
            }
        }
    }

    /// Whether a column holds the times between rows.
    fn is_interval(&self, index: usize) -> bool {
        let content = self.contents[index];
        let named = self.head.names[index].is_step() && content.least >= 0.0 && content.greatest > 0.0;
        !content.is_monotone() && (content.is_interval() || named)
    }

    fn time_taken(&mut self, index: usize, why: &str) -> Result<Time, ReadProblem> {
        let content = self.contents[index];
        let interval = self.is_interval(index);
        let name = &self.head.names[index];
        let label = self.label(index);
        let known = self.options.time_unit.as_deref().or(Some(name.unit.as_str()).filter(|u| !u.is_empty()));
        let (unit, seconds) = match known {
            Some(unit) => match units::measures(unit) {
                Some(Measures::Time(seconds)) => (unit.to_owned(), seconds),
                _ if unit == "ticks" && self.options.time_unit.is_none() => {
                    return Err(ReadProblem::NoTickRate { column: label });
                }
                _ if self.options.time_unit.is_some() => {
                    return Err(ReadProblem::UnknownTimeUnit { unit: unit.to_owned() });
                }
                _ => ("s".to_owned(), Seconds::Same),
            },
            None if name.bare.to_lowercase().starts_with("milli") => ("ms".to_owned(), Seconds::Over(1e3)),
            None if name.bare.to_lowercase().starts_with("micro") => ("us".to_owned(), Seconds::Over(1e6)),
            None if interval && content.greatest >= 1.0 => {
                self.notes.push(format!(
                    "{label}: steps of {:.0} were taken as milliseconds; --time-unit says otherwise",
                    content.greatest
                ));
                ("ms".to_owned(), Seconds::Over(1e3))
            }
            // Microcontrollers count milliseconds; nobody samples an oscillator every few seconds.
            None if !interval && content.whole && (2.0..=1000.0).contains(&content.mean_step) => {
                self.notes.push(format!(
                    "{label} names no unit and holds whole numbers {:.1} apart: they were taken as milliseconds; --time-unit says otherwise",
                    content.mean_step
                ));
                ("ms".to_owned(), Seconds::Over(1e3))
            }
            None => {
                self.notes.push(format!(
                    "{label} names no unit: its times were taken as seconds; --time-unit says otherwise"
                ));
                ("s".to_owned(), Seconds::Same)
            }
        };
        let taken = Taken { index, unit, why: format!("{label}: {why}"), seconds, level: false };
        Ok(if interval { Time::Intervals(taken) } else { Time::Column(taken) })
    }
}
