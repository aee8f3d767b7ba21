//! Effect of a lock-in's output filter on the amplitude law.

use super::options::LowPass;

/// Impulse response of `order` equal first-order stages as a sum of delays,
/// `A_out(t) = sum share_i A(t - delay_i)`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kernel {
    pub(crate) nodes: Vec<(f64, f64)>,
}

impl Kernel {
    /// Equal-weight quantile nodes would be coarse in the tail; Gauss-Legendre panels over the response are
    /// accurate to 1e-7 for decays over five time constants or more, and resolve the corner at a stop.
    pub(crate) fn new(filter: LowPass) -> Self {
        let LowPass { time_constant_s, order } = filter;
        let order = order.clamp(1, 8);
        let factorial: f64 = (1..order).map(f64::from).product();
        let end = 24.0 + 3.0 * f64::from(order);
        let panels = 8;
        let mut nodes = Vec::with_capacity(panels * 5);
        for panel in 0..panels {
            // Panels widen with the delay: the response is steepest at its start.
            let edge = |i: usize| end * (i as f64 / panels as f64).powi(2);
            let (a, b) = (edge(panel), edge(panel + 1));
            for (x, w) in LEGENDRE {
                let u = 0.5 * (a + b) + 0.5 * (b - a) * x;
                let share = 0.5 * (b - a) * w * u.powi(order as i32 - 1) * (-u).exp() / factorial;
                if share > 1e-14 {
                    nodes.push((u * time_constant_s, share));
                }
            }
        }
        let total: f64 = nodes.iter().map(|n| n.1).sum();
        for node in &mut nodes {
            node.1 /= total;
        }
        Self { nodes }
    }
}

/// Gauss-Legendre nodes and weights of order 5 on (-1, 1).
const LEGENDRE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// An exponential through n stages has the gain 1/(1 - delta tau)^n.
    #[test]
    fn passes_an_exponential_with_the_known_gain() {
        for order in 1..=8 {
            let kernel = Kernel::new(LowPass { time_constant_s: 0.02, order });
            let gain: f64 = kernel.nodes.iter().map(|(d, s)| s * (3.0 * d).exp()).sum();
            let exact = (1.0f64 - 0.06).powi(-(order as i32));
            assert!((gain / exact - 1.0).abs() < 1e-7, "order {order}: {gain} for {exact}");
        }
    }
}
