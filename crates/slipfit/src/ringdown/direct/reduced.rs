//! The fit of traces that are known by their values at the nodes, eight side by side.

use super::amplitudes::AmplitudeFit;
use super::nodes::{NODES, Nodes};
use super::straight::{BEND, SHARE, STRAIGHT};
use crate::numeric::trig;

/// Traces side by side.
pub(super) const TRACES: usize = 8;

type Lanes = [f64; TRACES];

/// Eight traces at the nodes; one without power is not looked at.
#[derive(Debug, Default)]
pub(super) struct Reduced {
    pub(super) values: [Lanes; NODES],
    /// Sums of squares of the samples.
    pub(super) power: Lanes,
    /// s, from the first sample to the last.
    pub(super) duration: Lanes,
}

/// What is found, per lane.
#[derive(Debug)]
pub(super) struct Found {
    serves: [bool; TRACES],
    initial: [Lanes; 2],
    sliding: [Lanes; 2],
    decay: [Lanes; 2],
    correlation: Lanes,
    rms: Lanes,
}

impl Found {
    /// The fit of a lane, `None` where sixteen numbers do not tell it.
    pub(super) fn lane(&self, lane: usize) -> Option<AmplitudeFit> {
        let of = |pair: &[Lanes; 2]| [pair[0][lane], pair[1][lane]];
        self.serves[lane].then(|| AmplitudeFit {
            initial_amplitude: of(&self.initial),
            sliding_rate: of(&self.sliding),
            decay_rate_per_s: of(&self.decay),
            correlation: self.correlation[lane],
            residual_rms: self.rms[lane],
            converged: true,
            steps: 1,
        })
    }
}

/// Decay times in a trace up to which a decay is a polynomial of degree 15: the next Chebyshev
/// coefficient of `e^(-x u)` is 2 I_16(x/2) e^(-x/2), at 8 below 1e-9 of the decay and felt by residuals
/// only.
const FASTEST: f64 = 8.0;
/// Steps of a fit that is going to end; most take four.
const MOST_STEPS: usize = 16;
/// Step, in standard errors, that may be the last.
const LAST: f64 = 1e-6;
/// Part of a standard error that remains after it, should the steps go on shrinking as they did.
const REMAINS: f64 = 1e-8;
/// Residuals below this part of the signal's power are differences of sums, and lose digits.
const EXACT: f64 = 1e-9;
/// Standard error of `delta T` beyond which the law bends within it: a fit that guards its steps is due.
const VAGUE: f64 = 0.3;

/// Sums over the nodes at a rate `x = delta T`, of `g = (1 - e^(-x u))/x` and `h = dg/dx`.
#[derive(Default)]
struct Sums {
    g: Lanes,
    gg: Lanes,
    gy: Lanes,
    h: Lanes,
    hh: Lanes,
    hg: Lanes,
    hy: Lanes,
}

#[inline(always)]
fn sums(nodes: &Nodes, values: &[Lanes; NODES], x: &Lanes) -> Sums {
    let mut s = Sums::default();
    let mut per = [0.0; TRACES];
    let mut straight = false;
    for k in 0..TRACES {
        per[k] = 1.0 / x[k];
        straight |= x[k].abs() < STRAIGHT;
    }
    for m in 0..NODES {
        let (u, w) = (nodes.place[m], nodes.weight[m]);
        let (mut g, mut h) = ([0.0; TRACES], [0.0; TRACES]);
        for k in 0..TRACES {
            let e = trig::exp(-x[k] * u);
            g[k] = (1.0 - e) * per[k];
            h[k] = (u * e - g[k]) * per[k];
        }
        if straight {
            for k in 0..TRACES {
                let z = -x[k] * u;
                let (mut share, mut bend) = (0.0, 0.0);
                for (a, b) in SHARE.iter().zip(&BEND).rev() {
                    share = share * z + a;
                    bend = bend * z + b;
                }
                let near = x[k].abs() < STRAIGHT;
                g[k] = if near { u * share } else { g[k] };
                h[k] = if near { -u * u * bend } else { h[k] };
            }
        }
        let y = &values[m];
        for k in 0..TRACES {
            let (wg, wh) = (w * g[k], w * h[k]);
            s.g[k] += wg;
            s.gg[k] += wg * g[k];
            s.gy[k] += wg * y[k];
            s.h[k] += wh;
            s.hh[k] += wh * h[k];
            s.hg[k] += wh * g[k];
            s.hy[k] += wh * y[k];
        }
    }
    s
}

