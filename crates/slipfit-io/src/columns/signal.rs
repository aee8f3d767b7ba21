//! Choice of the signal column.

use std::f64::consts::TAU;

use slipfit::SignalKind;

use super::{
    chooser::{Chooser, ChosenColumn},
    content, named,
    role::{self, Role, names_force},
    units::{self, Measures},
};
use crate::{
    error::{Needed, ReadProblem},
    report::Note,
};

/// Tolerances, relative to an amplitude and in radians, within which the columns of one lock-in agree despite rounding.
const MODULUS_WITHIN: f64 = 0.02;
const ANGLE_WITHIN_RAD: f64 = 0.05;
/// The acceleration of gravity in m/s² and in g, and the relative tolerance for the sensor and the swing.
const GRAVITY: [f64; 2] = [9.81, 1.0];
const GRAVITY_WITHIN: f64 = 0.05;
/// Rank of a column with an uninformative name.
const UNKNOWN_RANK: u8 = 40;

impl Chooser<'_> {
    /// Columns that could be the signal.
    pub(super) fn candidates(&self, time: Option<usize>) -> Vec<usize> {
        self.near
            .iter()
            .copied()
            .filter(|&c| Some(c) != time && self.contents[c].filled > 0.0)
            .filter(|&c| !matches!(self.roles[c], Role::Time | Role::Never))
            .filter(|&c| self.roles[c] != Role::Unknown || !self.is_second_clock(c))
            .collect()
    }

    /// The only column apart from the times, if it is named like an accompanying quantity but measures something that
    /// follows the motion: a force, a pressure, the voltage of a `Sample`.
    pub(super) fn only_other(&mut self, time: Option<usize>) -> Option<usize> {
        let filled = |c: &usize| {
            Some(*c) != time && Some(*c) != self.fraction.map(|f| f.index) && self.contents[*c].filled > 0.0
        };
        let others: Vec<usize> = self.near.iter().copied().filter(filled).collect();
        let [only] = others[..] else { return None };
        let (name, content) = (&self.head.names[only], self.contents[only]);
        let measured = matches!(name.measures(), Some(Measures::Signal(_)));
        let follows = self.roles[only] == Role::Never && (measured || names_force(name));
        if !follows || content.counts || content.is_monotone() {
            return None;
        }
        let text = format!(
            "{} is the only column apart from the times: it was taken as proportional to the displacement",
            self.label(only)
        );
        self.notes.push(Note::new(text).hint("kind", "gives another"));
        Some(only)
    }

    /// Whether one of several columns increases like a time or a counter.
    fn is_second_clock(&self, column: usize) -> bool {
        self.near.len() > 1 && self.contents[column].counts
            || self.near.len() > 2
                && self.contents[column].is_monotone()
                && self.contents[column].moving > 0.5
    }

    pub(super) fn lock_in_pair(&self, candidates: &[usize]) -> Option<(usize, usize)> {
        let by_role = |role: Role| candidates.iter().copied().find(|&c| self.roles[c] == role);
        if let (Some(i), Some(q)) = (by_role(Role::Real), by_role(Role::Imaginary)) {
            return Some((i, q));
        }
        let named = |name: &str| {
            candidates.iter().copied().find(|&c| self.head.names[c].bare.trim().eq_ignore_ascii_case(name))
        };
        let (x, y) = (named("x")?, named("y")?);
        let electrical = |c: usize| {
            let unit = self.head.names[c].unit.as_str();
            unit.ends_with('V') || unit.ends_with('A')
        };
        let beside = self.near.iter().any(|&c| {
            let name = self.head.names[c].bare.to_lowercase();
            match name.trim() {
                "r" | "mag" => self.is_modulus(c, x, y),
                "phase" | "theta" => self.is_angle(c, x, y),
                "frequency" => self.contents[c].greatest > 0.0,
                _ => false,
            }
        });
        let asked = self.options.kind == Some(SignalKind::LockIn);
        let open = self.options.kind.is_none();
        (asked || (open && (beside || (electrical(x) && electrical(y))))).then_some((x, y))
    }

    /// Whether nearly all rows of a column are `sqrt(x² + y²)` times a common factor.
    pub(super) fn is_modulus(&self, column: usize, x: usize, y: usize) -> bool {
        let [r, x, y] = [column, x, y].map(|c| &self.values[c]);
        let mut factors: Vec<f64> = r
            .iter()
            .zip(x.iter().zip(y))
            .map(|(r, (x, y))| r / x.hypot(*y))
            .filter(|f| f.is_finite())
            .collect();
        factors.sort_unstable_by(f64::total_cmp);
        let Some(middle) = factors.get(factors.len() / 2).copied().filter(|m| *m > 0.0) else { return false };
        let near = factors.iter().filter(|f| (*f / middle - 1.0).abs() < MODULUS_WITHIN).count();
        near * 10 >= factors.len() * 9
    }

    /// Whether nearly all rows of a column are the angle of `x + i y`, in degrees or radians, modulo whole turns.
    fn is_angle(&self, column: usize, x: usize, y: usize) -> bool {
        let [angle, x, y] = [column, x, y].map(|c| &self.values[c]);
        [1.0, 1f64.to_radians()].into_iter().any(|factor| {
            let rows = || angle.iter().zip(x.iter().zip(y)).filter(|(a, (x, y))| (*a + *x + *y).is_finite());
            let near = |(a, (x, y)): &(&f64, (&f64, &f64))| {
                let apart = (*a * factor - y.atan2(**x)).rem_euclid(TAU);
                apart.min(TAU - apart) < ANGLE_WITHIN_RAD
            };
            let all = rows().count();
            all > 0 && rows().filter(near).count() * 10 >= all * 9
        })
    }

    fn rank(&self, index: usize) -> u8 {
        match self.roles[index] {
            // If there is an amplitude R, theta comes from the same instrument and is not the signal.
            Role::Signal { like: "named like an angle", .. } if self.has_r() => 0,
            Role::Signal { rank, .. } => rank,
            _ => UNKNOWN_RANK,
        }
    }

    fn has_r(&self) -> bool {
        self.head.names.iter().any(|n| n.bare.trim().eq_ignore_ascii_case("r"))
    }

    /// The column that is most likely the signal.
    pub(super) fn best(&mut self, candidates: &[usize]) -> Result<(usize, String), ReadProblem> {
        let varies = |c: &usize| self.contents[*c].greatest > self.contents[*c].least;
        let varying: Vec<usize> = candidates.iter().copied().filter(varies).collect();
        let from = if varying.is_empty() { candidates } else { &varying };
        let top = from.iter().map(|&c| self.rank(c)).max();
        let mut best: Vec<usize> = from.iter().copied().filter(|&c| Some(self.rank(c)) == top).collect();
        // A gyroscope at rest next to an oscillating accelerometer.
        let is_of =
            |c: usize, of: SignalKind| matches!(self.roles[c], Role::Signal { kind, .. } if kind == of);
        let rings = |c: usize| self.contents[c].is_ringing();
        if !best.is_empty() && best.iter().all(|&c| is_of(c, SignalKind::Velocity) && !rings(c)) {
            let swings = |c: &usize| is_of(*c, SignalKind::Acceleration) && rings(*c);
            let swinging: Vec<usize> = from.iter().copied().filter(swings).collect();
            if !swinging.is_empty() {
                best = swinging;
                self.by_content = true;
            }
        }
        let like = match best.first().map(|&c| self.roles[c]) {
            None => {
                let missing = ReadProblem::NoColumn { needed: Needed::Signal, columns: self.list() };
                return Err(self.not_over_time(Needed::Signal.missing()).unwrap_or(missing));
            }
            Some(Role::Signal { like, .. }) => like,
            Some(_) => "",
        };
        if let [only] = best[..] {
            let why = if like.is_empty() { "the only column left" } else { like };
            return Ok((only, why.to_owned()));
        }
        self.by_content = true;
        let among = self.head.list(&best);
        let ringing: Vec<usize> = best.iter().copied().filter(|&c| self.contents[c].is_ringing()).collect();
        if !ringing.is_empty() {
            best = ringing;
        }
        // A derivative has another unit: axes of one unit are a quarter period apart if the motion is an ellipse.
        let one_unit = |a: usize, b: usize| {
            let unit = |c: usize| &self.head.names[c].unit;
            !unit(a).is_empty() && unit(a) == unit(b)
        };
        let derived = |c: usize| {
            best.iter().any(|&other| {
                other != c
                    && !one_unit(c, other)
                    && content::is_derivative(&self.values[c], &self.values[other])
            })
        };
        let square_of = |c: usize| {
            best.iter().copied().find(|&other| {
                other != c && one_unit(c, other) && content::is_square(&self.values[c], &self.values[other])
            })
        };
        let squares: Vec<(usize, usize)> = best.iter().filter_map(|&c| Some((c, square_of(c)?))).collect();
        let original: Vec<usize> = best.iter().copied().filter(|&c| !derived(c)).collect();
        if !original.is_empty() {
            best = original;
        }
        let linear = |c: &usize| squares.iter().all(|(square, _)| square != c);
        if best.iter().any(linear) {
            best.retain(linear);
            for (square, of) in squares {
                let (square, of) = (self.label(square), self.label(of));
                let text = format!(
                    "{square} varies like the square of {of}, as an acceleration along a pendulum does, \
                     and was not taken"
                );
                self.notes.push(Note::new(text).hint("signal", "names another"));
            }
        }
        // Swings are comparable only within one unit.
        let unit = &self.head.names[best[0]].unit;
        let greatest =
            best.iter()
                .copied()
                .filter(|&c| self.head.names[c].unit == *unit)
                .reduce(|held, c| {
                    if self.contents[c].greatest_rms > self.contents[held].greatest_rms { c } else { held }
                })
                .unwrap_or(best[0]);
        let prefix = if like.is_empty() { String::new() } else { format!("{like}, and ") };
        Ok((greatest, format!("{prefix}has the strongest decaying oscillation among {among}")))
    }

    /// Whether a column is the acceleration across a pendulum, and another one is the acceleration along it, including
    /// gravity.
    pub(super) fn turns_in_gravity(&self, signal: usize) -> bool {
        let holds_gravity = |c: usize| {
            let (sum, n) = self.finite(c).fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0));
            let level = (sum / n).abs();
            GRAVITY.into_iter().any(|g| (level / g - 1.0).abs() < GRAVITY_WITHIN)
        };
        let unit = |c: usize| &self.head.names[c].unit;
        self.near.iter().any(|&c| {
            c != signal
                && unit(c) == unit(signal)
                && holds_gravity(c)
                && content::is_square(&self.values[c], &self.values[signal])
        })
    }

    pub(super) fn kind_of(&self, index: usize) -> SignalKind {
        // A unit given or named separately takes precedence over the name; m alone is no evidence.
        let named_apart = self.options.unit.is_some() || self.head.names[index].unit.is_empty();
        match units::measures(self.written_unit(index)).filter(|_| named_apart) {
            Some(Measures::Signal(kind)) if kind != SignalKind::Displacement => return kind,
            _ => {}
        }
        match self.roles[index] {
            // Oscilloscopes label a waveform as an amplitude; an envelope is never negative.
            Role::Signal { kind: SignalKind::Envelope, .. }
                if self.contents[index].least < 0.0 && !self.signal_taken(index, "").1 =>
            {
                SignalKind::Displacement
            }
            Role::Signal { kind, .. } => kind,
            _ => SignalKind::Displacement,
        }
    }

    /// Kind measured by an axis without a unit, from the name of its sheet or file: `Accelerometer.csv`.
    pub(super) fn kind_of_place(&mut self, index: usize, file: &str) -> Option<SignalKind> {
        let axis = self.head.names[index].bare.trim().to_lowercase();
        if !units::listed("x y z", &axis) || !self.written_unit(index).is_empty() {
            return None;
        }
        // Next to a separate velocity or acceleration column the axis is a position, whatever the name of the file.
        let derived = |c: &usize| {
            let kind = match self.roles[*c] {
                Role::Signal { kind, .. } => kind,
                _ => SignalKind::Displacement,
            };
            *c != index && matches!(kind, SignalKind::Velocity | SignalKind::Acceleration)
        };
        if self.near.iter().any(derived) {
            return None;
        }
        let base = file.rsplit(['/', '\\']).next().unwrap_or_default();
        let of = |place: &str| role::kind_of_place(place).map(|kind| (kind, place.to_owned()));
        let (kind, place) = of(&self.head.name).or_else(|| of(base))?;
        let what = if kind == SignalKind::Velocity { "a velocity" } else { "an acceleration" };
        let text = format!("{} was taken as {what}, by the name `{place}`", self.label(index));
        self.notes.push(Note::new(text).hint("kind", "gives another"));
        Some(kind)
    }

    /// The unit given, that in the header, or that named above the table, in this order.
    fn written_unit(&self, index: usize) -> &str {
        let in_header = self.head.names[index].unit.as_str();
        let named = || named::named_unit(&self.head.named_values).unwrap_or_default();
        match &self.options.unit {
            Some(given) => given.trim(),
            None if in_header.is_empty() => named(),
            None => in_header,
        }
    }

    /// Notes that the given unit differs from the one in the header.
    pub(super) fn note_another_unit(&mut self, index: usize) {
        let in_header = self.head.names[index].unit.as_str();
        let Some(given) = self.options.unit.as_deref().map(str::trim) else { return };
        if !(in_header.is_empty() || in_header == given || units::ratio(in_header, given) == Some(1.0)) {
            let label = self.label(index);
            let text =
                format!("{label} is headed {in_header}; its numbers were taken as {given}, the unit given");
            self.notes.push(text.into());
        }
    }

    /// The signal, and whether its levels have to be made linear.
    pub(super) fn signal_taken(&self, index: usize, why: &str) -> (ChosenColumn, bool) {
        let written = self.written_unit(index);
        let linear = units::linear_unit(written);
        let unit = linear.unwrap_or(written).to_owned();
        (ChosenColumn { unit, ..self.choose_column(index, why) }, linear.is_some())
    }
}
