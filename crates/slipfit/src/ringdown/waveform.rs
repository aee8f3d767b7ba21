//! Every sample against the exact motion.
//!
//! The motion runs from turning point to turning point; between two of them it
//! is a damped cosine about `±x_F` (see [`FittedMotion`](super::FittedMotion)).
//! One pass over the samples gives the normal equations; nothing is stored.

use super::envelope::{A0, DELTA, Walker, X_F, by_parameters, law_of};
use crate::inference::least_squares::{LeastSquares, Normal};
use crate::numeric::trig;
use std::f64::consts::{FRAC_PI_2, PI};

/// Phase at the start, rad.
pub(crate) const PHASE: usize = 4;
/// Angular frequency at vanishing amplitude, rad/s.
pub(crate) const OMEGA: usize = 5;
/// Change of angular frequency per squared reference amplitude, rad/s per A².
pub(crate) const BEND: usize = 6;
/// Change of angular frequency with time, rad/s².
pub(crate) const CHIRP: usize = 7;
/// Offset, its slope and its curvature over the window.
pub(crate) const OFFSET: usize = 8;
pub(crate) const COUNT: usize = 12;

/// Samples gathered before their products are summed.
const BATCH: usize = 256;
/// Samples computed together.
const PIECE: usize = 64;

/// Integral of the squared amplitude along a reference decay, for the backbone.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bend {
    /// Even spacing of the knots, s.
    pub(crate) step: f64,
    /// Integral and its rate at the knots.
    pub(crate) knots: Vec<(f64, f64)>,
}

impl Bend {
    /// From an amplitude law over `[0, duration]`.
    pub(crate) fn along(amplitude: impl Fn(f64) -> f64, duration: f64) -> Self {
        let count = 512;
        let step = duration / (count - 1) as f64;
        let square = |t: f64| amplitude(t).powi(2);
        let mut sum = 0.0;
        let mut knots = Vec::with_capacity(count);
        for i in 0..count {
            let t = i as f64 * step;
            if i > 0 {
                sum += step / 6.0 * (square(t - step) + 4.0 * square(t - 0.5 * step) + square(t));
            }
            knots.push((sum, square(t)));
        }
        Self { step, knots }
    }

    /// Integral and rate at a time, extended with the end rates.
    #[inline(always)]
    fn at(&self, t: f64) -> (f64, f64) {
        let last = self.knots.len() - 1;
        let i = ((t / self.step).max(0.0) as usize).min(last - 1);
        let ((p, u), (q, v)) = (self.knots[i], self.knots[i + 1]);
        let d = t - i as f64 * self.step;
        if d < 0.0 {
            return (p + u * d, u);
        }
        let e = d - self.step;
        if e > 0.0 {
            return (q + v * e, v);
        }
        let h = self.step;
        let slope = (q - p) / h;
        let a = (slope - u) / h;
        let b = (u + v - 2.0 * slope) / (h * h);
        (p + d * (u + d * (a + b * e)), u + 2.0 * a * d + b * (2.0 * d * e + d * d))
    }
}

/// Samples of one window and the shape of the model.
#[derive(Debug, Clone)]
pub(crate) struct Waveform<'a> {
    pub(crate) time: &'a [f64],
    pub(crate) signal: &'a [f64],
    /// Start of the window, s; parameters refer to it.
    pub(crate) origin: f64,
    pub(crate) duration: f64,
    /// Shape of the backbone; `None` leaves [`BEND`] without effect.
    pub(crate) bend: Option<Bend>,
    /// Whether the place of rest tells which swing was the last. Where it does not, the samples
    /// at rest have a level of their own: that level lies anywhere within `±x_F`, and its
    /// derivative by the loss holds over no step a fit could take.
    pub(crate) rest_tells: bool,
    /// Parameters whose derivatives are wanted.
    pub(crate) active: Vec<usize>,
}

