//! The oscillator at many points of a curve at once.
//!
//! The closed form is computed for a piece of the curve at once; points where the mass stops, or where it might turn
//! within a half cycle, are computed one by one.

use super::Method;
use super::block::Block;
use super::response::{DELTA, DRAG, DUFFING, ModelResponse, OMEGA, OWN};
use crate::motion::steady::Phasor;
use crate::motion::steady::closed::{Closed, Halves, NEVER_TURNS, closed_form, excess};
use crate::motion::steady::fundamental::{Follower, GROUP, Group, GroupResponse, Point, Slips};
use crate::numeric::products::WIDTH;
use crate::numeric::trig;
use std::f64::consts::FRAC_PI_2;

/// Number of points computed together; real and imaginary parts fill a row.
pub(super) const PIECE: usize = WIDTH / 2;

pub(super) type Row = [f64; PIECE];

/// Points in use; the last one is repeated with weight zero to fill the piece.
pub(super) struct Points {
    pub(super) count: usize,
    pub(super) index: [usize; PIECE],
    pub(super) omega: Row,
    pub(super) re: Row,
    pub(super) im: Row,
    /// Square root of the weight.
    pub(super) root_weight: Row,
    /// Whether every weight is one.
    pub(super) unit_weights: bool,
    pub(super) level: Row,
    /// Measured amplitude, which selects the branch.
    guess: Row,
}

/// Amplitudes on which the response at a piece depends, and their effect on its derivatives.
struct OwnAmplitudes {
    r: Row,
    turn_re: Row,
    turn_im: Row,
}

impl OwnAmplitudes {
    #[inline(always)]
    fn new(points: &Points) -> Self {
        Self { r: points.guess, turn_re: [0.0; PIECE], turn_im: [0.0; PIECE] }
    }
}

/// Oscillators evaluated at their amplitudes.
struct MovedOscillators<const N: usize> {
    omega_0: [f64; N],
    detuning: [f64; N],
    delta: [f64; N],
    x_0: [f64; N],
    /// Change of the decay rate with the amplitude.
    slope: [f64; N],
}

impl<const N: usize> MovedOscillators<N> {
    #[inline(always)]
    fn new() -> Self {
        let zero = [0.0; N];
        Self { omega_0: zero, detuning: zero, delta: zero, x_0: zero, slope: zero }
    }

    /// At frequencies and relative drives, at amplitudes `r`.
    #[inline(always)]
    fn fill(&mut self, at: &ModelResponse, omega: &[f64; N], level: &[f64; N], r: &[f64; N]) {
        let over_centre = 1.0 / at.centre;
        for k in 0..N {
            let plain = at.point(omega[k], level[k]);
            let (point, slope) = at.at_amplitude(&plain, r[k], over_centre);
            (self.omega_0[k], self.detuning[k], self.delta[k]) = (point.omega_0, point.detuning, point.delta);
            (self.x_0[k], self.slope[k]) = (point.x_0, slope);
        }
        if at.with_further {
            for k in 0..N {
                let damping = ModelResponse::further_damping(r[k], omega[k] * over_centre);
                let [rate, slope] = at.further_rate(&damping);
                self.delta[k] += rate;
                self.slope[k] += slope;
            }
        }
    }

    #[inline(always)]
    fn at(&self, k: usize, omega: f64, x_f: f64) -> Point {
        Point {
            omega,
            omega_0: self.omega_0[k],
            detuning: self.detuning[k],
            delta: self.delta[k],
            x_0: self.x_0[k],
            x_f,
        }
    }
}

/// Smallest number of points for which a group is faster than single points.
const LEAST_OF_GROUP: usize = 2;

/// The oscillator at the points of a piece.
pub(super) struct Lanes {
    pub(super) re: Row,
    pub(super) im: Row,
    pub(super) by_re: [Row; OWN],
    pub(super) by_im: [Row; OWN],
    /// Not negative where the closed form is valid.
    margin: Row,
}

