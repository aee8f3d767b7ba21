//! Least-squares problem of the amplitude law and the amplitudes of the blocks.

use crate::inference::least_squares::{Fit, LeastSquares, Normal};
use crate::motion::decay::amplitude::{AmplitudeLaw, sliding_gain};
use crate::motion::decay::closed_path::{self, Points};
use crate::motion::decay::parameters::{by_parameters, range, shape_of, shapes_exist};
use crate::motion::decay::path::{AmplitudePath, CARRIED, Carried};

pub(crate) use crate::motion::decay::parameters::{A0, DELTA, DRAG, X_F, law_of};

/// Slot of the square of the noise floor of a bare envelope, after the loss terms.
pub(crate) const FLOOR: usize = CARRIED;
const COUNT: usize = FLOOR + 1;

/// Amplitudes with their weights, and the known properties of frequency and detector.
#[derive(Debug, Clone)]
pub(crate) struct EnvelopeProblem {
    /// Time since the start, s, ascending.
    pub(crate) elapsed: Vec<f64>,
    /// Signed amplitude, or mean squared amplitude if `squared`.
    pub(crate) value: Vec<f64>,
    /// Inverse variance up to a common factor.
    pub(crate) weight: Vec<f64>,
    /// Angular frequency at vanishing amplitude, rad/s.
    pub(crate) omega: f64,
    /// Relative shift of frequency per A² and A⁴.
    pub(crate) backbone: [f64; 2],
    /// Whether the values are `A² + floor`, with the floor a parameter.
    pub(crate) squared: bool,
    /// Variance of the times of the samples averaged in a value, s²; zero if the value is that at their
    /// middle.
    pub(crate) time_variance_s2: f64,
    pub(crate) lowpass: Option<super::lowpass::Kernel>,
}

