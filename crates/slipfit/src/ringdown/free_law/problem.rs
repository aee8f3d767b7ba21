//! The amplitudes of a decay against a curve of the loss, as a least-squares problem.

use super::curve::Curve;
use crate::inference::least_squares::{LeastSquares, Normal};

/// Longest step of the integration, over the time in which the loss changes, and most steps from one
/// amplitude to the next.
const STEP: f64 = 0.2;
const MOST_STEPS: f64 = 64.0;

/// Amplitude at the start; the coefficients of the curve follow.
pub(super) const START: usize = 0;

/// Amplitudes `A(t)` of `dA/dt = -g(A)`.
#[derive(Debug, Clone)]
pub(super) struct FreeProblem {
    pub(super) curve: Curve,
    /// Instants at which the amplitude of the motion is needed, s, ascending: which measured amplitude
    /// it is part of, and its share there (behind a low-pass there are many).
    pub(super) nodes: Vec<Node>,
    /// Measured amplitudes, or their squares.
    pub(super) value: Vec<f64>,
    pub(super) weight: Vec<f64>,
    /// Inverse variance of the amplitudes behind them for samples of unit variance.
    pub(super) unit_weight: Vec<f64>,
    /// Where the values are squares, what noise adds to them.
    pub(super) floor: Option<f64>,
}

/// An instant of the motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) time_s: f64,
    pub(super) of: usize,
    pub(super) share: f64,
}

impl FreeProblem {
    /// Amplitude behind every value, and its derivatives one after another.
    fn follow(&self, p: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let n = p.len();
        let (mut amplitudes, mut rows) = (vec![0.0; self.value.len()], vec![0.0; n * self.value.len()]);
        let Some(first) = self.nodes.first() else { return (amplitudes, rows) };
        let mut state = State::new(&self.curve, p);
        let mut now = first.time_s;
        for node in &self.nodes {
            state.advance(node.time_s - now);
            now = node.time_s;
            amplitudes[node.of] += node.share * state.amplitude;
            let row = &mut rows[n * node.of..n * (node.of + 1)];
            row.iter_mut().zip(&state.by).for_each(|(row, by)| *row += node.share * by);
        }
        (amplitudes, rows)
    }

    /// Amplitude behind every value.
    pub(super) fn amplitudes(&self, p: &[f64]) -> Vec<f64> {
        self.follow(p).0
    }

    /// Weighted residuals.
    pub(super) fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let model = |a: f64| self.floor.map_or(a, |floor| a * a + floor);
        let all = self.amplitudes(p).into_iter().zip(&self.value).zip(&self.weight);
        all.map(|((a, v), w)| (v - model(a)) * w.sqrt()).collect()
    }

    /// The same without some of the amplitudes.
    pub(super) fn without(&self, left_out: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.value.len()).filter(|i| !left_out(*i)).collect();
        let place = |of: usize| kept.binary_search(&of).ok();
        Self {
            curve: self.curve.clone(),
            nodes: self.nodes.iter().filter_map(|n| Some(Node { of: place(n.of)?, ..*n })).collect(),
            value: kept.iter().map(|&i| self.value[i]).collect(),
            weight: kept.iter().map(|&i| self.weight[i]).collect(),
            unit_weight: kept.iter().map(|&i| self.unit_weight[i]).collect(),
            floor: self.floor,
        }
    }
}

impl LeastSquares for FreeProblem {
    fn parameters(&self) -> usize {
        1 + self.curve.coefficients()
    }

    fn observations(&self) -> f64 {
        self.value.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        out.clear();
        let (amplitudes, mut rows) = self.follow(p);
        for (i, row) in rows.chunks_exact_mut(p.len()).enumerate() {
            let a = amplitudes[i];
            let mut model = a;
            if let Some(floor) = self.floor {
                model = a * a + floor;
                row.iter_mut().for_each(|r| *r *= 2.0 * a);
            }
            out.add_row(row, self.value[i] - model, self.weight[i]);
        }
        out.rss.is_finite() && out.jtr.iter().all(|v| v.is_finite())
    }
}

/// The motion carried along with its derivatives: `d/dt A = -g`, `d/dt A_k = -g' A_k - psi_k`.
struct State<'a> {
    curve: &'a Curve,
    p: &'a [f64],
    amplitude: f64,
    /// By the start and by the coefficients of the curve.
    by: Vec<f64>,
    /// Room for shapes and slopes of one amplitude.
    shapes: Vec<f64>,
    slopes: Vec<f64>,
}

impl<'a> State<'a> {
    fn new(curve: &'a Curve, p: &'a [f64]) -> Self {
        let mut by = vec![0.0; p.len()];
        by[START] = 1.0;
        let room = vec![0.0; curve.coefficients()];
        Self { curve, p, amplitude: p[START], by, shapes: room.clone(), slopes: room }
    }

