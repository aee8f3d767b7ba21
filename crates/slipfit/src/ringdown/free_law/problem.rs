//! Least-squares problem of the amplitudes of a decay and a loss curve.

use super::curve::Curve;
use crate::inference::least_squares::{LeastSquares, Normal};

/// Maximum step of the integration, relative to the time scale on which the loss changes, and minimum number
/// of steps per stretch: integration and interpolation are accurate to 1e-8 of the amplitude.
const STEP: f64 = 0.05;
const STEPS_PER_STRETCH: f64 = 8.0;
/// Minimum step relative to the maximum.
const SHORTEST: f64 = 1e-3;

/// Slot of the amplitude at the start; the coefficients of the curve follow.
pub(super) const START: usize = 0;

/// Fit of amplitudes `A(t)` with `dA/dt = -g(A)`.
#[derive(Debug, Clone)]
pub(super) struct FreeProblem {
    pub(super) curve: Curve,
    /// Times at which the amplitude of the motion is needed, s, ascending, each with the measured amplitude
    /// that it contributes to and its share in it (with a low-pass there are several per amplitude).
    pub(super) nodes: Vec<Node>,
    /// Measured amplitudes, or their squares.
    pub(super) value: Vec<f64>,
    pub(super) weight: Vec<f64>,
    /// Inverse variance of the underlying amplitudes for samples of unit variance.
    pub(super) unit_weight: Vec<f64>,
    /// If the values are squares, the contribution of the noise to them.
    pub(super) floor: Option<f64>,
}

/// A time at which the motion is computed, and its share in a measured amplitude.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) time_s: f64,
    pub(super) of: usize,
    pub(super) share: f64,
}

impl FreeProblem {
    /// Model amplitude of every value, and the derivatives of each in sequence.
    fn follow(&self, p: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let n = p.len();
        let (mut amplitudes, mut rows) = (vec![0.0; self.value.len()], vec![0.0; n * self.value.len()]);
        let Some(first) = self.nodes.first() else { return (amplitudes, rows) };
        let last = self.nodes.last().map_or(first.time_s, |last| last.time_s);
        let stretches = (self.curve.coefficients() - 2) as f64;
        let longest = (last - first.time_s) / (STEPS_PER_STRETCH * stretches);
        let mut path = Path::new(&self.curve, p, first.time_s, longest);
        for node in &self.nodes {
            path.go_to(node.time_s);
            amplitudes[node.of] += node.share * path.amplitude;
            let row = &mut rows[n * node.of..n * (node.of + 1)];
            row.iter_mut().zip(&path.by).for_each(|(row, by)| *row += node.share * by);
        }
        (amplitudes, rows)
    }

    /// Model amplitude of every value.
    pub(super) fn amplitudes(&self, p: &[f64]) -> Vec<f64> {
        self.follow(p).0
    }

    /// Weighted residuals.
    pub(super) fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let model = |a: f64| self.floor.map_or(a, |floor| a * a + floor);
        let all = self.amplitudes(p).into_iter().zip(&self.value).zip(&self.weight);
        all.map(|((a, v), w)| (v - model(a)) * w.sqrt()).collect()
    }

    /// The same problem without some of the amplitudes.
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

/// Amplitude and its derivatives at one time, and the rates of all: `d/dt A = -g`,
/// `d/dt A_k = -g' A_k - psi_k`.
#[derive(Clone)]
struct State {
    amplitude: f64,
    rate: f64,
    /// Derivatives by the start and by the coefficients of the curve.
    by: Vec<f64>,
    by_rate: Vec<f64>,
    /// Slope of the loss, `g'`.
    slope: f64,
}