/// Whether friction of this displacement leaves the mass at a place that tells the last swing:
/// swings end `2 x_F` apart, and the last one is known to some three standard errors of an
/// amplitude from all `n` samples shared by six parameters.
pub(crate) fn rest_tells(x_f: f64, noise_rms: f64, n: usize) -> bool {
    x_f > 8.0 * noise_rms * (12.0 / n.max(1) as f64).sqrt()
}

impl Waveform<'_> {
    /// Phase and its rate, and the shape functions of the phase parameters.
    #[inline(always)]
    fn phase(&self, p: &[f64], t: f64) -> (f64, f64, [f64; 4]) {
        let (i, r) = self.bend.as_ref().map_or((0.0, 0.0), |b| b.at(t));
        (
            p[PHASE] + p[OMEGA] * t + p[BEND] * i + 0.5 * p[CHIRP] * t * (t - self.duration),
            p[OMEGA] + p[BEND] * r + p[CHIRP] * (t - 0.5 * self.duration),
            [1.0, t, i, 0.5 * t * (t - self.duration)],
        )
    }

    /// Time at which the phase reaches `n pi`, from a guess.
    #[inline(always)]
    fn turn(&self, p: &[f64], n: f64, guess: f64) -> (f64, f64, [f64; 4]) {
        let mut t = guess;
        for _ in 0..8 {
            let (phase, omega, _) = self.phase(p, t);
            let step = (n * PI - phase) / omega;
            t += step;
            if step.abs() * omega < 1e-12 * (1.0 + n.abs()) {
                break;
            }
        }
        let (_, omega, shapes) = self.phase(p, t);
        (t, omega, shapes)
    }
}

impl LeastSquares for Waveform<'_> {
    fn parameters(&self) -> usize {
        COUNT
    }

    fn observations(&self) -> f64 {
        self.time.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        out.clear();
        let omega = p[OMEGA];
        // Slowest phase rate in the window must stay positive: the motion has an order.
        let slowest = [0.0, self.duration].map(|t| self.phase(p, t).1).into_iter().fold(omega, f64::min);
        if !(p[A0] > 0.0 && omega > 0.0 && slowest > 0.1 * omega) {
            return false;
        }
        // Each half cycle is walked: across a gap of millions of them there is nothing to compare with.
        if omega * self.duration > 100.0 * PI * self.time.len() as f64 {
            return false;
        }
        pulp::Arch::new().dispatch(Pass { wave: self, p, out, residuals: None });
        out.rss.is_finite()
    }
}

impl Waveform<'_> {
    /// Data less model, sample by sample.
    pub(crate) fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let mut residuals = Vec::with_capacity(self.time.len());
        let bare = Waveform { active: Vec::new(), ..self.clone() };
        let mut out = Normal::zeros(COUNT);
        pulp::Arch::new().dispatch(Pass { wave: &bare, p, out: &mut out, residuals: Some(&mut residuals) });
        residuals
    }

    /// Mean phase rate over the window as a combination of parameters.
    pub(crate) fn mean_rate(&self) -> [(usize, f64); 2] {
        let t = self.duration.max(f64::MIN_POSITIVE);
        [(OMEGA, 1.0), (BEND, self.bend.as_ref().map_or(0.0, |b| b.at(t).0 / t))]
    }

    /// Phase of the model at a time on the record's clock.
    pub(crate) fn phase_at(&self, p: &[f64], time_s: f64) -> crate::signal::blocks::PhaseAt {
        let (phase, omega, _) = self.phase(p, time_s - self.origin);
        crate::signal::blocks::PhaseAt { phase, omega, chirp: 0.0, loss: 0.0 }
    }
}

struct Pass<'a, 'b> {
    wave: &'a Waveform<'a>,
    p: &'b [f64],
    out: &'b mut Normal,
    residuals: Option<&'b mut Vec<f64>>,
}

/// A turning point with everything its half cycles need.
#[derive(Clone, Copy)]
struct Turn {
    time: f64,
    omega: f64,
    amplitude: f64,
    shapes: [f64; 4],
    /// Derivatives of the amplitude by all loss and phase parameters.
    by: [f64; 8],
}

