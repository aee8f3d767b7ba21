//! The exact fundamental with its derivatives with respect to the oscillator's parameters, used for fitting resonance
//! curves.

use super::closed::{self, Closed, Halves, KAPPA};
use super::one_stop::{self, Accuracy, Row, Slip};
use super::orbit::{OrbitOptions, PeriodicOrbit};

use super::HarmonicDrive;
use super::stops;
use crate::model::oscillator::Oscillator;
use crate::numeric::dual::{Dual, Pair};
use std::f64::consts::PI;

pub(crate) use super::one_stop::{GROUP, Group, GroupResponse, Slips};
pub use super::response::{Fundamental, Point, Regime};

/// The closed form with two turning points per cycle, continued also to motions that would stop and to negative
/// friction, so that a fit has a smooth function:
///
/// ```text
/// Z = x_0/D - i (4/pi) (x_F/x_0) (D*/D) (p + i q),   q = H x_F,   p = sqrt((x_0/|D|)² - q²)
/// ```
///
/// with `D` the dynamic over the static stiffness and `H` as in [`ClosedForm`](super::exact::ClosedForm). `None` if
/// the root has no real value.
#[inline]
pub fn closed(at: &Point) -> Option<Fundamental> {
    closed_at(at).map(|c| c.fundamental())
}

#[inline]
fn closed_at(at: &Point) -> Option<Closed> {
    let over_omega = 1.0 / at.omega;
    let (sin, cos) = (0.5 * PI * closed::excess(at) * over_omega).sin_cos();
    let sinh = (0.5 * PI * at.delta * over_omega).sinh();
    let cosh = (1.0 + sinh * sinh).sqrt();
    let c = closed::closed_form(at, over_omega, Halves { sin, cos, sinh, cosh });
    (c.p > 0.0 && c.p.is_finite()).then_some(c)
}

/// Number of oscillator swings per cycle of the drive, rounded up.
fn swings(at: &Point) -> u64 {
    ((at.omega_0 / at.omega) as u64).saturating_add(1)
}

/// Whether the mass moves on at once at the turning point and keeps its direction for half a cycle.
fn moves_on(at: &Point, c: &Closed) -> bool {
    c.push(at.x_f) >= 0.0 && (at.omega > closed::NEVER_TURNS * at.omega_0 || closed::keeps_direction(at, c))
}

/// The exact fundamental, for any number of stops, with its derivatives.
///
/// Static friction is taken equal to kinetic friction. Motion with two turning points per cycle and symmetric motion
/// with stops have closed forms (the latter up to the roots for the ends of the slides). For anything else (a drive
/// far slower than a hardly damped oscillator) the orbit is found by shooting, with the derivatives of the closed
/// form. A negative friction, for which no motion exists, gets the continued closed form.
///
/// `None` if there is no such motion: no damping at resonance, an overdamped oscillator (`delta >= omega_0`) that
/// moves at all, or non-finite values.
pub fn fundamental(at: &Point) -> Option<Fundamental> {
    Follower::default().fundamental(at)
}

/// The same along a curve: the last motion with a stop gives the start values of the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Follower {
    last: Option<Followed>,
    /// The motion at the frequency before.
    before: Option<Followed>,
    /// Accuracy of a motion next to the last one.
    accuracy: Accuracy,
    /// Whether periodic motions without a closed form are searched for.
    searches: bool,
    /// Work done, in units of about 30 ns.
    work: u64,
    /// Work after which no further motion is computed.
    most_work: u64,
}

/// A motion with one stop and the frequency of its drive.
#[derive(Debug, Clone, Copy)]
struct Followed {
    omega: f64,
    slip: Slip,
}

/// Distance to the next frequency, over that between the last two, up to which a motion is extrapolated linearly.
const LONGEST_LINE: f64 = 4.0;
/// The same for a group of frequencies.
const LONGEST_LINE_OF_GROUPS: f64 = 4.0 * GROUP as f64;