impl Points {
    pub(super) fn new() -> Self {
        Self {
            count: 0,
            index: [0; PIECE],
            omega: [0.0; PIECE],
            re: [0.0; PIECE],
            im: [0.0; PIECE],
            root_weight: [0.0; PIECE],
            unit_weights: false,
            level: [1.0; PIECE],
            guess: [0.0; PIECE],
        }
    }

    /// Takes the next points of a block, starting at `from`, and returns where to continue.
    #[inline(always)]
    pub(super) fn gather(&mut self, b: &Block, at: &ModelResponse, from: usize) -> usize {
        let whole = from..from + PIECE;
        let piece = b.weight.get(whole.clone());
        self.unit_weights = piece.is_some_and(|w| w.iter().fold(true, |all, w| all & (*w == 1.0)));
        let next =
            if self.unit_weights || piece.is_some_and(|w| w.iter().fold(true, |all, w| all & (*w > 0.0))) {
                self.gather_all(b, from);
                whole.end
            } else {
                self.gather_weighted(b, from)
            };
        if !self.unit_weights {
            for k in 0..PIECE {
                self.root_weight[k] = self.root_weight[k].sqrt();
            }
        }
        if at.amplitude_dependent {
            for k in 0..PIECE {
                let background = at.background_at(self.omega[k]);
                let (re, im) = (self.re[k] - background.re, self.im[k] - background.im);
                let seen = if b.complex {
                    (re * re + im * im).sqrt()
                } else {
                    at.amplitude_from_reading(self.re[k])
                };
                self.guess[k] = seen.max(0.0);
            }
        }
        next
    }

    /// Whether short series are sufficient; the points are in order of increasing frequency, and `omega_d/omega`
    /// decreases.
    #[inline(always)]
    fn short_series_suffice(&self, at: &ModelResponse) -> bool {
        [0, PIECE - 1].into_iter().all(|k| {
            let point = at.point(self.omega[k], self.level[k]);
            let limit = trig::SHORT_OF_A_QUARTER * point.omega;
            excess(&point).abs() < limit && point.delta.abs() < limit
        })
    }

    /// A piece in which every point is in use.
    #[inline(always)]
    fn gather_all(&mut self, b: &Block, from: usize) {
        let whole = from..from + PIECE;
        self.count = PIECE;
        self.omega.copy_from_slice(&b.omega[whole.clone()]);
        self.level.copy_from_slice(&b.drive[whole.clone()]);
        self.root_weight.copy_from_slice(&b.weight[whole.clone()]);
        for (k, z) in b.data[whole].iter().enumerate() {
            (self.re[k], self.im[k], self.index[k]) = (z.re, z.im, from + k);
        }
    }

    /// Takes the next points in use and returns where to continue.
    fn gather_weighted(&mut self, b: &Block, from: usize) -> usize {
        let mut i = from;
        let mut k = 0;
        while k < PIECE && i < b.len() {
            if b.weight[i] > 0.0 {
                self.index[k] = i;
                self.omega[k] = b.omega[i];
                self.level[k] = b.drive[i];
                (self.re[k], self.im[k]) = (b.data[i].re, b.data[i].im);
                self.root_weight[k] = b.weight[i];
                k += 1;
            }
            i += 1;
        }
        self.count = k;
        for k in k..PIECE {
            let last = self.count.max(1) - 1;
            self.omega[k] = self.omega[last];
            self.level[k] = self.level[last];
            (self.re[k], self.im[k], self.root_weight[k]) = (0.0, 0.0, 0.0);
        }
        i
    }
}

/// Range of validity of the series of the angles and the decay.
const SHORT: u8 = 0;
/// For decay rates up to the frequency.
const MEDIUM: u8 = 1;
/// For all decay rates up to a limit.
const WIDE: u8 = 2;

/// Ratio of the decay rate to the frequency up to which [`WIDE`] is valid.
const WIDEST: f64 = 100.0;

