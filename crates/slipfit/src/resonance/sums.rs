//! Normal equations of a curve, many points at a time.
//!
//! The closed form is computed for a piece of the curve at once; points where the mass stops, or
//! where it might turn on the way, one by one.

use super::Method;
use super::block::Block;
use super::problem::{
    BG_IM, BG_RE, DELAY, DELTA, DRAG, DUFFING, MAIN, OMEGA, PHASE, Problem, Setting, X_0, X_F,
};
use crate::inference::least_squares::Normal;
use crate::motion::steady::Phasor;
use crate::motion::steady::closed::{Closed, Halves, NEVER_TURNS, closed_form, excess};
use crate::motion::steady::fundamental::{Follower, Point};
use crate::numeric::products::{Products, WIDTH};
use crate::numeric::trig;
use std::f64::consts::FRAC_PI_2;

/// Points computed together; real and imaginary parts fill a row.
const PIECE: usize = WIDTH / 2;
/// Parameters of the oscillator come first.
pub(super) const OWN: usize = PHASE;

type Row = [f64; PIECE];

/// Adds the sums of one block, times `factor`; `false` where the model does not exist or the sum
/// of squares exceeds `limit`.
pub(super) fn add(
    problem: &Problem,
    p: &[f64],
    reference: bool,
    factor: f64,
    limit: f64,
    out: &mut Normal,
) -> bool {
    let Some(block) = problem.block(reference) else { return true };
    let own = problem.columns(reference);
    let n = own.len();
    let at = problem.setting(p, reference);
    let pass = Pass {
        problem,
        block,
        own: &own,
        at,
        turn: Phasor::from_polar(1.0, at.phase),
        limit: limit / factor,
        products: Products::new(n + 1),
    };
    let Some(products) = pulp::Arch::new().dispatch(pass) else { return false };
    let slots = Problem::slots(reference);
    for a in 0..n {
        let i = slots[own[a]];
        out.jtr[i] += factor * products.total(n, a);
        for c in 0..=a {
            let j = slots[own[c]];
            out.jtj[(i.max(j), i.min(j))] += factor * products.total(a, c);
        }
    }
    let rss = products.total(n, n);
    out.rss += factor * rss;
    rss.is_finite()
}

struct Pass<'a> {
    problem: &'a Problem,
    block: &'a Block,
    own: &'a [usize],
    at: Setting,
    /// By the phase offset.
    turn: Phasor,
    limit: f64,
    products: Products<{ MAIN + 1 }>,
}

/// Points in use, the last repeated with weight zero to fill the piece.
struct Points {
    count: usize,
    index: [usize; PIECE],
    omega: Row,
    re: Row,
    im: Row,
    /// Root of the weight.
    root: Row,
    /// Every weight is one.
    even: bool,
    level: Row,
    /// Amplitude measured, where it says which branch is meant.
    guess: Row,
}

/// The oscillator at the points of a piece.
struct Lanes {
    re: Row,
    im: Row,
    by_re: [Row; OWN],
    by_im: [Row; OWN],
    /// At least zero where the closed form is the motion.
    sure: Row,
}

impl pulp::WithSimd for Pass<'_> {
    type Output = Option<Products<{ MAIN + 1 }>>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        if const { trig::has_fused::<S>() } { self.sums::<true>() } else { self.sums::<false>() }
    }
}