impl pulp::NullaryFnOnce for Pass<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Pass { wave, p, out, mut residuals } = self;
        let mut batch = Batch::new(wave.active.len());
        let law = law_of(p, p[OMEGA]);
        // Relative frequency shift per A², which also bends the loss terms.
        let backbone = if wave.bend.is_some() { [p[BEND] / p[OMEGA], 0.0] } else { [0.0; 2] };
        let mut walker = Walker::new(law, backbone);
        let mut n = (p[PHASE] / PI).floor();
        let mut turn = self_turn(wave, p, n, (n * PI - p[PHASE]) / p[OMEGA], &mut walker, 0.0);
        let mut index = 0;
        let mut at_rest = wave.time.len();
        while index < wave.time.len() {
            let mut next = self_turn(wave, p, n + 1.0, turn.time + PI / turn.omega, &mut walker, turn.time);
            if !(next.time > turn.time && next.amplitude.is_finite()) {
                // A phase that does not advance is no motion; the sum says so.
                out.rss = f64::NAN;
                return;
            }
            let swing = turn.amplitude - p[X_F];
            let landing = next.amplitude + p[X_F];
            if !(swing > 0.0 && landing > 0.0) {
                // The spring no longer overcomes the friction: at rest for good.
                next.time = f64::INFINITY;
                at_rest = index;
            }
            let end = index + count_before(&wave.time[index..], wave.origin + next.time);
            let sign = if n.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
            while index < end {
                let m = (end - index).min(PIECE);
                let piece = index..index + m;
                half_cycle(wave, p, &turn, &next, sign, piece, &mut batch);
                if batch.len + PIECE > BATCH {
                    batch.flush(&wave.active, out, &mut residuals);
                }
                index += m;
            }
            turn = next;
            n += 1.0;
        }
        batch.flush(&wave.active, out, &mut residuals);
        if !wave.rest_tells && at_rest < wave.time.len() {
            level(wave, p, at_rest, out, residuals);
        }
    }
}

/// Frees the level of the samples at rest: their sums without what their mean explains.
fn level(wave: &Waveform, p: &[f64], from: usize, out: &mut Normal, residuals: Option<&mut Vec<f64>>) {
    let inverse_duration = 1.0 / wave.duration.max(f64::MIN_POSITIVE);
    let (mut sums, mut left) = ([0.0; 3], 0.0);
    for (t, x) in wave.time[from..].iter().zip(&wave.signal[from..]) {
        let v = (t - wave.origin) * inverse_duration;
        let powers = [1.0, v, v * v];
        left += x - powers.iter().zip(&p[OFFSET..]).map(|(v, c)| v * c).sum::<f64>();
        sums.iter_mut().zip(powers).for_each(|(s, v)| *s += v);
    }
    let n = (wave.time.len() - from) as f64;
    for &i in wave.active.iter().filter(|i| (OFFSET..OFFSET + 3).contains(i)) {
        out.jtr[i] -= sums[i - OFFSET] * left / n;
        for &j in wave.active.iter().filter(|j| (OFFSET..=i).contains(j)) {
            out.jtj[(i, j)] -= sums[i - OFFSET] * sums[j - OFFSET] / n;
        }
    }
    out.rss -= left * left / n;
    if let Some(list) = residuals {
        list[from..].iter_mut().for_each(|r| *r -= left / n);
    }
}

/// Number of leading times below `limit`, found by doubling: half cycles are short.
#[inline(always)]
fn count_before(time: &[f64], limit: f64) -> usize {
    let mut step = 8;
    while step < time.len() && time[step] < limit {
        step *= 2;
    }
    let end = step.min(time.len());
    let from = if step > 8 { step / 2 } else { 0 };
    from + time[from..end].partition_point(|&t| t < limit)
}