/// Work of one motion by each method, from its computing time.
const WORK_OF_CLOSED: u64 = 9;
/// Maximum number of swings counted for the walk along a half cycle, because it ends with the first turning point, or
/// leaps.
const MOST_WALKED: u64 = 50;
const WORK_OF_ONE_STOP: u64 = 8;
/// The same per swing of the oscillator in a cycle of its drive.
const WORK_OF_SWING: u64 = 2;
/// Work of eight motions with one stop, computed side by side.
const WORK_OF_GROUP: u64 = 40;
const WORK_OF_SLIDE: u64 = 26;
const WORK_OF_ARC: u64 = 30;
/// Number of oscillator swings that take as long to follow as the fixed cost of an arc.
const SWINGS_OF_ARC: u64 = 2;
/// Number of states, in the integral for the fundamental, that take as long as an arc.
const STATES_OF_ARC: u64 = 5;
/// Number of arcs that take as long as that integral over one arc, as estimated in advance.
const ARCS_OF_QUADRATURE: u64 = 20;
/// Frequency over the natural frequency above which the response is small compared with its rounding error, so that
/// its integral takes longer.
const SMALL_RESPONSE: f64 = 300.0;
/// Number of arcs, per swing of the oscillator, of a search that finds no periodic motion.
const ARCS_OF_FAILED_SEARCH: u64 = 1_000;
/// Number of oscillator swings per cycle of the drive above which a fit computes no motion with stops, because each
/// swing has to be stepped through.
const MOST_SWINGS: f64 = 1_000.0;

impl Default for Follower {
    fn default() -> Self {
        Self {
            last: None,
            before: None,
            accuracy: Accuracy::Fine,
            searches: true,
            work: 0,
            most_work: u64::MAX,
        }
    }
}

impl Follower {
    /// Settings for a fit: eight digits, because twelve take a hundred times as long, and no further motion after
    /// `most_work`.
    pub(crate) fn for_fit(most_work: u64) -> Self {
        Self { accuracy: Accuracy::Coarse, most_work, ..Self::default() }
    }

    /// Without the motions that can only be found by a search.
    pub(crate) fn without_search() -> Self {
        Self { searches: false, ..Self::default() }
    }

    /// Work done so far.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// [`fundamental`] at the next frequency.
    pub(crate) fn fundamental(&mut self, at: &Point) -> Option<Fundamental> {
        if !(at.omega > 0.0 && at.omega_0 > 0.0 && at.delta.is_finite() && at.x_0 > 0.0) {
            return None;
        }
        if !(at.omega.is_finite() && at.omega_0.is_finite() && at.x_0.is_finite() && at.x_f.is_finite()) {
            return None;
        }
        if at.delta.abs() >= at.omega_0 {
            // A mass at rest stays at rest whatever the damping.
            return (at.x_0 <= at.x_f).then_some(Fundamental::REST);
        }
        if self.work >= self.most_work {
            return None;
        }
        self.work += WORK_OF_CLOSED;
        let closed = closed_at(at);
        if at.x_f <= 0.0 {
            return closed.map(|c| c.fundamental());
        }
        // The check that it keeps its direction walks along the half cycle.
        self.work = self.work.saturating_add(swings(at).min(MOST_WALKED));
        if let Some(c) = closed.filter(|c| moves_on(at, c)) {
            return Some(c.fundamental());
        }
        self.stopping(at, closed)
    }

