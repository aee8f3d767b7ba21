//! The drive as it acts on one arc, relative to the start of the arc.

use super::transition::{C64, Constants, convolve, phi_2};

/// `U(u) - U(0)` as harmonics, a slope and a chirp; valid up to `end`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Local {
    /// `U(0)`.
    pub(super) value: f64,
    pub(super) tones: Vec<Tone>,
    pub(super) slope: f64,
    pub(super) chirp: Option<Chirp>,
    /// Duration of validity, s.
    pub(super) end: f64,
    /// The time at which it ends, if the caller gave it as a number.
    pub(super) end_time: Option<f64>,
    /// Whether another stage of the drive begins at the end.
    pub(super) stage_ends: bool,
    /// Interval that contains the drive at all later times, if known.
    pub(super) range: (f64, f64),
}

/// `Re c e^(i omega u)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tone {
    pub(super) omega: f64,
    pub(super) c: C64,
    /// `c` as `size e^(i angle)`; the angle is not reduced.
    size: f64,
    angle: f64,
    z: [C64; 2],
    inverse: [C64; 2],
}

impl Tone {
    pub(super) fn new(k: &Constants, omega: f64, size: f64, angle: f64) -> Self {
        // omega - omega_d at full precision, because it is the small divisor near resonance.
        let z = [C64::new(k.delta, omega - k.omega_d), C64::new(k.delta, -omega - k.omega_d)];
        let inverse = z.map(|z| if z.norm_sqr() > 0.0 { z.inv() } else { C64::default() });
        Self { omega, c: C64::default(), size, angle, z, inverse }.at(size, angle)
    }

    /// [`Local::convolved`] for this harmonic alone, `e = e^(i omega u)`.
    #[inline]
    pub(super) fn convolved(&self, u: f64, e: C64, e_lambda: C64, one: C64) -> (C64, f64, f64) {
        let up = convolve(self.z[0], self.inverse[0], u, e, e_lambda) - one;
        let down = convolve(self.z[1], self.inverse[1], u, e.conj(), e_lambda) - one;
        let there = self.c * e;
        ((self.c * up + self.c.conj() * down) * 0.5, (self.c * (e - 1.0)).re, -self.omega * there.im)
    }

    /// Its angle at the start, rad.
    pub(super) fn angle(&self) -> f64 {
        self.angle
    }

    /// The same harmonic of the same oscillator at another phase.
    pub(super) fn at(self, size: f64, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        // A negative size is a phase of half a turn.
        let (size, c) = (size.abs(), C64::new(size * cos, size * sin));
        let angle = if c.re * cos + c.im * sin < 0.0 { angle + std::f64::consts::PI } else { angle };
        Self { c, size, angle, ..self }
    }
}

/// Reduces an angle of at most two turns either way to the first turn.
#[inline]
pub(super) fn first_turn_of(angle: f64) -> f64 {
    use std::f64::consts::TAU;
    let mut angle = angle;
    // Cheaper than a division with remainder, which would be exact for any angle.
    while angle < 0.0 {
        angle += TAU;
    }
    while angle >= TAU {
        angle -= TAU;
    }
    angle
}

/// `Re c e^(i (omega u + rate u²/2))` over a span in which `rate u²` stays small.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chirp {
    pub(super) omega: f64,
    pub(super) rate: f64,
    pub(super) c: C64,
}

/// Largest `|rate| u²/2` within one arc: the error with the powers kept is then 1e-17.
pub(super) const CHIRP_SPAN: f64 = 1e-3;
const CHIRP_POWERS: usize = 5;

impl Local {
    #[inline]
    pub(super) fn is_constant(&self) -> bool {
        self.tones.is_empty() && self.slope == 0.0 && self.chirp.is_none()
    }

    /// Sum of the amplitudes.
    pub(super) fn strength(&self) -> f64 {
        self.tones.iter().map(|t| t.size).sum::<f64>() + self.chirp.map_or(0.0, |c| c.c.norm())
    }