#[inline(always)]
fn self_turn(wave: &Waveform, p: &[f64], n: f64, guess: f64, walker: &mut Walker, now: f64) -> Turn {
    let (time, omega, shapes) = wave.turn(p, n, guess);
    walker.advance(time - now);
    let loss = by_parameters(walker.by, p, p[OMEGA]);
    // A later phase moves the turn: dX/dp = rate S/omega; and a0 depends on omega.
    let y = PI * p[DELTA] / (2.0 * p[OMEGA]);
    let gain_by_omega = if y.abs() < 1e-4 { 2.0 / PI } else { y / y.sinh().powi(2) * p[DELTA] / p[OMEGA] };
    let rate = walker.rate();
    let mut by = [0.0; 8];
    by[..4].copy_from_slice(&loss);
    for k in 0..4 {
        by[4 + k] = rate * shapes[k] / omega;
    }
    by[OMEGA] += walker.by[1] * p[X_F] * gain_by_omega;
    Turn { time, omega, amplitude: walker.amplitude, shapes, by }
}

/// Rows of up to [`PIECE`] samples of one half cycle.
#[inline(always)]
fn half_cycle(
    wave: &Waveform,
    p: &[f64],
    turn: &Turn,
    next: &Turn,
    sign: f64,
    piece: std::ops::Range<usize>,
    batch: &mut Batch,
) {
    let m = piece.len();
    let time = &wave.time[piece.clone()];
    let data = &wave.signal[piece];
    let at = batch.len;
    let moving = next.time.is_finite();
    let x_f = p[X_F];
    let swing = if moving { turn.amplitude - x_f } else { 0.0 };
    let ratio = if moving { (next.amplitude + x_f) / swing } else { 1.0 };
    let lambda = ratio.ln() / PI;
    let length = if moving { next.time - turn.time } else { 1.0 };
    let omega = turn.omega;
    let curve = (PI - omega * length) / (length * length);
    let inverse_duration = 1.0 / wave.duration.max(f64::MIN_POSITIVE);

    // Value and its derivatives by turn amplitude, next amplitude, x_F, theta.
    let (mut value, mut by_turn, mut by_next, mut by_x_f, mut by_theta) =
        ([0.0; PIECE], [0.0; PIECE], [0.0; PIECE], [0.0; PIECE], [0.0; PIECE]);
    let (mut part, mut tau) = ([0.0; PIECE], [0.0; PIECE]);
    if moving {
        let inverse_ratio = 1.0 / ratio;
        let spread = swing * (1.0 + lambda * lambda);
        for k in 0..m {
            let t = time[k] - wave.origin;
            let u = t - turn.time;
            let theta = u * (omega + curve * u);
            let (s, c) = trig::half_turn(theta - FRAC_PI_2);
            // cos theta = -sin(theta - pi/2), sin theta = cos(theta - pi/2)
            let (sin, cos) = (c, -s);
            let e = trig::exp(lambda * theta);
            let shape = e * (cos - lambda * sin);
            let slide = e * (theta * (cos - lambda * sin) - sin) / PI;
            value[k] = sign * (x_f + swing * shape);
            by_turn[k] = sign * (shape - slide);
            by_next[k] = sign * slide * inverse_ratio;
            by_x_f[k] = sign * (1.0 - shape + (1.0 + inverse_ratio) * slide);
            by_theta[k] = -sign * spread * e * sin;
            part[k] = u / length;
            tau[k] = t;
        }
    } else {
        let seen = if wave.rest_tells { sign } else { 0.0 };
        for k in 0..m {
            value[k] = seen * turn.amplitude;
            by_turn[k] = seen;
            tau[k] = time[k] - wave.origin;
        }
    }
    let offset = &p[OFFSET..OFFSET + 3];
    for k in 0..m {
        let v = tau[k] * inverse_duration;
        batch.residual[at + k] = data[k] - (value[k] + offset[0] + v * (offset[1] + v * offset[2]));
    }
    for (row, &parameter) in batch.rows.iter_mut().zip(&wave.active) {
        let row = &mut row[at..at + m];
        match parameter {
            A0..=CHIRP => {
                let (a, b) = (turn.by[parameter], next.by[parameter]);
                let b = if moving { b } else { 0.0 };
                let direct = if parameter == X_F { 1.0 } else { 0.0 };
                let (s0, s1) = if parameter >= PHASE {
                    let k = parameter - PHASE;
                    (turn.shapes[k], if moving { next.shapes[k] - turn.shapes[k] } else { 0.0 })
                } else {
                    (0.0, 0.0)
                };
                for k in 0..m {
                    row[k] = a * by_turn[k]
                        + b * by_next[k]
                        + direct * by_x_f[k]
                        + (s0 + s1 * part[k]) * by_theta[k];
                }
            }
            _ => {
                let power = parameter - OFFSET;
                for k in 0..m {
                    let v = tau[k] * inverse_duration;
                    row[k] = match power {
                        0 => 1.0,
                        1 => v,
                        _ => v * v,
                    };
                }
            }
        }
    }
    batch.len += m;
}