    /// Motion whose mass does not move on at its turning point.
    fn stopping(&mut self, at: &Point, closed: Option<Closed>) -> Option<Fundamental> {
        if at.x_0 <= at.x_f {
            return Some(Fundamental::REST);
        }
        let limited = self.most_work < u64::MAX;
        if limited && at.omega_0 > MOST_SWINGS * at.omega {
            return None;
        }
        let last = self.near(at.omega);
        let guess = closed.map_or(at.x_0, |c| c.turn_amplitude());
        // In half a cycle of a slow drive the oscillator swings many times.
        let swings = swings(at);
        let mut work = 0;
        let one_stop = |near: Option<Slip>, accuracy, work: &mut u64| {
            *work += WORK_OF_ONE_STOP + WORK_OF_SWING * swings;
            one_stop::fundamental(at, near?, accuracy).map(|(f, slip)| (f, Some(slip)))
        };
        let mut found = one_stop(last, self.accuracy, &mut work);
        if found.is_none() {
            let cold = Slip::from_amplitude(at, guess);
            found = one_stop(cold, Accuracy::Fine, &mut work);
            if found.is_none() {
                let mut slides = 0;
                found = stops::fundamental(at, guess, &mut slides);
                work += WORK_OF_SLIDE * slides;
                found = found
                    .or_else(|| one_stop(last, Accuracy::Coarse, &mut work))
                    .or_else(|| one_stop(cold, Accuracy::Coarse, &mut work));
            }
        }
        if found.is_none() && self.searches {
            // An upper limit of the work of the search is known before it begins.
            let failed = WORK_OF_ARC.saturating_mul(ARCS_OF_FAILED_SEARCH).saturating_mul(swings);
            let left = self.most_work.saturating_sub(self.work).saturating_sub(work);
            if !limited || failed.saturating_add(quadrature(at).saturating_mul(8 * WORK_OF_ARC)) < left {
                let (motion, arcs) = by_event_machine(at, closed.map(|c| c.fundamental()), limited);
                work = work.saturating_add(arcs.map_or(failed, |arcs| WORK_OF_ARC * arcs));
                found = motion.map(|f| (f, None));
            } else {
                work = work.saturating_add(left);
            }
        }
        self.work = self.work.saturating_add(work);
        let (found, slip) = found?;
        if let Some(slip) = slip {
            self.followed(at.omega, slip);
        }
        Some(found)
    }

    /// Extrapolation of the followed motions to the next frequencies; `None` if there are none.
    pub(crate) fn slips(&self, omega: &Row) -> Option<Slips> {
        let last = self.last?;
        let before = self.before.unwrap_or(Followed { omega: 0.5 * last.omega, ..last });
        let over = 1.0 / (last.omega - before.omega);
        let line = (omega[GROUP - 1] - last.omega).abs() * over.abs() < LONGEST_LINE_OF_GROUPS;
        let mut slips = Slips { phase: [0.0; GROUP], duration: [0.0; GROUP] };
        for k in 0..GROUP {
            let part = if line { (omega[k] - last.omega) * over } else { 0.0 };
            let slip = last.slip.beyond(before.slip, part, [before.omega, last.omega, omega[k]]);
            slips.phase[k] = slip.phase.clamp(0.02, PI - 0.02);
            slips.duration[k] = slip.duration.clamp(0.02 * PI / omega[k], 1.1 * PI / omega[k]);
        }
        Some(slips)
    }

    /// Records the motions with one stop that were found in a group.
    pub(crate) fn follow(&mut self, omega: &Row, slips: &Slips, found: &[bool; GROUP]) {
        for k in (0..GROUP).filter(|&k| found[k]) {
            let slip = Slip::new(slips.phase[k], slips.duration[k]);
            self.followed(omega[k], slip);
        }
    }

    /// Adds the work of this many groups of motions.
    pub(crate) fn count_groups(&mut self, groups: u64) {
        self.work += WORK_OF_GROUP * groups;
    }

    /// Adds the work of this many motions in closed form, computed side by side.
    pub(crate) fn count_closed(&mut self, motions: u64) {
        self.work += motions;
    }

    /// Whether the work is used up, so that no further motion is computed.
    pub(crate) fn is_spent(&self) -> bool {
        self.work >= self.most_work
    }

    /// Requested accuracy.
    pub(crate) fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    fn followed(&mut self, omega: f64, slip: Slip) {
        if self.last.is_some_and(|last| last.omega != omega) {
            self.before = self.last;
        }
        self.last = Some(Followed { omega, slip });
    }