impl Pass<'_> {
    #[inline(always)]
    fn sums<const FUSED: bool>(mut self) -> Option<Products<{ MAIN + 1 }>> {
        let mut points = Points {
            count: 0,
            index: [0; PIECE],
            omega: [0.0; PIECE],
            re: [0.0; PIECE],
            im: [0.0; PIECE],
            root: [0.0; PIECE],
            even: false,
            level: [1.0; PIECE],
            guess: [0.0; PIECE],
        };
        let mut lanes = Lanes {
            re: [0.0; PIECE],
            im: [0.0; PIECE],
            by_re: [[0.0; PIECE]; OWN],
            by_im: [[0.0; PIECE]; OWN],
            sure: [f64::NAN; PIECE],
        };
        let mut follower = Follower::default();
        let n = self.own.len();
        let mut next = 0;
        loop {
            next = points.gather(self.block, &self.at, next);
            if points.count == 0 {
                return Some(self.products);
            }
            if self.problem.method == Method::Leading {
                lanes.sure = [f64::NAN; PIECE];
            } else if self.at.amplitude_dependent {
                lanes.amplitude_dependent::<FUSED>(&self.at, &points);
            } else if points.near(&self.at) {
                lanes.closed::<FUSED, true>(&self.at, &points);
            } else {
                lanes.closed::<FUSED, false>(&self.at, &points);
            }
            if !lanes.sure.iter().fold(true, |all, s| all & (*s >= 0.0)) {
                for k in 0..points.count {
                    if !(lanes.sure[k] >= 0.0) {
                        single(self.problem, &self.at, &points, k, &mut follower, &mut lanes)?;
                    }
                }
            }
            for k in points.count..PIECE {
                lanes.repeat(k);
            }
            self.rows(&points, &mut lanes);
            if self.block.complex {
                self.products.add::<FUSED>();
            } else {
                self.products.add_halves::<FUSED>();
            }
            if self.limit < f64::INFINITY && self.products.total(n, n) > self.limit {
                return None;
            }
        }
    }
}

/// One point by the way that takes any motion.
#[inline(never)]
fn single(
    problem: &Problem,
    at: &Setting,
    points: &Points,
    k: usize,
    follower: &mut Follower,
    lanes: &mut Lanes,
) -> Option<()> {
    let mut by = [Phasor::default(); OWN];
    let point = at.point(points.omega[k], points.level[k]);
    let f = problem.oscillator(at, &point, points.guess[k], follower, &mut by)?;
    (lanes.re[k], lanes.im[k]) = (f.value.re, f.value.im);
    for (j, d) in by.iter().enumerate() {
        (lanes.by_re[j][k], lanes.by_im[j][k]) = (d.re, d.im);
    }
    Some(())
}