/// Rows of the Jacobian, parameter by parameter, waiting for their products.
struct Batch {
    rows: Vec<[f64; BATCH]>,
    residual: [f64; BATCH],
    len: usize,
}

impl Batch {
    #[inline(always)]
    fn new(active: usize) -> Self {
        Self { rows: vec![[0.0; BATCH]; active], residual: [0.0; BATCH], len: 0 }
    }

    #[inline(always)]
    fn flush(&mut self, active: &[usize], out: &mut Normal, residuals: &mut Option<&mut Vec<f64>>) {
        let n = self.len;
        if let Some(list) = residuals {
            list.extend_from_slice(&self.residual[..n]);
        }
        for (i, &pi) in active.iter().enumerate() {
            let row = &self.rows[i][..n];
            out.jtr[pi] += dot(row, &self.residual[..n]);
            for (j, &pj) in active[..=i].iter().enumerate() {
                let product = dot(row, &self.rows[j][..n]);
                out.jtj[(pi.max(pj), pi.min(pj))] += product;
            }
        }
        let r = &self.residual[..n];
        out.rss += dot(r, r);
        self.len = 0;
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 16;
    let mut lanes = [0.0; LANES];
    let (mut x, mut y) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    for (u, v) in (&mut x).zip(&mut y) {
        for k in 0..LANES {
            lanes[k] += u[k] * v[k];
        }
    }
    let tail: f64 = x.remainder().iter().zip(y.remainder()).map(|(u, v)| u * v).sum();
    lanes.iter().sum::<f64>() + tail
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Oscillator;
    use crate::motion::decay::FreeDecay;

    fn wave<'a>(time: &'a [f64], signal: &'a [f64], bend: Option<Bend>) -> Waveform<'a> {
        let duration = time[time.len() - 1];
        Waveform { time, signal, origin: 0.0, duration, bend, rest_tells: true, active: (0..11).collect() }
    }

    fn residuals(wave: &Waveform, p: &[f64]) -> f64 {
        let mut out = Normal::zeros(COUNT);
        assert!(wave.normal(p, &mut out));
        out.rss
    }

    #[test]
    fn is_the_exact_free_decay() {
        for (q, x_f) in [(3.0, 0.02), (50.0, 0.01), (1000.0, 0.0), (1e6, 0.001)] {
            let omega_0 = 7.0;
            let delta = omega_0 / (2.0 * q);
            let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let time: Vec<f64> = (0..400).map(|i| i as f64 * 0.021).collect();
            let end = decay.stop().map_or(f64::INFINITY, |s| s.time_s);
            let time: Vec<f64> = time.into_iter().filter(|&t| t < end).collect();
            let signal: Vec<f64> = time.iter().map(|&t| decay.displacement(t) + 0.3).collect();
            let mut p = [0.0; COUNT];
            (p[A0], p[X_F], p[DELTA], p[OMEGA], p[OFFSET]) = (1.0, x_f, delta, oscillator.omega_d(), 0.3);
            let rms = (residuals(&wave(&time, &signal, None), &p) / time.len() as f64).sqrt();
            assert!(rms < 1e-13, "Q {q}: {rms:e}");
        }
    }

    /// With the level of the rest free, lifting all samples there changes nothing, and the
    /// gradient by the offsets is that of what is left.
    #[test]
    fn the_samples_at_rest_have_their_own_level() {
        let oscillator = Oscillator::kinematic(7.0, 0.02, 0.01).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let stop = decay.stop().expect("stops").time_s;
        let time: Vec<f64> = (0..900).map(|i| f64::from(i) * 1.5 * stop / 900.0).collect();
        let signal: Vec<f64> =
            time.iter().map(|&t| decay.displacement(t) + 0.003 * (31.0 * t).sin()).collect();
        let lifted: Vec<f64> =
            time.iter().zip(&signal).map(|(&t, x)| x + if t > stop { 0.2 } else { 0.0 }).collect();
        let mut p = [0.0; COUNT];
        (p[A0], p[X_F], p[DELTA], p[OMEGA]) = (1.0, 0.01, 0.02, oscillator.omega_d());
        (p[OFFSET], p[OFFSET + 1]) = (0.001, 0.002);
        let free = |signal| Waveform { rest_tells: false, ..wave(&time, signal, None) };
        let rss = residuals(&free(&signal), &p);
        assert!((residuals(&free(&lifted), &p) / rss - 1.0).abs() < 1e-9);
        let listed: f64 = free(&lifted).residuals(&p).iter().map(|r| r * r).sum();
        assert!((listed / rss - 1.0).abs() < 1e-9);
        let wave = free(&lifted);
        let mut out = Normal::zeros(COUNT);
        assert!(wave.normal(&p, &mut out));
        for k in [OFFSET, OFFSET + 1, OFFSET + 2] {
            let h = 1e-6;
            let (mut up, mut down) = (p, p);
            up[k] += h;
            down[k] -= h;
            let numeric = -(residuals(&wave, &up) - residuals(&wave, &down)) / (4.0 * h);
            let error = (out.jtr[k] - numeric).abs() / (out.jtj[(k, k)] * out.rss).sqrt();
            assert!(error < 1e-6, "parameter {k}: {} against {numeric}", out.jtr[k]);
        }
    }

    /// `Jᵀr` is minus half the gradient of `rᵀr`.
    #[test]
    fn the_gradient_holds_for_every_parameter() {
        let time: Vec<f64> = (0..300).map(|i| i as f64 * 0.05 + 0.003 * (i % 7) as f64).collect();
        let signal: Vec<f64> = time.iter().map(|t| (-0.1 * t).exp() * (5.1 * t + 0.3).cos() + 0.1).collect();
        let bend = Bend::along(|t| 1.1 * (-0.12 * t).exp(), 15.1);
        let wave = wave(&time, &signal, Some(bend));
        let p = [1.1, 0.02, 0.08, 0.03, 0.7, 5.0, 0.0, 0.002, 0.05, 0.02, -0.03, 0.0];
        let mut out = Normal::zeros(COUNT);
        assert!(wave.normal(&p, &mut out));
        for k in 0..11 {
            let h = 1e-6;
            let (mut up, mut down) = (p, p);
            up[k] += h;
            down[k] -= h;
            let numeric = -(residuals(&wave, &up) - residuals(&wave, &down)) / (4.0 * h);
            // The backbone also bends the loss terms, which its derivative leaves out;
            // inside a half cycle the shapes are straight lines.
            let tolerance = match k {
                BEND => 0.2,
                CHIRP => 2e-3,
                _ => 2e-5,
            };
            let error = (out.jtr[k] - numeric).abs() / (out.jtj[(k, k)] * out.rss).sqrt();
            assert!(error < tolerance, "parameter {k}: {} against {numeric}", out.jtr[k]);
        }
    }
}