    /// Extrapolation of the followed motion to the next frequency.
    fn near(&self, omega: f64) -> Option<Slip> {
        let last = self.last?;
        let Some(before) = self.before else { return Some(last.slip) };
        let part = (omega - last.omega) / (last.omega - before.omega);
        if !(part.abs() <= LONGEST_LINE) {
            return Some(last.slip);
        }
        Some(last.slip.beyond(before.slip, part, [before.omega, last.omega, omega]))
    }
}

/// Leading term, eq. (8), with derivatives; the mass rests if it has no root.
pub fn leading(at: &Point) -> Option<Fundamental> {
    let omega_0 = Dual::<4>::variable(at.omega_0, 0);
    let delta = Dual::variable(at.delta, 1);
    let x_0 = Dual::variable(at.x_0, 2);
    let b = Dual::variable(at.x_f, 3).scale(KAPPA);
    let over = (omega_0 * omega_0).recip();
    // omega_0 - omega, given separately for accuracy.
    let mut gap = omega_0;
    gap.value = -at.detuning;
    let re = gap * (omega_0 + Dual::constant(at.omega)) * over;
    let im = (delta * over).scale(2.0 * at.omega);
    let square = re * re + im * im;
    let under = x_0 * x_0 * square - b * b * re * re;
    if !(under.value > 0.0) {
        return Some(Fundamental::REST);
    }
    let r = (under.sqrt() - b * im) * square.recip();
    if !(r.value > 0.0 && r.value.is_finite()) {
        return Some(Fundamental::REST);
    }
    // x_0 = (D R + i b) e^(i lag), rotated back.
    let z = Pair::new(re * r, im * r + b).conj().times(r * x_0.recip());
    Some(Fundamental::of_pair(&z, Regime::Sliding))
}

/// Number of cycles after which the event machine gives up.
const MOST_CYCLES: u32 = 60;

/// The periodic motion of the event machine with the derivatives of `near`, and the number of arcs computed; `None`
/// if there is no such motion.
fn by_event_machine(
    at: &Point,
    near: Option<Fundamental>,
    from_rest: bool,
) -> (Option<Fundamental>, Option<u64>) {
    let Some(orbit) = orbit(at, from_rest) else { return (None, None) };
    // Finding the end of an arc takes time along the arc.
    let a_cycle = orbit.events().len() as u64 + 2 + swings(at) / SWINGS_OF_ARC;
    let arcs = u64::from(orbit.cycles()).saturating_mul(a_cycle);
    if orbit.events().is_empty() {
        return (Some(Fundamental::REST), Some(arcs));
    }
    let Some(near) = near.or_else(|| leading(at)).filter(|f| f.value.norm() > 0.0) else {
        return (None, Some(arcs));
    };
    let (value, states) = orbit.harmonic_counted(1);
    let arcs = arcs.saturating_add(states / STATES_OF_ARC);
    (Some(Fundamental { value, regime: Regime::ManyTurns, ..near }), Some(arcs))
}

/// Number of arcs that take as long as the integral for the fundamental over one arc.
fn quadrature(at: &Point) -> u64 {
    ARCS_OF_QUADRATURE.saturating_mul(((at.omega / at.omega_0 / SMALL_RESPONSE) as u64).saturating_add(1))
}

/// The orbit that is reached from rest or, if none is reached, from some other start.
fn orbit(at: &Point, from_rest: bool) -> Option<PeriodicOrbit> {
    let oscillator = Oscillator::kinematic(at.omega_0, at.delta.max(0.0), at.x_f).ok()?;
    let drive = HarmonicDrive::new(at.x_0, at.omega).ok()?;
    let options = OrbitOptions {
        start: from_rest.then_some((0.0, 0.0)),
        max_cycles: MOST_CYCLES,
        ..OrbitOptions::default()
    };
    PeriodicOrbit::find(&oscillator, &drive, options).ok()
}

#[cfg(test)]
mod tests {
    use super::super::{Phasor, solve};
    use super::*;