/// `1/omega` and the functions of the angles in the closed form, computed by series.
#[inline(always)]
fn half_angles<const FUSED: bool, const REACH: u8>(point: &Point) -> (f64, Halves) {
    let over_omega = 1.0 / point.omega;
    let excess = excess(point) * over_omega;
    let angle = FRAC_PI_2 * (point.delta * over_omega);
    let halves = if REACH == SHORT {
        let (sin, cos) = trig::quarter_turns::<FUSED, true>(excess);
        let sinh = trig::small_sinh::<FUSED, true>(angle);
        Halves { sin, cos, sinh, cosh: trig::small_cosh::<FUSED, true>(angle) }
    } else {
        let (sin, cos) = trig::quarter_turns::<FUSED, false>(excess);
        let (sinh, cosh) = if REACH == WIDE {
            trig::sinh_cosh::<FUSED>(angle)
        } else {
            (trig::small_sinh::<FUSED, false>(angle), trig::small_cosh::<FUSED, false>(angle))
        };
        Halves { sin, cos, sinh, cosh }
    };
    (over_omega, halves)
}

/// The closed form where these series are valid; elsewhere the second value is not finite.
#[inline(always)]
fn closed_by_series<const REACH: u8>(point: &Point, (over_omega, halves): (f64, Halves)) -> (Closed, f64) {
    let c = closed_form(point, over_omega, halves);
    let series = point.delta.abs() * over_omega <= if REACH == WIDE { WIDEST } else { 1.0 };
    // If the friction is not positive, there is a motion regardless of the turning condition.
    let moves = if point.x_f > 0.0 { c.push(point.x_f) } else { c.turned() };
    let keeps = point.x_f <= 0.0 || point.omega > NEVER_TURNS * point.omega_0;
    // If the turning condition has no value, there is no turn, whatever the frequency.
    let moves = if (point.x_f > 0.0) & moves.is_nan() { -1.0 } else { moves };
    let margin = if series & (keeps | (moves < 0.0)) { moves } else { f64::NAN };
    (c, margin)
}

impl Lanes {
    pub(super) fn new() -> Self {
        Self {
            re: [0.0; PIECE],
            im: [0.0; PIECE],
            by_re: [[0.0; PIECE]; OWN],
            by_im: [[0.0; PIECE]; OWN],
            margin: [f64::NAN; PIECE],
        }
    }

    /// The oscillator at every point, and its derivatives; `None` if it has no motion at some point.
    #[inline(always)]
    pub(super) fn respond<const FUSED: bool>(
        &mut self,
        at: &ModelResponse,
        points: &Points,
        follower: &mut Follower,
    ) -> Option<()> {
        let mut own = OwnAmplitudes::new(points);
        if at.method == Method::Leading {
            self.margin = [f64::NAN; PIECE];
        } else if at.amplitude_dependent {
            follower.count_closed(self.at_own_amplitude::<FUSED>(at, points, &mut own) * PIECE as u64);
        } else if points.short_series_suffice(at) {
            self.closed::<FUSED, SHORT>(at, points);
        } else if at.delta.abs() <= points.omega[0] {
            self.closed::<FUSED, MEDIUM>(at, points);
        } else {
            self.closed::<FUSED, WIDE>(at, points);
        }
        if at.x_f > 0.0 && !at.amplitude_dependent {
            self.set_resting(at, points);
        }
        let all_closed = self.all_closed();
        if !all_closed && at.x_f > 0.0 && at.method != Method::Leading {
            for first in (0..points.count).step_by(GROUP) {
                if follower.is_spent() {
                    return None;
                }
                self.one_stop_motions(at, points, first, &mut own, follower)?;
            }
        }
        if at.amplitude_dependent && at.method != Method::Leading {
            self.convert_to_total_derivatives(at, points, &own);
        }
        if !all_closed {
            for k in 0..points.count {
                if !(self.margin[k] >= 0.0) {
                    self.single(at, points, k, follower)?;
                }
            }
        }
        for k in points.count..PIECE {
            self.clear(k);
        }
        Some(())
    }