impl EnvelopeProblem {
    /// Amplitude of the model at every point.
    pub(crate) fn amplitudes(&self, p: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.elapsed.len());
        self.walk(p, Carried::None, |_, amplitude, _| out.push(amplitude));
        out
    }

    /// Weighted residuals.
    pub(crate) fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let law = law_of(p, self.omega);
        let mut out = Vec::with_capacity(self.value.len());
        self.walk(p, Carried::None, |j, amplitude, _| {
            out.push((self.value[j] - self.model(&law, amplitude, p)) * self.weight[j].sqrt());
        });
        out
    }

    /// Residuals and derivatives of the model at every point.
    pub(crate) fn predictions(&self, fit: &Fit) -> Vec<(f64, [f64; COUNT])> {
        let p = &fit.parameters;
        let law = law_of(p, self.omega);
        let mut out = Vec::with_capacity(self.value.len());
        self.walk(p, Carried::All, |j, amplitude, by| {
            out.push((self.value[j] - self.model(&law, amplitude, p), self.row(amplitude, by)));
        });
        out
    }

    /// Root mean square of amplitude minus model.
    pub(crate) fn unweighted_rms(&self, p: &[f64]) -> f64 {
        let law = law_of(p, self.omega);
        let mut sum = 0.0;
        self.walk(p, Carried::None, |j, amplitude, _| sum += self.residual_at(&law, j, amplitude, p).powi(2));
        (sum / self.value.len() as f64).sqrt()
    }

    /// Residuals suited to outlier detection: the weighted ones or, for squares, those of their square roots,
    /// whose noise has no long tail and is nearly constant from the start to rest.
    pub(crate) fn residuals_for_outliers(&self, p: &[f64]) -> Vec<f64> {
        if !self.squared {
            return self.residuals(p);
        }
        let law = law_of(p, self.omega);
        let mut out = Vec::with_capacity(self.value.len());
        self.walk(p, Carried::None, |j, amplitude, _| out.push(self.residual_at(&law, j, amplitude, p)));
        out
    }

    /// Amplitude minus model at a point.
    fn residual_at(&self, law: &AmplitudeLaw, j: usize, amplitude: f64, p: &[f64]) -> f64 {
        let (data, model) = (self.value[j], self.model(law, amplitude, p));
        if self.squared { data.max(0.0).sqrt() - model.max(0.0).sqrt() } else { data - model }
    }

    /// Model value of a point, given the amplitude at its middle.
    fn model(&self, law: &AmplitudeLaw, amplitude: f64, p: &[f64]) -> f64 {
        let middle = if self.squared { amplitude.max(0.0).powi(2) + p[FLOOR] } else { amplitude };
        middle + averaging_bias(law, amplitude, self.squared, self.time_variance_s2)
    }

    /// Derivatives of the model with respect to all parameters.
    fn row(&self, amplitude: f64, by: [f64; CARRIED]) -> [f64; COUNT] {
        let factor = if self.squared { 2.0 * amplitude.max(0.0) } else { 1.0 };
        let mut row = [1.0; COUNT];
        for (r, b) in row.iter_mut().zip(by) {
            *r = b * factor;
        }
        row
    }

    /// All amplitudes from the closed law, if it applies and its derivatives suffice.
    fn at_once(&self, law: &AmplitudeLaw, carried: Carried) -> Option<Points> {
        let closed = carried != Carried::All && self.backbone == [0.0; 2] && self.lowpass.is_none();
        if closed { closed_path::at_times(law, &self.elapsed) } else { None }
    }

    /// Visits the amplitudes and the derivatives selected by `carried`.
    fn walk(&self, p: &[f64], carried: Carried, mut visit: impl FnMut(usize, f64, [f64; CARRIED])) {
        self.walk_while(p, carried, |j, amplitude, by| {
            visit(j, amplitude, by);
            true
        });
    }

    /// The same, as long as `visit` returns true; returns whether the end was reached.
    fn walk_while(
        &self,
        p: &[f64],
        carried: Carried,
        mut visit: impl FnMut(usize, f64, [f64; CARRIED]) -> bool,
    ) -> bool {
        let law = law_of(p, self.omega);
        let gain = sliding_gain(p[DELTA], self.omega);
        match &self.lowpass {
            None => {
                if let Some(points) = self.at_once(&law, carried) {
                    let [amplitude, rows @ ..] = points.rows();
                    let mut all = [0.0; CARRIED];
                    for j in 0..amplitude.len() {
                        all[..rows.len()].copy_from_slice(&rows.map(|row| row[j]));
                        if !visit(j, amplitude[j], by_parameters(all, p, &gain)) {
                            return false;
                        }
                    }
                    return true;
                }
                let mut path = AmplitudePath::new(law, self.backbone).carrying(carried);
                let mut now = 0.0;
                for (j, &t) in self.elapsed.iter().enumerate() {
                    path.advance(t - now);
                    now = t;
                    // The amplitude of a motion at rest is zero; a non-finite amplitude also counts as no
                    // motion.
                    let seen = if path.amplitude <= 0.0 {
                        visit(j, 0.0, [0.0; CARRIED])
                    } else {
                        visit(j, path.amplitude, by_parameters(path.by, p, &gain))
                    };
                    if !seen {
                        return false;
                    }
                }
            }
            Some(kernel) => {
                for (j, &t) in self.elapsed.iter().enumerate() {
                    let mut amplitude = 0.0;
                    let mut by = [0.0; CARRIED];
                    for &(delay, share) in &kernel.nodes {
                        let mut path = AmplitudePath::new(law, self.backbone).carrying(carried);
                        path.advance(t - delay);
                        if path.amplitude > 0.0 {
                            amplitude += share * path.amplitude;
                            let d = by_parameters(path.by, p, &gain);
                            by.iter_mut().zip(d).for_each(|(sum, d)| *sum += share * d);
                        }
                    }
                    if !visit(j, amplitude, by) {
                        return false;
                    }
                }
            }
        }
        true
    }
}