    fn point(r: f64, q: f64, beta: f64) -> Point {
        let omega = r * 2.0;
        let x_f = beta * PI / 4.0 * 0.3;
        Point { omega, omega_0: 2.0, detuning: omega - 2.0, delta: 1.0 / q, x_0: 0.3, x_f }
    }

    fn reference(at: &Point) -> Option<Phasor> {
        let o = Oscillator::kinematic(at.omega_0, at.delta, at.x_f).unwrap();
        solve(&o, &HarmonicDrive::new(at.x_0, at.omega).unwrap()).ok().map(|s| s.state.harmonic(1))
    }

    /// Grid over flanks, stops and sticking.
    fn grid() -> Vec<Point> {
        let mut all = Vec::new();
        for r in [0.23, 0.4, 0.62, 0.8, 0.9, 0.97, 0.999, 1.0, 1.004, 1.05, 1.2, 1.7, 2.6] {
            for q in [2.0, 5.0, 50.0, 1000.0] {
                for beta in [0.0, 0.05, 0.3, 0.8, 0.95, 1.1] {
                    all.push(point(r, q, beta));
                }
            }
        }
        all
    }

    #[test]
    fn numbers_that_are_none_have_no_motion() {
        let good = point(0.9, 5.0, 0.8);
        for none in [f64::NAN, f64::INFINITY] {
            for at in [
                Point { omega: none, ..good },
                Point { omega_0: none, ..good },
                Point { delta: none, ..good },
                Point { x_0: none, ..good },
                Point { x_f: none, ..good },
            ] {
                assert!(fundamental(&at).is_none(), "{at:?}");
            }
        }
    }

    #[test]
    fn it_is_the_motion_of_the_event_machine_everywhere() {
        let mut seen = [0usize; 5];
        for at in grid() {
            let Some(f) = fundamental(&at) else { panic!("{at:?}") };
            let truth = reference(&at).expect("damped");
            let error = (f.value - truth).norm() / truth.norm().max(1e-3 * at.x_0);
            assert!(error < 3e-9, "{at:?} {:?}: {} for {truth}, {error:e}", f.regime, f.value);
            seen[f.regime as usize] += 1;
        }
        assert!(seen[0] > 100, "{seen:?}");
        assert!(seen[1] > 30, "{seen:?}");
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        for at in grid() {
            let f = fundamental(&at).unwrap();
            let step = 1e-6;
            let check = |name: &str, by: Phasor, size: f64, moved: &dyn Fn(f64) -> Point| {
                let (up, down) = (fundamental(&moved(step * size)), fundamental(&moved(-step * size)));
                let (Some(up), Some(down)) = (up, down) else { return };
                // At the border of a regime the slope itself is discontinuous.
                if f.regime == Regime::ManyTurns || up.regime != f.regime || down.regime != f.regime {
                    return;
                }
                let numeric = (up.value - down.value) / (2.0 * step * size);
                let scale = (f.value.norm() / size).max(numeric.norm());
                let error = (by - numeric).norm() / scale.max(1e-9);
                assert!(error < 3e-5, "{name} {at:?} {:?}: {by} {numeric} {error:e}", f.regime);
            };
            let delta = at.delta;
            check("delta", f.by_delta, delta, &|s| Point { delta: at.delta + s, ..at });
            check("x_0", f.by_x_0, at.x_0, &|s| Point { x_0: at.x_0 + s, ..at });
            if at.x_f > 0.0 {
                check("x_f", f.by_x_f, at.x_f, &|s| Point { x_f: at.x_f + s, ..at });
            }
            check("omega_0", f.by_omega_0, delta, &|s| Point {
                omega_0: at.omega_0 + s,
                detuning: at.detuning - s,
                ..at
            });
            if let Some(f) = leading(&at).filter(|f| f.regime == Regime::Sliding) {
                let moved = |s: f64| Point { x_f: at.x_f + s, ..at };
                let size = 1e-6 * at.x_0;
                let numeric = (leading(&moved(size)).unwrap().value - leading(&moved(-size)).unwrap().value)
                    / (2.0 * size);
                assert!((f.by_x_f - numeric).norm() < 1e-4 * (1.0 + numeric.norm()), "{at:?}");
            }
        }
    }