/// Gauss-Newton in the rate alone, amplitude and slope being linear: of `y = A - s g`.
#[inline(always)]
pub(super) fn fit_reduced(nodes: &Nodes, reduced: &Reduced) -> Found {
    let Reduced { values, power, duration } = reduced;
    let n = nodes.samples;
    let (mut mean, mut held) = ([0.0; TRACES], [0.0; TRACES]);
    for m in 0..NODES {
        for k in 0..TRACES {
            mean[k] += nodes.weight[m] * values[m][k];
        }
    }
    for k in 0..TRACES {
        mean[k] /= n;
    }
    // Sum of squares about the mean, of what the nodes hold.
    for m in 0..NODES {
        for k in 0..TRACES {
            let y = values[m][k] - mean[k];
            held[k] += nodes.weight[m] * y * y;
        }
    }
    let mut x = start(nodes, values, &mean);
    let mut before = [f64::INFINITY; TRACES];
    let mut serves = [false; TRACES];
    let mut ended = [false; TRACES];
    let mut found = Found {
        serves,
        initial: [[0.0; TRACES]; 2],
        sliding: [[0.0; TRACES]; 2],
        decay: [[0.0; TRACES]; 2],
        correlation: [0.0; TRACES],
        rms: [0.0; TRACES],
    };
    for _ in 0..MOST_STEPS {
        let s = sums(nodes, values, &x);
        let mut open = false;
        for k in 0..TRACES {
            // Everything about its mean: level and slope drop out of the rest one after the other.
            let (g, h) = (s.g[k] / n, s.h[k] / n);
            let gg = s.gg[k] - s.g[k] * g;
            let (hg, hh) = (s.hg[k] - s.h[k] * g, s.hh[k] - s.h[k] * h);
            let (gy, hy) = (s.gy[k] - s.g[k] * mean[k], s.hy[k] - s.h[k] * mean[k]);
            let slope = -gy / gg;
            let along = hg / gg;
            // h less its parts along one and g, and its product with the residuals.
            let across = hh - along * hg;
            let (square, product) = (slope * slope * across, -slope * (hy - along * gy));
            let step = product / square;
            // Residual of the linear fit, less what the step takes off.
            let outside = power[k] - n * mean[k] * mean[k] - held[k];
            let rss = outside + (held[k] + slope * gy) - product * step;
            let variance = rss / (n - 3.0);
            let x_error = (variance / square).sqrt();
            let remains = step.abs() * (step.abs() / before[k]).min(1.0);
            let last = (step.abs() <= LAST * x_error) & (remains <= REMAINS * x_error);
            before[k] = step.abs();
            let next = x[k] + step;
            let fits = power[k] > 0.0 && x_error < VAGUE && next.abs() < FASTEST && rss > EXACT * power[k];
            let take = last & !ended[k];
            // A + A', s + s' go with the step.
            let by_level = slope * (h - along * g);
            let level = mean[k] + slope * g + by_level * step;
            let slope_end = slope - slope * along * step;
            let sliding = slope_end - next * level;
            // Errors: of level and slope at a known rate, and what the rate's brings.
            let level_own = variance * (1.0 / n + g * g / gg);
            let (slope_own, both_own) = (variance / gg, variance * g / gg);
            let rate_own = x_error * x_error;
            let level_variance = level_own + by_level * by_level * rate_own;
            // sliding = s - x A, at a known rate and by it.
            let by_rate = -slope * along - level - x[k] * by_level;
            let sliding_variance =
                slope_own - 2.0 * x[k] * both_own + x[k] * x[k] * level_own + by_rate * by_rate * rate_own;
            let per = 1.0 / duration[k];
            let keep = |new: f64, old: f64| if take { new } else { old };
            found.initial[0][k] = keep(level, found.initial[0][k]);
            found.initial[1][k] = keep(level_variance.sqrt(), found.initial[1][k]);
            found.sliding[0][k] = keep(sliding * per, found.sliding[0][k]);
            found.sliding[1][k] = keep(sliding_variance.sqrt() * per, found.sliding[1][k]);
            found.decay[0][k] = keep(next * per, found.decay[0][k]);
            found.decay[1][k] = keep(x_error * per, found.decay[1][k]);
            found.correlation[k] = keep(by_rate * x_error / sliding_variance.sqrt(), found.correlation[k]);
            found.rms[k] = keep((rss / n).sqrt(), found.rms[k]);
            serves[k] |= take & fits;
            // A rate beyond the range, or none, ends there as well.
            ended[k] |= last | !(next.abs() < 2.0 * FASTEST);
            x[k] = if ended[k] { x[k] } else { next };
            open |= !ended[k];
        }
        if !open {
            break;
        }
    }
    found.serves = serves;
    found
}

/// Start of the rate, from the second and third Legendre moments of the traces: of an exponential on
/// -1 to 1, `e^(-z s)`, their ratio is that of the spherical Bessel functions `i_2/i_1`, next to
/// `7 z/(35 + z²)`, and a level has neither.
#[inline(always)]
fn start(nodes: &Nodes, values: &[Lanes; NODES], mean: &Lanes) -> Lanes {
    let (mut first, mut second) = ([0.0; TRACES], [0.0; TRACES]);
    for m in 0..NODES {
        let s = 2.0 * nodes.place[m] - 1.0;
        let (by_first, by_second) = (nodes.weight[m] * s, nodes.weight[m] * (1.5 * s * s - 0.5));
        for k in 0..TRACES {
            let y = values[m][k] - mean[k];
            first[k] += by_first * y;
            second[k] += by_second * y;
        }
    }
    let mut x = [0.0; TRACES];
    for k in 0..TRACES {
        let ratio = -second[k] / first[k];
        // Noise may ask for more than any exponential has.
        let ratio = if ratio.abs() < 0.55 { ratio } else { 0.55f64.copysign(ratio) };
        let z = 70.0 * ratio / (7.0 + (49.0 - 140.0 * ratio * ratio).sqrt());
        x[k] = 2.0 * z;
    }
    x
}
