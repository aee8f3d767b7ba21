//! The decay of a hardening spring, which has no closed form.

/// Displacement at these times of a spring `k (x + alpha x³)` with viscous and sliding loss, released at rest from
/// `amplitude`; the frequency changes by 2 % over the decay.
///
/// The classical Runge-Kutta method is used with 400 steps per second between sign changes of the velocity.
pub(super) fn hardening(omega_0: f64, delta: f64, x_f: f64, amplitude: f64, time: &[f64]) -> Vec<f64> {
    // 3/8 alpha A² = 2 %
    let alpha = 0.02 * 8.0 / 3.0 / (amplitude * amplitude);
    let force =
        |x: f64, v: f64, s: f64| -2.0 * delta * v - omega_0 * omega_0 * (x + alpha * x * x * x + s * x_f);
    let h = 1.0 / 400.0;
    let step = |x: f64, v: f64, s: f64, h: f64| {
        let (k1x, k1v) = (v, force(x, v, s));
        let (k2x, k2v) = (v + 0.5 * h * k1v, force(x + 0.5 * h * k1x, v + 0.5 * h * k1v, s));
        let (k3x, k3v) = (v + 0.5 * h * k2v, force(x + 0.5 * h * k2x, v + 0.5 * h * k2v, s));
        let (k4x, k4v) = (v + h * k3v, force(x + h * k3x, v + h * k3v, s));
        (x + h / 6.0 * (k1x + 2.0 * k2x + 2.0 * k3x + k4x), v + h / 6.0 * (k1v + 2.0 * k2v + 2.0 * k3v + k4v))
    };
    let (mut t, mut x, mut v, mut s) = (0.0, amplitude, 0.0, -1.0);
    let mut out = Vec::with_capacity(time.len());
    let mut index = 0;
    while index < time.len() {
        // The whole step, or the part of it up to the turning point.
        let (nx, nv) = step(x, v, s, h);
        let mut part = h;
        let turns = v != 0.0 && nv * s < 0.0;
        if turns {
            let (mut a, mut b) = (0.0, h);
            for _ in 0..60 {
                let m = 0.5 * (a + b);
                if step(x, v, s, m).1 * s < 0.0 { b = m } else { a = m }
            }
            part = b;
        }
        while index < time.len() && time[index] <= t + part {
            out.push(step(x, v, s, time[index] - t).0);
            index += 1;
        }
        if turns {
            x = step(x, v, s, part).0;
            v = 0.0;
            s = -s;
        } else {
            (x, v) = (nx, nv);
        }
        t += part;
    }
    out
}