/// Mean of an amplitude, or of its square, over samples whose times have this variance, minus its value at
/// their middle: half the variance times the second derivative.
pub(crate) fn averaging_bias(
    law: &AmplitudeLaw,
    amplitude: f64,
    squared: bool,
    time_variance_s2: f64,
) -> f64 {
    if time_variance_s2 == 0.0 || amplitude <= 0.0 {
        return 0.0;
    }
    let rate = law.rate(amplitude);
    let second = rate * law.rate_slope(amplitude);
    0.5 * time_variance_s2 * if squared { 2.0 * (rate * rate + amplitude * second) } else { second }
}

impl LeastSquares for EnvelopeProblem {
    fn parameters(&self) -> usize {
        COUNT
    }

    fn observations(&self) -> f64 {
        self.value.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        self.normal_of(p, &std::array::from_fn::<_, COUNT, _>(|i| i), out, f64::INFINITY)
    }

    fn normal_of(&self, p: &[f64], free: &[usize], out: &mut Normal, limit: f64) -> bool {
        out.clear();
        if !(p[A0] > 0.0 && shapes_exist(p)) {
            return false;
        }
        if free.len() <= FEW {
            self.closed_sums(p, free, out, limit).unwrap_or_else(|| self.sums::<FEW>(p, free, out, limit))
        } else {
            self.sums::<COUNT>(p, free, out, limit)
        }
    }

    fn range(&self, parameter: usize) -> [f64; 2] {
        range(parameter)
    }

    fn without_influence(&self, zero: usize) -> Option<(usize, f64)> {
        shape_of(zero)
    }
}

/// Number of parameters: amplitude and the losses compared by default.
const FEW: usize = 4;

/// Number of points whose sums are computed together.
const TOGETHER: usize = 8;

/// Sums over amplitudes from the closed law, computed together.
struct ClosedSums<'a> {
    problem: &'a EnvelopeProblem,
    law: &'a AmplitudeLaw,
    points: &'a Points,
    /// `x_F` times the derivative of the gain with respect to the decay rate, and the gain: sliding rate per
    /// unit of `x_F`.
    gains: [f64; 2],
}

/// One number for each of several points.
type Together = [f64; TOGETHER];

/// Products of rows, products of rows and residuals, and the sum of squares, lane by lane.
struct Sums {
    jtj: [[Together; FEW]; FEW],
    jtr: [Together; FEW],
    rss: Together,
}

impl ClosedSums<'_> {
    /// Adds values, weights, amplitudes and derivatives of several points.
    #[inline(always)]
    fn add(&self, sums: &mut Sums, [value, weight, a, by_a, by_x, by_d, by_c]: [&Together; 7]) {
        let Self { problem, law, gains: [through_delta, gain], .. } = *self;
        let half_variance = 0.5 * problem.time_variance_s2;
        let (mut rows, mut residual) = ([*by_a, *by_x, *by_d, *by_c], [0.0; TOGETHER]);
        for n in 0..TOGETHER {
            let rate = law.a0 + a[n] * (law.a1 + a[n] * law.a2);
            let second = rate * (law.a1 + 2.0 * a[n] * law.a2);
            let bias = if a[n] > 0.0 { half_variance * second } else { 0.0 };
            residual[n] = value[n] - (a[n] + bias);
            rows[DELTA][n] = by_d[n] + by_x[n] * through_delta;
            rows[X_F][n] = by_x[n] * gain;
        }
        for i in 0..FEW {
            let mut weighted = [0.0; TOGETHER];
            for n in 0..TOGETHER {
                weighted[n] = weight[n] * rows[i][n];
                sums.jtr[i][n] += weighted[n] * residual[n];
            }
            for k in 0..=i {
                for n in 0..TOGETHER {
                    sums.jtj[i][k][n] += weighted[n] * rows[k][n];
                }
            }
        }
        for n in 0..TOGETHER {
            sums.rss[n] += weight[n] * residual[n] * residual[n];
        }
    }
}