    /// Points at which the drive cannot overcome friction.
    #[inline(always)]
    fn set_resting(&mut self, at: &ModelResponse, points: &Points) {
        for k in 0..PIECE {
            let drive = at.x_0 * points.level[k];
            if self.margin[k] < 0.0 && drive > 0.0 && drive <= at.x_f {
                self.clear(k);
                self.margin[k] = 0.0;
            }
        }
    }

    fn all_closed(&self) -> bool {
        self.margin.iter().fold(true, |all, m| all & (*m >= 0.0))
    }

    /// Motions with one stop per half cycle at those points of a group that have no closed form.
    #[inline(always)]
    fn one_stop_motions(
        &mut self,
        at: &ModelResponse,
        points: &Points,
        first: usize,
        own: &mut OwnAmplitudes,
        follower: &mut Follower,
    ) -> Option<()> {
        let mut wanted = [false; GROUP];
        for k in 0..GROUP {
            let i = first + k;
            wanted[k] = (i < points.count) & !(self.margin[i] >= 0.0) & (at.x_f < at.x_0 * points.level[i]);
        }
        if wanted.iter().filter(|w| **w).count() < LEAST_OF_GROUP {
            return Some(());
        }
        let omega: [f64; GROUP] = std::array::from_fn(|k| points.omega[first + k]);
        let slips = match follower.slips(&omega) {
            Some(slips) => slips,
            None => {
                // The first point is computed alone, the others from it.
                let k = first + wanted.iter().position(|w| *w).unwrap_or(0);
                self.single(at, points, k, follower)?;
                let Some(slips) = follower.slips(&omega) else { return Some(()) };
                slips
            }
        };
        self.settle_group(at, points, first, own, follower, (slips, wanted));
        Some(())
    }

    #[inline(always)]
    fn settle_group(
        &mut self,
        at: &ModelResponse,
        points: &Points,
        first: usize,
        own: &mut OwnAmplitudes,
        follower: &mut Follower,
        (mut slips, wanted): (Slips, [bool; GROUP]),
    ) {
        const MOST: usize = 16;
        let zero = [0.0; GROUP];
        let mut group =
            Group { omega: zero, omega_0: zero, detuning: zero, delta: zero, x_0: zero, x_f: zero };
        let mut out = GroupResponse { value: [zero; 2], by: [[zero; 2]; 4] };
        let mut level = zero;
        let (mut r, mut next, mut gap) = (zero, zero, zero);
        let (mut turn_re, mut turn_im) = (zero, zero);
        let mut found = [false; GROUP];
        r.copy_from_slice(&points.guess[first..first + GROUP]);
        level.copy_from_slice(&points.level[first..first + GROUP]);
        group.omega.copy_from_slice(&points.omega[first..first + GROUP]);
        group.x_f = [at.x_f; GROUP];
        let omega_0 = at.centre + at.shift;
        let rounds = if at.amplitude_dependent { MOST } else { 1 };
        for round in 0..rounds {
            let mut moved = MovedOscillators::<GROUP>::new();
            moved.fill(at, &group.omega, &level, &r);
            (group.omega_0, group.detuning, group.delta) = (moved.omega_0, moved.detuning, moved.delta);
            group.x_0 = moved.x_0;
            group.settle(&mut slips, &wanted);
            found = group.respond(&slips, follower.accuracy(), &mut out);
            follower.count_groups(1);
            if !at.amplitude_dependent {
                break;
            }
            let mut open = false;
            for k in 0..GROUP {
                let by = |j: usize| Phasor::new(out.by[j][0][k], out.by[j][1][k]);
                let value = Phasor::new(out.value[0][k], out.value[1][k]);
                let step = at.amplitude_step(r[k], moved.slope[k], value, [by(DELTA), by(OMEGA)]);
                (next[k], gap[k]) = (step.next, step.gap);
                (turn_re[k], turn_im[k]) = (step.turn.re, step.turn.im);
                open |= wanted[k] & (step.gap > 1e-12);
            }
            if !open || round + 1 == MOST {
                break;
            }
            for k in 0..GROUP {
                r[k] = if gap[k] > 1e-12 { next[k] } else { r[k] };
            }
        }
        for k in 0..GROUP {
            let damped = ModelResponse::is_damped(omega_0, group.omega_0[k], group.delta[k]);
            found[k] &= wanted[k] & damped & (gap[k] <= 1e-9);
        }
        for k in (0..GROUP).filter(|&k| found[k]) {
            let i = first + k;
            (self.re[i], self.im[i], self.margin[i]) = (out.value[0][k], out.value[1][k], 0.0);
            for j in 0..4 {
                (self.by_re[j][i], self.by_im[j][i]) = (out.by[j][0][k], out.by[j][1][k]);
            }
            (own.r[i], own.turn_re[i], own.turn_im[i]) = (r[k], turn_re[k], turn_im[k]);
        }
        follower.follow(&group.omega, &slips, &found);
    }

