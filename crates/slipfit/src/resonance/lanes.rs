//! The oscillator at many points of a curve at a time.
//!
//! The closed form is computed for a piece of the curve at once; points where the mass stops, or
//! where it might turn on the way, one by one.

use super::Method;
use super::block::Block;
use super::response::{DELTA, DRAG, DUFFING, ModelResponse, OMEGA, OWN, bounded};
use crate::motion::steady::Phasor;
use crate::motion::steady::closed::{Closed, Halves, NEVER_TURNS, closed_form, excess};
use crate::motion::steady::fundamental::{Follower, Point};
use crate::numeric::products::WIDTH;
use crate::numeric::trig;
use std::f64::consts::FRAC_PI_2;

/// Points computed together; real and imaginary parts fill a row.
pub(super) const PIECE: usize = WIDTH / 2;

pub(super) type Row = [f64; PIECE];

/// Points in use, the last repeated with weight zero to fill the piece.
pub(super) struct Points {
    pub(super) count: usize,
    pub(super) index: [usize; PIECE],
    pub(super) omega: Row,
    pub(super) re: Row,
    pub(super) im: Row,
    /// Root of the weight.
    pub(super) root: Row,
    /// Every weight is one.
    pub(super) even: bool,
    pub(super) level: Row,
    /// Amplitude measured, where it says which branch is meant.
    guess: Row,
}

/// The oscillator at the points of a piece.
pub(super) struct Lanes {
    pub(super) re: Row,
    pub(super) im: Row,
    pub(super) by_re: [Row; OWN],
    pub(super) by_im: [Row; OWN],
    /// At least zero where the closed form is the motion.
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
            root: [0.0; PIECE],
            even: false,
            level: [1.0; PIECE],
            guess: [0.0; PIECE],
        }
    }

    /// Takes the next points of a block from `from` on, and says where to go on.
    #[inline(always)]
    pub(super) fn gather(&mut self, b: &Block, at: &ModelResponse, from: usize) -> usize {
        let whole = from..from + PIECE;
        let piece = b.weight.get(whole.clone());
        self.even = piece.is_some_and(|w| w.iter().fold(true, |all, w| all & (*w == 1.0)));
        let next = if self.even || piece.is_some_and(|w| w.iter().fold(true, |all, w| all & (*w > 0.0))) {
            self.whole(b, from);
            whole.end
        } else {
            self.in_use(b, from)
        };
        if !self.even {
            for k in 0..PIECE {
                self.root[k] = self.root[k].sqrt();
            }
        }
        if at.amplitude_dependent {
            for k in 0..PIECE {
                let background = at.background_at(self.omega[k]);
                let (re, im) = (self.re[k] - background.re, self.im[k] - background.im);
                self.guess[k] = if b.complex { (re * re + im * im).sqrt() } else { self.re[k].max(0.0) };
            }
        }
        next
    }

    /// Whether short series do: points go by rising frequency, and `omega_d/omega` falls.
    #[inline(always)]
    fn short_series_hold(&self, at: &ModelResponse) -> bool {
        [0, PIECE - 1].into_iter().all(|k| {
            let point = at.point(self.omega[k], self.level[k]);
            let limit = trig::SHORT_OF_A_QUARTER * point.omega;
            excess(&point).abs() < limit && point.delta.abs() < limit
        })
    }

    /// A piece of which every point is in use.
    #[inline(always)]
    fn whole(&mut self, b: &Block, from: usize) {
        let whole = from..from + PIECE;
        self.count = PIECE;
        self.omega.copy_from_slice(&b.omega[whole.clone()]);
        self.level.copy_from_slice(&b.drive[whole.clone()]);
        self.root.copy_from_slice(&b.weight[whole.clone()]);
        for (k, z) in b.data[whole].iter().enumerate() {
            (self.re[k], self.im[k], self.index[k]) = (z.re, z.im, from + k);
        }
    }

    /// The next points in use, and where to go on.
    fn in_use(&mut self, b: &Block, from: usize) -> usize {
        let mut i = from;
        let mut k = 0;
        while k < PIECE && i < b.len() {
            if b.weight[i] > 0.0 {
                self.index[k] = i;
                self.omega[k] = b.omega[i];
                self.level[k] = b.drive[i];
                (self.re[k], self.im[k]) = (b.data[i].re, b.data[i].im);
                self.root[k] = b.weight[i];
                k += 1;
            }
            i += 1;
        }
        self.count = k;
        for k in k..PIECE {
            let last = self.count.max(1) - 1;
            self.omega[k] = self.omega[last];
            self.level[k] = self.level[last];
            (self.re[k], self.im[k], self.root[k]) = (0.0, 0.0, 0.0);
        }
        i
    }
}