impl pulp::NullaryFnOnce for ClosedSums<'_> {
    type Output = Sums;

    #[inline(always)]
    fn call(self) -> Sums {
        const NONE: Together = [0.0; TOGETHER];
        let mut sums = Sums { jtj: [[NONE; FEW]; FEW], jtr: [NONE; FEW], rss: NONE };
        let [amplitude, by_a, by_x, by_d, by_c] = self.points.rows();
        let columns = [&self.problem.value[..], &self.problem.weight, amplitude, by_a, by_x, by_d, by_c];
        let [value, weight, a, by_a, by_x, by_d, by_c] = columns.map(|column| column.as_chunks().0);
        for (((value, weight), (a, by_a)), ((by_x, by_d), by_c)) in
            value.iter().zip(weight).zip(a.iter().zip(by_a)).zip(by_x.iter().zip(by_d).zip(by_c))
        {
            self.add(&mut sums, [value, weight, a, by_a, by_x, by_d, by_c]);
        }
        // The padding lanes have zero weight.
        let rest = columns.map(|column| {
            let mut piece = NONE;
            let rest = column.as_chunks::<TOGETHER>().1;
            piece[..rest.len()].copy_from_slice(rest);
            piece
        });
        self.add(&mut sums, rest.each_ref());
        sums
    }
}

impl EnvelopeProblem {
    /// [`Self::sums`] for the first [`FEW`] parameters if the closed law applies; otherwise `None`.
    fn closed_sums(&self, p: &[f64], free: &[usize], out: &mut Normal, limit: f64) -> Option<bool> {
        if self.squared || free.iter().any(|k| *k >= FEW) {
            return None;
        }
        let law = law_of(p, self.omega);
        let points = self.at_once(&law, Carried::Closed)?;
        let [gain, gain_by_delta, _] = sliding_gain(p[DELTA], self.omega);
        let gains = [p[X_F] * gain_by_delta, gain];
        let sums = ClosedSums { problem: self, law: &law, points: &points, gains };
        let Sums { jtj, jtr, rss } = crate::numeric::dispatch(sums);
        let total = |places: &Together| places.iter().sum::<f64>();
        for &a in free {
            out.jtr[a] = total(&jtr[a]);
            for &b in free.iter().filter(|b| **b <= a) {
                out.jtj[(a, b)] = total(&jtj[a][b]);
            }
        }
        out.rss = total(&rss);
        Some(out.rss <= limit && out.rss.is_finite())
    }