    /// Computes one point by the method that is valid for any motion.
    #[inline(never)]
    fn single(
        &mut self,
        at: &ModelResponse,
        points: &Points,
        k: usize,
        follower: &mut Follower,
    ) -> Option<()> {
        let mut by = [Phasor::default(); OWN];
        let point = at.point(points.omega[k], points.level[k]);
        let f = at.oscillator(&point, points.guess[k], follower, &mut by)?;
        (self.re[k], self.im[k]) = (f.value.re, f.value.im);
        for (j, d) in by.iter().enumerate() {
            (self.by_re[j][k], self.by_im[j][k]) = (d.re, d.im);
        }
        Some(())
    }

    #[inline(always)]
    fn closed<const FUSED: bool, const REACH: u8>(&mut self, at: &ModelResponse, points: &Points) {
        // Two loops, so that the divisions of one group of lanes overlap with the series of the next.
        let mut over_omega = [0.0; PIECE];
        let mut halves = [[0.0; PIECE]; 4];
        for k in 0..PIECE {
            let (over, h) = half_angles::<FUSED, REACH>(&at.point(points.omega[k], points.level[k]));
            over_omega[k] = over;
            (halves[0][k], halves[1][k], halves[2][k], halves[3][k]) = (h.sin, h.cos, h.sinh, h.cosh);
        }
        for k in 0..PIECE {
            let h = Halves { sin: halves[0][k], cos: halves[1][k], sinh: halves[2][k], cosh: halves[3][k] };
            let (c, margin) =
                closed_by_series::<REACH>(&at.point(points.omega[k], points.level[k]), (over_omega[k], h));
            self.put(k, &c, margin);
        }
    }

    #[inline(always)]
    fn put(&mut self, k: usize, c: &Closed, margin: f64) {
        (self.re[k], self.im[k], self.margin[k]) = (c.value.re, c.value.im, margin);
        for j in 0..4 {
            (self.by_re[j][k], self.by_im[j][k]) = (c.by[j].re, c.by[j].im);
        }
    }