/// `1/omega` and what the closed form asks of the angles, by series.
#[inline(always)]
fn half_angles<const FUSED: bool, const SHORT: bool>(point: &Point) -> (f64, Halves) {
    let over_omega = 1.0 / point.omega;
    let (sin, cos) = trig::quarter_turns::<FUSED, SHORT>(excess(point) * over_omega);
    let angle = FRAC_PI_2 * (point.delta * over_omega);
    let sinh = trig::small_sinh::<FUSED, SHORT>(angle);
    (over_omega, Halves { sin, cos, sinh, cosh: trig::small_cosh::<FUSED, SHORT>(angle) })
}

/// The closed form where these series hold; the second value is not finite elsewhere.
#[inline(always)]
fn quick(point: &Point, (over_omega, halves): (f64, Halves)) -> (Closed, f64) {
    let c = closed_form(point, over_omega, halves);
    let series = point.delta.abs() * over_omega <= 1.0;
    // Without friction below zero there is a motion whatever the turn looks like.
    let moves = if point.x_f > 0.0 { c.push(point.x_f) } else { c.turned() };
    let keeps = point.x_f <= 0.0 || point.omega > NEVER_TURNS * point.omega_0;
    let margin = if series & keeps { moves } else { f64::NAN };
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

    /// The oscillator at every point, and its derivatives; `None` where it has no motion.
    #[inline(always)]
    pub(super) fn respond<const FUSED: bool>(
        &mut self,
        at: &ModelResponse,
        points: &Points,
        follower: &mut Follower,
    ) -> Option<()> {
        if at.method == Method::Leading {
            self.margin = [f64::NAN; PIECE];
        } else if at.amplitude_dependent {
            self.at_own_amplitude::<FUSED>(at, points);
        } else if points.short_series_hold(at) {
            self.closed::<FUSED, true>(at, points);
        } else {
            self.closed::<FUSED, false>(at, points);
        }
        if !self.margin.iter().fold(true, |all, m| all & (*m >= 0.0)) {
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

    /// One point by the method that takes any motion.
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
    fn closed<const FUSED: bool, const SHORT: bool>(&mut self, at: &ModelResponse, points: &Points) {
        // Two loops: divisions of one group of lanes go on beside the series of the next.
        let mut over_omega = [0.0; PIECE];
        let mut halves = [[0.0; PIECE]; 4];
        for k in 0..PIECE {
            let (over, h) = half_angles::<FUSED, SHORT>(&at.point(points.omega[k], points.level[k]));
            over_omega[k] = over;
            (halves[0][k], halves[1][k], halves[2][k], halves[3][k]) = (h.sin, h.cos, h.sinh, h.cosh);
        }
        for k in 0..PIECE {
            let h = Halves { sin: halves[0][k], cos: halves[1][k], sinh: halves[2][k], cosh: halves[3][k] };
            let (c, margin) = quick(&at.point(points.omega[k], points.level[k]), (over_omega[k], h));
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

    /// With drag and a Duffing term: Newton's method for the amplitude at all points at once.
    #[inline(always)]
    fn at_own_amplitude<const FUSED: bool>(&mut self, at: &ModelResponse, points: &Points) {
        const MOST: usize = 8;
        let mut r = points.guess;
        let mut next = r;
        let mut gap = [0.0; PIECE];
        let (mut turn_re, mut turn_im) = ([0.0; PIECE], [0.0; PIECE]);
        let over_centre = 1.0 / at.centre;
        for round in 0..MOST {
            for k in 0..PIECE {
                let plain = at.point(points.omega[k], points.level[k]);
                let shift = at.duffing * r[k] * r[k];
                let drag = at.drag * (points.omega[k] * over_centre);
                let [further, by_r] = if at.with_further {
                    let rate = points.omega[k] * over_centre;
                    at.further_rate(&ModelResponse::further_damping(r[k], rate))
                } else {
                    [0.0; 2]
                };
                let point = Point {
                    delta: plain.delta + drag * r[k] + further,
                    omega_0: plain.omega_0 + shift,
                    detuning: plain.detuning - shift,
                    ..plain
                };
                let (c, margin) = quick(&point, half_angles::<FUSED, false>(&point));
                let damped = (shift.abs() <= 0.5 * plain.omega_0) & (point.delta.abs() < point.omega_0);
                self.put(k, &c, if damped { margin } else { f64::NAN });
                let m = (c.value.re * c.value.re + c.value.im * c.value.im).sqrt();
                let over_m = if m > 0.0 { 1.0 / m } else { 0.0 };
                let z_r = c.by[DELTA] * (drag + by_r) + c.by[OMEGA] * (2.0 * at.duffing * r[k]);
                let slope = (c.value.re * z_r.re + c.value.im * z_r.im) * over_m;
                let gain = bounded(1.0 - slope);
                let step = (m - r[k]) / gain;
                let reach = 0.5 * (r[k] + m);
                gap[k] = (m - r[k]).abs() / r[k].max(m);
                let step = if step > reach { reach } else { step };
                let step = if step < -reach { -reach } else { step };
                next[k] = if r[k] + step > 0.0 { r[k] + step } else { 0.0 };
                let through = over_m / gain;
                (turn_re[k], turn_im[k]) = (z_r.re * through, z_r.im * through);
            }
            let mut open = false;
            for k in 0..PIECE {
                open |= (gap[k] > 1e-12) & !self.margin[k].is_nan();
            }
            if !open || round + 1 == MOST {
                break;
            }
            for k in 0..PIECE {
                r[k] = if gap[k] > 1e-12 { next[k] } else { r[k] };
            }
        }
        for k in 0..PIECE {
            let (by_delta, by_omega_0) =
                ([self.by_re[DELTA][k], self.by_im[DELTA][k]], [self.by_re[OMEGA][k], self.by_im[OMEGA][k]]);
            let drag = points.omega[k] * over_centre * r[k];
            let square = r[k] * r[k];
            (self.by_re[DRAG][k], self.by_im[DRAG][k]) = (by_delta[0] * drag, by_delta[1] * drag);
            if at.with_further {
                let damping = ModelResponse::further_damping(r[k], points.omega[k] * over_centre);
                for (j, [d, _]) in damping.iter().enumerate() {
                    let j = DRAG + 1 + j;
                    (self.by_re[j][k], self.by_im[j][k]) = (by_delta[0] * d, by_delta[1] * d);
                }
            }
            (self.by_re[DUFFING][k], self.by_im[DUFFING][k]) =
                (by_omega_0[0] * square, by_omega_0[1] * square);
            self.margin[k] = if gap[k] <= 1e-9 { self.margin[k] } else { f64::NAN };
        }
        for j in 0..OWN {
            let (by_re, by_im) = (&mut self.by_re[j], &mut self.by_im[j]);
            for k in 0..PIECE {
                let along = self.re[k] * by_re[k] + self.im[k] * by_im[k];
                by_re[k] += turn_re[k] * along;
                by_im[k] += turn_im[k] * along;
            }
        }
    }

    /// Zeros in a lane without a point.
    #[inline(always)]
    fn clear(&mut self, k: usize) {
        (self.re[k], self.im[k]) = (0.0, 0.0);
        for j in 0..OWN {
            (self.by_re[j][k], self.by_im[j][k]) = (0.0, 0.0);
        }
    }
}