    /// The sums with respect to at most `N` free parameters; `false` if the sum of squares exceeds `limit`.
    fn sums<const N: usize>(&self, p: &[f64], free: &[usize], out: &mut Normal, limit: f64) -> bool {
        let law = law_of(p, self.omega);
        let (mut jtj, mut jtr, mut rss) = ([[0.0; N]; N], [0.0; N], 0.0);
        let within = self.walk_while(p, Carried::for_parameters(free), |j, amplitude, by| {
            let residual = self.value[j] - self.model(&law, amplitude, p);
            let (weight, all) = (self.weight[j], self.row(amplitude, by));
            let mut row = [0.0; N];
            for (r, &k) in row.iter_mut().zip(free) {
                *r = all[k];
            }
            for i in 0..N {
                let weighted = weight * row[i];
                jtr[i] += weighted * residual;
                for k in 0..=i {
                    jtj[i][k] += weighted * row[k];
                }
            }
            rss += weight * residual * residual;
            rss <= limit
        });
        for (i, &a) in free.iter().enumerate() {
            out.jtr[a] = jtr[i];
            for (k, &b) in free[..=i].iter().enumerate() {
                out.jtj[(a.max(b), a.min(b))] = jtj[i][k];
            }
        }
        out.rss = rss;
        within && rss.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::path::SHAPE;

    fn problem(backbone: [f64; 2], squared: bool) -> EnvelopeProblem {
        let elapsed: Vec<f64> = (0..60).map(|i| 0.13 * i as f64 + 0.01 * (i % 3) as f64).collect();
        let n = elapsed.len();
        EnvelopeProblem {
            elapsed,
            value: vec![0.0; n],
            weight: vec![1.0; n],
            omega: 11.0,
            backbone,
            squared,
            time_variance_s2: 0.0,
            lowpass: None,
        }
    }

    /// Compares the derivatives carried along with central differences.
    fn check(problem: &EnvelopeProblem, terms: [f64; 4], further: f64, tolerance: f64) {
        let mut p = [0.0; COUNT];
        p[..4].copy_from_slice(&terms);
        p[4..SHAPE].fill(further);
        p[SHAPE..FLOOR].fill(1.5);
        for k in 0..FLOOR {
            if k >= SHAPE && further == 0.0 {
                // If a loss is zero, its shape has no effect.
                continue;
            }
            let h = 1e-5 * p[k].abs().max(1e-2);
            let (mut up, mut down) = (p, p);
            up[k] += h;
            down[k] -= h;
            let numeric: Vec<f64> = problem
                .amplitudes(&up)
                .iter()
                .zip(problem.amplitudes(&down))
                .map(|(a, b)| (a - b) / (2.0 * h))
                .collect();
            let scale = numeric.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            problem.walk(&p, Carried::All, |j, _, by| {
                let error = (by[k] - numeric[j]).abs() / scale;
                assert!(error < tolerance, "parameter {k}, point {j}: {} against {}", by[k], numeric[j]);
            });
        }
    }

    #[test]
    fn derivatives_hold_for_every_loss_term() {
        for p in [
            [1.0, 0.0, 0.2, 0.0],
            [1.0, 0.01, 0.0, 0.0],
            [1.0, 0.01, 0.1, 0.0],
            [1.0, 0.0, 0.1, 0.2],
            [2.0, 0.005, 0.05, 0.1],
        ] {
            check(&problem([0.0; 2], false), p, 0.0, 2e-5);
            check(&problem([0.0; 2], false), p, 0.03, 2e-5);
            // The derivatives neglect that the loss terms themselves change with amplitude through the
            // backbone.
            check(&problem([0.01, -0.001], false), p, 0.0, 2e-2);
        }
    }

    #[test]
    fn a_mean_over_samples_is_that_of_the_law() {
        let mut p = [0.0; COUNT];
        p[..4].copy_from_slice(&[1.5, 0.01, 0.3, 0.07]);
        // Eleven samples about the middle.
        let (middle, step) = (1.7, 0.02);
        for squared in [false, true] {
            let problem = EnvelopeProblem {
                elapsed: (-5..=5).map(|k| middle + step * f64::from(k)).collect(),
                value: vec![0.0; 11],
                weight: vec![1.0; 11],
                ..problem([0.0; 2], squared)
            };
            let law = law_of(&p, problem.omega);
            let each = problem.amplitudes(&p);
            let mean = each.iter().map(|a| problem.model(&law, *a, &p)).sum::<f64>() / 11.0;
            let variance = step * step * 10.0;
            let whole = EnvelopeProblem { time_variance_s2: variance, ..problem };
            let curved = whole.model(&law, each[5], &p);
            let straight = EnvelopeProblem { time_variance_s2: 0.0, ..whole }.model(&law, each[5], &p);
            assert!(
                (curved - mean).abs() < 0.003 * (straight - mean).abs(),
                "{curved}, {straight} for {mean}"
            );
        }
    }

    #[test]
    fn steps_add_up_to_the_closed_form() {
        let mut p = [0.0; COUNT];
        p[..4].copy_from_slice(&[1.5, 0.01, 0.1, 0.07]);
        let problem = problem([0.0; 2], true);
        let law = law_of(&p, problem.omega);
        for (a, t) in problem.amplitudes(&p).iter().zip(&problem.elapsed) {
            assert!((a - law.after(law.initial, *t)).abs() < 1e-13);
        }
    }
}