    /// With drag and a Duffing term: Newton's method for the amplitude at all points at once; returns the number of
    /// steps.
    #[inline(always)]
    fn at_own_amplitude<const FUSED: bool>(
        &mut self,
        at: &ModelResponse,
        points: &Points,
        own: &mut OwnAmplitudes,
    ) -> u64 {
        const MOST: u64 = 24;
        let mut next = own.r;
        let mut gap = [0.0; PIECE];
        let omega_0 = at.centre + at.shift;
        let mut steps = 0;
        loop {
            let mut moved = MovedOscillators::<PIECE>::new();
            moved.fill(at, &points.omega, &points.level, &own.r);
            // Several loops, each of which is compiled to vector instructions.
            let mut over_omega = [0.0; PIECE];
            let mut halves = [[0.0; PIECE]; 4];
            for k in 0..PIECE {
                let (over, h) = half_angles::<FUSED, WIDE>(&moved.at(k, points.omega[k], at.x_f));
                over_omega[k] = over;
                (halves[0][k], halves[1][k], halves[2][k], halves[3][k]) = (h.sin, h.cos, h.sinh, h.cosh);
            }
            for k in 0..PIECE {
                let h =
                    Halves { sin: halves[0][k], cos: halves[1][k], sinh: halves[2][k], cosh: halves[3][k] };
                let (c, margin) =
                    closed_by_series::<WIDE>(&moved.at(k, points.omega[k], at.x_f), (over_omega[k], h));
                let damped = ModelResponse::is_damped(omega_0, moved.omega_0[k], moved.delta[k]);
                self.put(k, &c, if damped { margin } else { f64::NAN });
            }
            for k in 0..PIECE {
                let by = |j: usize| Phasor::new(self.by_re[j][k], self.by_im[j][k]);
                let value = Phasor::new(self.re[k], self.im[k]);
                let step = at.amplitude_step(own.r[k], moved.slope[k], value, [by(DELTA), by(OMEGA)]);
                (next[k], gap[k]) = (step.next, step.gap);
                (own.turn_re[k], own.turn_im[k]) = (step.turn.re, step.turn.im);
            }
            let mut open = false;
            for k in 0..PIECE {
                open |= (gap[k] > 1e-12) & !self.margin[k].is_nan();
            }
            if !open || steps + 1 == MOST {
                break;
            }
            steps += 1;
            for k in 0..PIECE {
                own.r[k] = if gap[k] > 1e-12 { next[k] } else { own.r[k] };
            }
        }
        for k in 0..PIECE {
            self.margin[k] = if gap[k] <= 1e-9 { self.margin[k] } else { f64::NAN };
        }
        steps
    }

    /// Converts derivatives at fixed amplitudes to total derivatives, with the amplitudes changing.
    #[inline(always)]
    fn convert_to_total_derivatives(&mut self, at: &ModelResponse, points: &Points, own: &OwnAmplitudes) {
        let over_centre = 1.0 / at.centre;
        for k in 0..PIECE {
            let r = own.r[k];
            let (by_delta, by_omega_0) =
                ([self.by_re[DELTA][k], self.by_im[DELTA][k]], [self.by_re[OMEGA][k], self.by_im[OMEGA][k]]);
            let drag = points.omega[k] * over_centre * r;
            let square = r * r;
            (self.by_re[DRAG][k], self.by_im[DRAG][k]) = (by_delta[0] * drag, by_delta[1] * drag);
            if at.with_further {
                let damping = ModelResponse::further_damping(r, points.omega[k] * over_centre);
                for (j, [d, _]) in damping.iter().enumerate() {
                    let j = DRAG + 1 + j;
                    (self.by_re[j][k], self.by_im[j][k]) = (by_delta[0] * d, by_delta[1] * d);
                }
            }
            (self.by_re[DUFFING][k], self.by_im[DUFFING][k]) =
                (by_omega_0[0] * square, by_omega_0[1] * square);
        }
        for j in 0..OWN {
            let (by_re, by_im) = (&mut self.by_re[j], &mut self.by_im[j]);
            for k in 0..PIECE {
                let along = self.re[k] * by_re[k] + self.im[k] * by_im[k];
                by_re[k] += own.turn_re[k] * along;
                by_im[k] += own.turn_im[k] * along;
            }
        }
    }

    /// Sets a lane without a point to zero.
    #[inline(always)]
    fn clear(&mut self, k: usize) {
        (self.re[k], self.im[k]) = (0.0, 0.0);
        for j in 0..OWN {
            (self.by_re[j][k], self.by_im[j][k]) = (0.0, 0.0);
        }
    }
}