    /// `U(u) - U(0)`, its first and its second derivative.
    pub(super) fn rise(&self, u: f64) -> [f64; 3] {
        let mut sum = [self.slope * u, self.slope, 0.0];
        for t in &self.tones {
            let (sin, cos) = (t.omega * u).sin_cos();
            let e = t.c * C64::new(cos, sin);
            sum[0] += e.re - t.c.re;
            sum[1] -= t.omega * e.im;
            sum[2] -= t.omega * t.omega * e.re;
        }
        if let Some(ch) = &self.chirp {
            let (sin, cos) = ((ch.omega + 0.5 * ch.rate * u) * u).sin_cos();
            let e = ch.c * C64::new(cos, sin);
            let w = ch.omega + ch.rate * u;
            sum[0] += e.re - ch.c.re;
            sum[1] -= w * e.im;
            sum[2] -= w * w * e.re + ch.rate * e.im;
        }
        sum
    }

    pub(super) fn slope_at_start(&self) -> f64 {
        let tones: f64 = self.tones.iter().map(|t| -t.omega * t.c.im).sum();
        self.slope + tones + self.chirp.map_or(0.0, |c| -c.omega * c.c.im)
    }

    /// The harmonic, if the drive consists of one harmonic only.
    #[inline]
    pub(super) fn only_tone(&self) -> Option<&Tone> {
        match &self.tones[..] {
            [tone] if self.slope == 0.0 && self.chirp.is_none() && tone.size > 0.0 => Some(tone),
            _ => None,
        }
    }

    /// Time at which `e + U(u) - U(0)` first leaves `[-down, up]`, and the side, if `U` is one harmonic:
    /// `U(u) = Re c e^(i omega u)` reaches the limit at an angle of `±acos`.
    ///
    /// `None` if `U` is anything else, if a crest lies within rounding of a limit, or if the pull starts at a limit:
    /// these cases are left to the search.
    pub(super) fn first_exit(&self, e: f64, [up, down]: [f64; 2]) -> Option<(f64, f64)> {
        let [tone] = self.tones[..] else { return None };
        if self.slope != 0.0 || self.chirp.is_some() {
            return None;
        }
        let a = tone.size;
        let noise = 1e-9 * (a + e.abs() + up + down);
        // Limits on U itself.
        let (high, low) = (up - e + tone.c.re, -down - e + tone.c.re);
        if up - e < noise || down + e < noise || (high - a).abs() < noise || (low + a).abs() < noise {
            return None;
        }
        // If rising, it meets `high` first unless its crest stays below; if falling, `low`.
        let rising = if tone.c.im == 0.0 { tone.c.re < 0.0 } else { tone.c.im < 0.0 };
        let (limit, side) = match (rising, high < a, low > -a) {
            (true, true, _) | (false, true, false) => (high, 1.0),
            (_, _, true) => (low, -1.0),
            (_, false, false) => return None,
        };
        // The cosine rises to a limit at the angle -acos, and falls to it at acos.
        let u = first_turn_of(-side * (limit / a).acos() - tone.angle) / tone.omega;
        // Well below the crest the angle is as accurate as its limit.
        if limit.abs() < 0.9 * a {
            return Some((u, side));
        }
        // One Newton step reduces the rounding error of the angles.
        let [rise, slope, _] = self.rise(u);
        Some((u - (tone.c.re + rise - limit) / slope, side))
    }

    /// Bounds on `|U - U(0)|` and three derivatives of `U`, up to `reach`.
    pub(super) fn bounds(&self, reach: f64) -> [f64; 4] {
        let mut swing = self.slope.abs() * reach;
        let (mut d1, mut d2, mut d3) = (self.slope.abs(), 0.0, 0.0);
        for t in &self.tones {
            let a = t.size;
            swing += (2.0 * a).min(a * t.omega * reach);
            d1 += a * t.omega;
            d2 += a * t.omega * t.omega;
            d3 += a * t.omega * t.omega * t.omega;
        }
        if let Some(c) = &self.chirp {
            let (a, w) = (c.c.norm(), c.omega.abs() + c.rate.abs() * reach);
            swing += (2.0 * a).min(a * w * reach);
            d1 += a * w;
            d2 += a * (w * w + c.rate.abs());
            d3 += a * w * (w * w + 3.0 * c.rate.abs());
        }
        [swing, d1, d2, d3]
    }