    /// Loss and its slope at an amplitude; the shapes there stay behind.
    fn loss(&mut self, amplitude: f64) -> [f64; 2] {
        self.curve.shapes(amplitude, &mut self.shapes);
        self.curve.slopes(amplitude, &mut self.slopes);
        let dot = |v: &[f64]| v.iter().zip(&self.p[1..]).map(|(v, p)| v * p).sum::<f64>();
        [dot(&self.shapes), dot(&self.slopes)]
    }

    fn advance(&mut self, duration: f64) {
        if duration == 0.0 {
            return;
        }
        let [_, slope] = self.loss(self.amplitude);
        let steps = (slope.abs() * duration / STEP).ceil().clamp(1.0, MOST_STEPS);
        (0..steps as usize).for_each(|_| self.step(duration / steps));
    }

    /// The classical Runge-Kutta rule for amplitude and derivatives together.
    fn step(&mut self, h: f64) {
        let (a0, by0) = (self.amplitude, self.by.clone());
        let mut sum = 0.0;
        let mut sums = vec![0.0; by0.len()];
        let (mut k, mut ks) = (0.0, vec![0.0; by0.len()]);
        for (ahead, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let [g, slope] = self.loss(a0 + ahead * h * k);
            for (i, (k_i, start)) in ks.iter_mut().zip(&by0).enumerate() {
                let shape = if i == START { 0.0 } else { self.shapes[i - 1] };
                *k_i = -slope * (start + ahead * h * *k_i) - shape;
                sums[i] += weight * *k_i;
            }
            k = -g;
            sum += weight * k;
        }
        self.amplitude = a0 + h / 6.0 * sum;
        for ((by, start), sum) in self.by.iter_mut().zip(&by0).zip(&sums) {
            *by = start + h / 6.0 * sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::AmplitudeLaw;

    fn problem(floor: Option<f64>) -> FreeProblem {
        let law = AmplitudeLaw::new(2.0, 0.02, 0.1, 0.05).unwrap();
        let time_s: Vec<f64> = (0..60).map(|i| 0.2 * f64::from(i)).collect();
        let value: Vec<f64> = time_s.iter().map(|t| law.amplitude(*t)).collect();
        let curve = Curve::through(&value, 12.0, 8).unwrap();
        let nodes = (0..60).map(|of| Node { time_s: time_s[of], of, share: 1.0 }).collect();
        let value = value.iter().map(|a| floor.map_or(*a, |f| a * a + f)).collect();
        FreeProblem { curve, nodes, value, weight: vec![1.0; 60], unit_weight: vec![1.0; 60], floor }
    }

    #[test]
    fn a_line_is_the_closed_law_of_sliding_and_viscous_loss() {
        let problem = problem(None);
        let law = AmplitudeLaw::new(2.0, 0.05, 0.2, 0.0).unwrap();
        let mut p = vec![0.0; problem.parameters()];
        p[..3].copy_from_slice(&[2.0, 0.05, 0.2]);
        for (found, node) in problem.amplitudes(&p).iter().zip(&problem.nodes) {
            assert!((found - law.after(2.0, node.time_s)).abs() < 1e-7);
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        for floor in [None, Some(0.01)] {
            let problem = problem(floor);
            let n = problem.parameters();
            let p: Vec<f64> = (0..n).map(|k| [2.0, 0.05, 0.2].get(k).copied().unwrap_or(0.03)).collect();
            let mut sums = Normal::zeros(n);
            assert!(problem.normal(&p, &mut sums));
            for k in 0..n {
                let h = 1e-5;
                let (mut up, mut down) = (p.clone(), p.clone());
                up[k] += h;
                down[k] -= h;
                let rss = |p: &[f64]| problem.residuals(p).iter().map(|r| r * r).sum::<f64>();
                let numeric = -(rss(&up) - rss(&down)) / (4.0 * h);
                let error = (sums.jtr[k] - numeric).abs() / (sums.jtj[(k, k)] * sums.rss).sqrt();
                assert!(error < 1e-5, "{k}: {} for {numeric}", sums.jtr[k]);
            }
        }
    }

    #[test]
    fn amplitudes_left_out_take_their_instants_along() {
        let problem = problem(None);
        let fewer = problem.without(|i| i % 3 == 0);
        assert_eq!((fewer.value.len(), fewer.nodes.len()), (40, 40));
        assert_eq!(fewer.nodes[0].time_s, problem.nodes[1].time_s);
        assert_eq!(fewer.value[fewer.nodes[7].of], problem.value[11]);
    }
}