impl State {
    /// Sets the rates from amplitude and derivatives; `room` is scratch space for the shapes and slopes of
    /// the curve.
    fn set_rates(&mut self, curve: &Curve, p: &[f64], room: &mut [Vec<f64>; 2]) {
        let [shapes, slopes] = room;
        curve.shapes(self.amplitude, shapes);
        curve.slopes(self.amplitude, slopes);
        let dot = |v: &[f64]| v.iter().zip(&p[1..]).map(|(v, p)| v * p).sum::<f64>();
        self.rate = -dot(shapes);
        self.slope = dot(slopes);
        for (i, (rate, by)) in self.by_rate.iter_mut().zip(&self.by).enumerate() {
            let shape = if i == START { 0.0 } else { shapes[i - 1] };
            *rate = -self.slope * by - shape;
        }
    }
}

/// The motion integrated in steps as long as its loss allows, with cubic interpolation within the steps.
struct Path<'a> {
    curve: &'a Curve,
    p: &'a [f64],
    longest: f64,
    begin: State,
    end: State,
    begin_s: f64,
    step_s: f64,
    /// Amplitude and derivatives at the current time.
    amplitude: f64,
    by: Vec<f64>,
    now_s: f64,
    stage: State,
    room: [Vec<f64>; 2],
}

impl<'a> Path<'a> {
    fn new(curve: &'a Curve, p: &'a [f64], start_s: f64, longest: f64) -> Self {
        let mut by = vec![0.0; p.len()];
        by[START] = 1.0;
        let mut room = [vec![0.0; curve.coefficients()], vec![0.0; curve.coefficients()]];
        let by_rate = vec![0.0; p.len()];
        let mut begin = State { amplitude: p[START], rate: 0.0, by: by.clone(), by_rate, slope: 0.0 };
        begin.set_rates(curve, p, &mut room);
        Self {
            curve,
            p,
            longest,
            begin_s: start_s,
            step_s: 0.0,
            amplitude: begin.amplitude,
            by,
            now_s: start_s,
            stage: begin.clone(),
            end: begin.clone(),
            begin,
            room,
        }
    }

    fn go_to(&mut self, time_s: f64) {
        if time_s == self.now_s {
            return;
        }
        while time_s > self.begin_s + self.step_s {
            self.step();
        }
        self.now_s = time_s;
        let (h, u) = (self.step_s, (time_s - self.begin_s) / self.step_s);
        let v = 1.0 - u;
        let [w0, w1] = [v * v * (1.0 + 2.0 * u), u * u * (1.0 + 2.0 * v)];
        let [r0, r1] = [h * u * v * v, -h * u * u * v];
        let (begin, end) = (&self.begin, &self.end);
        self.amplitude = w0 * begin.amplitude + w1 * end.amplitude + r0 * begin.rate + r1 * end.rate;
        for (i, by) in self.by.iter_mut().enumerate() {
            *by = w0 * begin.by[i] + w1 * end.by[i] + r0 * begin.by_rate[i] + r1 * end.by_rate[i];
        }
    }

    /// Classical Runge-Kutta step for amplitude and derivatives together, starting from the end of the last
    /// step.
    fn step(&mut self) {
        std::mem::swap(&mut self.begin, &mut self.end);
        self.begin_s += self.step_s;
        let h = (STEP / self.begin.slope.abs()).clamp(SHORTEST * self.longest, self.longest);
        self.step_s = h;
        let sixth = h / 6.0;
        self.stage.clone_from(&self.begin);
        self.end.amplitude = self.begin.amplitude + sixth * self.begin.rate;
        for ((end, begin), rate) in self.end.by.iter_mut().zip(&self.begin.by).zip(&self.begin.by_rate) {
            *end = begin + sixth * rate;
        }
        for (ahead, weight) in [(0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let (stage, begin) = (&mut self.stage, &self.begin);
            stage.amplitude = begin.amplitude + ahead * h * stage.rate;
            for ((by, start), rate) in stage.by.iter_mut().zip(&begin.by).zip(&stage.by_rate) {
                *by = start + ahead * h * rate;
            }
            self.stage.set_rates(self.curve, self.p, &mut self.room);
            self.end.amplitude += weight * sixth * self.stage.rate;
            for (end, rate) in self.end.by.iter_mut().zip(&self.stage.by_rate) {
                *end += weight * sixth * rate;
            }
        }
        self.end.set_rates(self.curve, self.p, &mut self.room);
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