    #[test]
    fn the_leading_term_is_that_of_eq_8() {
        let at = point(0.97, 50.0, 0.9);
        let o = Oscillator::kinematic(2.0, at.delta, at.x_f).unwrap();
        let drive = HarmonicDrive::new(at.x_0, at.omega).unwrap();
        let by_8 = super::super::leading::leading_amplitude(&o, &drive);
        assert!((leading(&at).unwrap().value.norm() - by_8).abs() < 1e-12);
    }

    #[test]
    fn friction_below_zero_continues_smoothly() {
        let at = Point { x_f: 0.0, ..point(0.99, 50.0, 0.0) };
        let here = fundamental(&at).unwrap();
        let below = fundamental(&Point { x_f: -1e-6, ..at }).unwrap();
        let foretold = here.value - here.by_x_f * 1e-6;
        assert!((below.value - foretold).norm() < 1e-9 * here.value.norm());
    }

    #[test]
    fn impossible_values_have_no_motion() {
        let at = point(1.0, 50.0, 0.5);
        for bad in [
            Point { delta: 3.0, ..at },
            Point { x_0: 0.0, ..at },
            Point { omega: f64::NAN, ..at },
            Point { delta: f64::NAN, ..at },
        ] {
            assert!(fundamental(&bad).is_none());
        }
    }

    /// `stops` integrates velocities and propagates derivatives; `one_stop` does neither.
    #[test]
    fn one_stop_is_the_motion_followed_from_stop_to_stop() {
        let (mut compared, mut warm) = (0, 0);
        for (q, beta) in [(2.0, 0.7), (5.0, 0.5), (5.0, 0.95), (50.0, 0.95), (50.0, 1.2)] {
            let (omega_0, delta) = (3.0, 1.5 / q);
            let mut near: Option<Slip> = None;
            let mut follower = Follower::default();
            for i in 0..200 {
                let omega = omega_0 * (0.35 + 0.01 * f64::from(i));
                let x_f = std::f64::consts::FRAC_PI_4 * beta * 0.2;
                let at = Point { omega, omega_0, detuning: omega - omega_0, delta, x_0: 0.2, x_f };
                let Some(f) = follower.fundamental(&at).filter(|f| f.regime == Regime::OneStop) else {
                    near = None;
                    continue;
                };
                let found = near.and_then(|n| one_stop::fundamental(&at, n, Accuracy::Fine));
                warm += usize::from(found.is_some());
                near = found.map(|f| f.1).or_else(|| {
                    (0..20).find_map(|k| {
                        Some(
                            one_stop::fundamental(
                                &at,
                                Slip::from_amplitude(&at, 0.02 * f64::from(k))?,
                                Accuracy::Fine,
                            )?
                            .1,
                        )
                    })
                });
                let (truth, _) = stops::fundamental(&at, f.value.norm(), &mut 0).unwrap();
                let pairs = [
                    (f.value, truth.value),
                    (f.by_omega_0, truth.by_omega_0),
                    (f.by_delta, truth.by_delta),
                    (f.by_x_0, truth.by_x_0),
                    (f.by_x_f, truth.by_x_f),
                ];
                for (k, (one, other)) in pairs.into_iter().enumerate() {
                    let error = (one - other).norm() / other.norm();
                    assert!(error < [1e-11, 1e-8][usize::from(k > 0)], "{at:?} {k}: {one} {other} {error:e}");
                }
                compared += 1;
            }
        }
        // The motion at the neighbouring frequency is nearly always a sufficient start value.
        assert!(compared > 500, "{warm} of {compared}");
        assert!(warm * 100 > 97 * compared, "{warm} of {compared}");
    }
}