    /// `∫ e^(lambda (u - s)) (U(s) - U(0)) ds`, `U(u) - U(0)` and `U'(u)`.
    #[inline]
    pub(super) fn convolved(&self, k: &Constants, u: f64, e_lambda: C64, one: C64) -> (C64, f64, f64) {
        let mut psi = C64::default();
        let (mut rise, mut slope) = (0.0, self.slope);
        for t in &self.tones {
            let (sin, cos) = (t.omega * u).sin_cos();
            let own = t.convolved(u, C64::new(cos, sin), e_lambda, one);
            psi += own.0;
            rise += own.1;
            slope += own.2;
        }
        if self.slope != 0.0 {
            let y = k.lambda * u;
            let ramp = if y.norm_sqr() < 0.49 { phi_2(y) * (u * u) } else { (one - u) / k.lambda };
            psi += ramp * self.slope;
            rise += self.slope * u;
        }
        if let Some(c) = &self.chirp {
            psi += c.convolved(k, u, e_lambda) - one * c.c.re;
            let (sin, cos) = ((c.omega + 0.5 * c.rate * u) * u).sin_cos();
            rise += (c.c * C64::new(cos - 1.0, sin)).re;
            slope -= (c.omega + c.rate * u) * (c.c * C64::new(cos, sin)).im;
        }
        (psi, rise, slope)
    }
}

impl Chirp {
    /// `e^(i rate s²/2)` as a power series in `s²`, with the convolution of each power with the exponential in closed
    /// form.
    fn convolved(&self, k: &Constants, u: f64, e_lambda: C64) -> C64 {
        let mut total = C64::default();
        for (w, c, rate) in [(self.omega, self.c, self.rate), (-self.omega, self.c.conj(), -self.rate)] {
            let z = C64::new(k.delta, w - k.omega_d);
            let moments = moments(z, u);
            let mut factor = C64::new(1.0, 0.0);
            let mut sum = C64::default();
            for p in 0..CHIRP_POWERS {
                sum += factor * moments[2 * p];
                // (i rate u²/2)^p / p!, with u² factored out of the moments.
                factor *= C64::new(0.0, 0.5 * rate * u * u / (p + 1) as f64);
            }
            total += c * sum * (e_lambda * (0.5 * u));
        }
        total
    }
}

/// `∫_0^1 s^n e^(z u s) ds` for n up to `2 (CHIRP_POWERS - 1)`.
fn moments(z: C64, u: f64) -> [C64; 2 * CHIRP_POWERS - 1] {
    const TOP: usize = 2 * CHIRP_POWERS - 2;
    let y = z * u;
    let mut m = [C64::default(); TOP + 1];
    let e = y.exp();
    if y.norm_sqr() > 36.0 {
        m[0] = (e - 1.0) / y;
        for n in 1..=TOP {
            m[n] = (e - m[n - 1] * n as f64) / y;
        }
        return m;
    }
    // The highest by its series, e^y Σ (-y)^k n!/(n+1+k)!; the others by downward recurrence, which is stable.
    let mut term = C64::new(1.0 / (TOP + 1) as f64, 0.0);
    let mut sum = term;
    for k in 1..40 {
        term *= -y / (TOP + 1 + k) as f64;
        sum += term;
        if term.norm_sqr() < 1e-36 * sum.norm_sqr() {
            break;
        }
    }
    m[TOP] = e * sum;
    for n in (1..=TOP).rev() {
        m[n - 1] = (e - y * m[n]) / n as f64;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_agree_across_the_change_of_method() {
        for y in [5.99, 6.01] {
            for angle in [0.0, 0.7, 1.6, 3.0] {
                let z = C64::from_polar(y, angle);
                let m = moments(z, 1.0);
                // Simpson's rule with 4000 panels is accurate enough for 1e-11.
                for (n, value) in m.iter().enumerate() {
                    let f = |s: f64| (z * s).exp() * s.powi(n as i32);
                    let panels = 4000;
                    let h = 1.0 / f64::from(panels);
                    let mut sum = C64::default();
                    for i in 0..panels {
                        let a = f64::from(i) * h;
                        sum += (f(a) + f(a + 0.5 * h) * 4.0 + f(a + h)) * (h / 6.0);
                    }
                    assert!((sum - value).norm() < 1e-11 * z.exp().norm().max(1.0), "{y} {angle} {n}");
                }
            }
        }
    }
}