impl Points {
    #[inline(always)]
    fn gather(&mut self, b: &Block, at: &Setting, from: usize) -> usize {
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
    fn near(&self, at: &Setting) -> bool {
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
fn turns<const FUSED: bool, const SHORT: bool>(point: &Point) -> (f64, Halves) {
    let over_omega = 1.0 / point.omega;
    let (sin, cos) = trig::quarter_turns::<FUSED, SHORT>(excess(point) * over_omega);
    let angle = FRAC_PI_2 * (point.delta * over_omega);
    let sinh = trig::small_sinh::<FUSED, SHORT>(angle);
    (over_omega, Halves { sin, cos, sinh, cosh: trig::small_cosh::<FUSED, SHORT>(angle) })
}

/// The closed form where these series hold; the second is no number elsewhere.
#[inline(always)]
fn quick(point: &Point, (over_omega, halves): (f64, Halves)) -> (Closed, f64) {
    let c = closed_form(point, over_omega, halves);
    let series = point.delta.abs() * over_omega <= 1.0;
    // Without friction below zero there is a motion whatever the turn looks like.
    let moves = if point.x_f > 0.0 { c.push(point.x_f) } else { c.turned() };
    let keeps = point.x_f <= 0.0 || point.omega > NEVER_TURNS * point.omega_0;
    let sure = if series & keeps { moves } else { f64::NAN };
    (c, sure)
}

impl Lanes {
    #[inline(always)]
    fn closed<const FUSED: bool, const SHORT: bool>(&mut self, at: &Setting, points: &Points) {
        // Two loops: divisions of one group of lanes go on beside the series of the next.
        let mut over_omega = [0.0; PIECE];
        let mut halves = [[0.0; PIECE]; 4];
        for k in 0..PIECE {
            let (over, h) = turns::<FUSED, SHORT>(&at.point(points.omega[k], points.level[k]));
            over_omega[k] = over;
            (halves[0][k], halves[1][k], halves[2][k], halves[3][k]) = (h.sin, h.cos, h.sinh, h.cosh);
        }
        for k in 0..PIECE {
            let h = Halves { sin: halves[0][k], cos: halves[1][k], sinh: halves[2][k], cosh: halves[3][k] };
            let (c, sure) = quick(&at.point(points.omega[k], points.level[k]), (over_omega[k], h));
            self.put(k, &c, sure);
        }
    }

    #[inline(always)]
    fn put(&mut self, k: usize, c: &Closed, sure: f64) {
        (self.re[k], self.im[k], self.sure[k]) = (c.value.re, c.value.im, sure);
        for j in 0..4 {
            (self.by_re[j][k], self.by_im[j][k]) = (c.by[j].re, c.by[j].im);
        }
    }

    /// With drag and lean: Newton's method for the amplitude at all points at once.
    #[inline(always)]
    fn amplitude_dependent<const FUSED: bool>(&mut self, at: &Setting, points: &Points) {
        const MOST: usize = 8;
        let mut r = points.guess;
        let mut next = r;
        let mut gap = [0.0; PIECE];
        let (mut turn_re, mut turn_im) = ([0.0; PIECE], [0.0; PIECE]);
        let over_centre = 1.0 / at.centre;
        for round in 0..MOST {
            for k in 0..PIECE {
                let plain = at.point(points.omega[k], points.level[k]);
                let lean = at.duffing * r[k] * r[k];
                let drag = at.drag * (points.omega[k] * over_centre);
                let point = Point {
                    delta: plain.delta + drag * r[k],
                    omega_0: plain.omega_0 + lean,
                    detuning: plain.detuning - lean,
                    ..plain
                };
                let (c, sure) = quick(&point, turns::<FUSED, false>(&point));
                let damped = (lean.abs() <= 0.5 * plain.omega_0) & (point.delta.abs() < point.omega_0);
                self.put(k, &c, if damped { sure } else { f64::NAN });
                let m = (c.value.re * c.value.re + c.value.im * c.value.im).sqrt();
                let over_m = if m > 0.0 { 1.0 / m } else { 0.0 };
                let z_r = c.by[DELTA] * drag + c.by[OMEGA] * (2.0 * at.duffing * r[k]);
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
                open |= (gap[k] > 1e-12) & !self.sure[k].is_nan();
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
            (self.by_re[DUFFING][k], self.by_im[DUFFING][k]) =
                (by_omega_0[0] * square, by_omega_0[1] * square);
            self.sure[k] = if gap[k] <= 1e-9 { self.sure[k] } else { f64::NAN };
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

    /// Fills a lane without a point with numbers.
    #[inline(always)]
    fn repeat(&mut self, k: usize) {
        (self.re[k], self.im[k]) = (0.0, 0.0);
        for j in 0..OWN {
            (self.by_re[j][k], self.by_im[j][k]) = (0.0, 0.0);
        }
    }
}

/// At a fold the root is double; a bounded slope keeps the step finite.
#[inline(always)]
pub(super) fn bounded(gain: f64) -> f64 {
    let least = if gain < 0.0 { -0.02 } else { 0.02 };
    if gain.abs() < 0.02 { least } else { gain }
}

impl Pass<'_> {
    /// Instrument terms, residuals, and the rows of the Jacobian.
    #[inline(always)]
    fn rows(&mut self, points: &Points, lanes: &mut Lanes) {
        let at = &self.at;
        for k in 0..PIECE {
            lanes.by_re[X_0][k] *= points.level[k];
            lanes.by_im[X_0][k] *= points.level[k];
        }
        if let Some([through, scale]) = at.ratio {
            for k in 0..PIECE {
                lanes.by_re[X_0][k] += lanes.by_re[X_F][k] * through;
                lanes.by_im[X_0][k] += lanes.by_im[X_F][k] * through;
                lanes.by_re[X_F][k] *= scale;
                lanes.by_im[X_F][k] *= scale;
            }
        }
        // Phases do not matter to products: rather than the model, the data are turned, back.
        let (mut cos, mut sin) = ([self.turn.re; PIECE], [self.turn.im; PIECE]);
        if at.delay != 0.0 {
            for k in 0..PIECE {
                (sin[k], cos[k]) = trig::sin_cos(at.phase - (points.omega[k] - at.centre) * at.delay);
            }
        }
        // What meets the oscillator before the delay turns with the phase offset alone.
        let (across, along) =
            if at.background_delayed { ([self.turn.re; PIECE], [self.turn.im; PIECE]) } else { (cos, sin) };
        let (mut ground_re, mut ground_im) = ([0.0; PIECE], [0.0; PIECE]);
        let (x, y) = (at.background.re, at.background.im);
        for k in 0..PIECE {
            ground_re[k] = x * across[k] + y * along[k];
            ground_im[k] = y * across[k] - x * along[k];
        }
        let background_delayed = if at.background_delayed { 1.0 } else { 0.0 };
        let n = self.own.len();
        let rows = &mut self.products.rows;
        for (row, &j) in rows.iter_mut().zip(self.own) {
            let [re, im] = halves(row);
            for k in 0..PIECE {
                (re[k], im[k]) = match j {
                    PHASE => (-lanes.im[k], lanes.re[k]),
                    DELAY => {
                        let t = points.omega[k] - at.centre;
                        (
                            (lanes.im[k] + background_delayed * ground_im[k]) * t,
                            -(lanes.re[k] + background_delayed * ground_re[k]) * t,
                        )
                    }
                    BG_RE => (across[k], -along[k]),
                    BG_IM => (along[k], across[k]),
                    _ => (lanes.by_re[j][k], lanes.by_im[j][k]),
                };
            }
        }
        if self.block.complex {
            for row in rows[..n].iter_mut().filter(|_| !points.even) {
                let [re, im] = halves(row);
                for k in 0..PIECE {
                    re[k] *= points.root[k];
                    im[k] *= points.root[k];
                }
            }
            let [re, im] = halves(&mut rows[n]);
            for k in 0..PIECE {
                let (x, y) = (points.re[k], points.im[k]);
                re[k] = (x * cos[k] + y * sin[k] - ground_re[k] - lanes.re[k]) * points.root[k];
                im[k] = (y * cos[k] - x * sin[k] - ground_im[k] - lanes.im[k]) * points.root[k];
            }
            return;
        }
        for k in 0..PIECE {
            lanes.re[k] += ground_re[k];
            lanes.im[k] += ground_im[k];
        }
        let (mut along_re, mut along_im) = ([0.0; PIECE], [0.0; PIECE]);
        let mut read = [0.0; PIECE];
        let noisy = self.block.rice > 0.0;
        for k in 0..PIECE {
            let size = (lanes.re[k] * lanes.re[k] + lanes.im[k] * lanes.im[k]).sqrt();
            read[k] = size;
            let over = if size > 0.0 { 1.0 / size } else { 0.0 };
            (along_re[k], along_im[k]) = (lanes.re[k] * over, lanes.im[k] * over);
        }
        if noisy {
            for k in 0..PIECE {
                let size = read[k];
                read[k] = self.block.read(size, points.index[k]);
                // d read/d size; the excess hardly moves with it.
                let slope = size / read[k];
                along_re[k] *= slope;
                along_im[k] *= slope;
            }
        }
        for row in &mut rows[..n] {
            let [re, im] = halves(row);
            for k in 0..PIECE {
                re[k] = (along_re[k] * re[k] + along_im[k] * im[k]) * points.root[k];
            }
        }
        for k in 0..PIECE {
            rows[n][k] = (points.re[k] - read[k]) * points.root[k];
        }
    }
}

#[inline(always)]
fn halves(row: &mut [f64; WIDTH]) -> [&mut [f64]; 2] {
    let (re, im) = row.split_at_mut(PIECE);
    [re, im]
}
