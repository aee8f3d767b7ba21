//! Roles of columns without names, from the resonance that fits them.

use slipfit::motion::steady::Phasor;

use super::{chooser::Chooser, units};

/// Maximum residual of an interpretation of the numbers, relative to that of the next best, for it to be accepted. On
/// measured and simulated curves with noise of 1 % and any friction the right one is better by 2.6 and more.
const CLEARLY: f64 = 0.5;
/// Residual of the best fit, relative to the spread of the points, above which there is no usable resonance.
const FITS: f64 = 0.3;
/// Maximum number of points used.
const MOST: usize = 2000;
/// Minimum number of rows for distinguishing a resonance in two parts from amplitudes.
const LEAST: usize = 8;
/// Iterations of the fit of a pole.
const PASSES: usize = 6;

impl Chooser<'_> {
    /// Whether a resonance fits two columns over a third far better as real and imaginary part than as an amplitude or
    /// a level with a phase.
    pub(super) fn are_parts(&self, over: usize, first: usize, second: usize) -> bool {
        let rows = self.rows_of([over, first, second]);
        let residual = |meaning: &dyn Fn(f64, f64) -> Phasor| {
            let points = rows.iter().map(|&[f, a, b]| (f, meaning(a, b))).collect::<Vec<_>>();
            of_pole(&points)
        };
        let parts = residual(&Phasor::new);
        let level = units::from_decibels;
        let linear = rows.iter().all(|[_, a, _]| *a >= 0.0);
        let polar = [1.0, 1f64.to_radians()].into_iter().flat_map(|unit| {
            let of_level = residual(&|a, b| Phasor::from_polar(level(a), b * unit));
            let of_amplitude = linear.then(|| residual(&|a, b| Phasor::from_polar(a, b * unit)));
            [Some(of_level), of_amplitude]
        });
        let polar = polar.flatten().fold(f64::INFINITY, f64::min);
        parts < FITS && parts < CLEARLY * polar
    }

    /// Whether a resonance fits two columns over a third far better as real and imaginary part than either of them
    /// alone as an amplitude.
    pub(super) fn are_parts_not_amplitudes(&self, over: usize, first: usize, second: usize) -> bool {
        let rows = self.rows_of([over, first, second]);
        let parts = of_pole(&rows.iter().map(|&[f, a, b]| (f, Phasor::new(a, b))).collect::<Vec<_>>());
        let amplitude = |k: usize| of_amplitude(&rows.iter().map(|row| (row[0], row[k])).collect::<Vec<_>>());
        rows.len() >= LEAST && parts < FITS && parts < CLEARLY * amplitude(1).min(amplitude(2))
    }

    /// Whether the numbers of a column over another are levels in dB and not amplitudes; `None` if a resonance fits
    /// neither clearly better.
    pub(super) fn fits_decibels(&self, over: usize, column: usize) -> Option<bool> {
        let rows = self.rows_of([over, column, column]);
        let points =
            |linear: fn(f64) -> f64| rows.iter().map(|[f, a, _]| (*f, linear(*a))).collect::<Vec<_>>();
        let level = of_amplitude(&points(units::from_decibels));
        let linear = of_amplitude(&points(|a| a));
        if level < FITS && level < CLEARLY * linear {
            Some(true)
        } else if linear < FITS && linear < CLEARLY * level {
            Some(false)
        } else {
            None
        }
    }

    /// A subset of the rows with a number in all these columns, the first column scaled to -1/2 to 1/2.
    fn rows_of(&self, columns: [usize; 3]) -> Vec<[f64; 3]> {
        let [f, a, b] = columns.map(|c| &self.values[c]);
        let mut rows: Vec<[f64; 3]> = f.iter().zip(a).zip(b).map(|((f, a), b)| [*f, *a, *b]).collect();
        rows.retain(|row| row.iter().all(|v| v.is_finite()));
        let stride = rows.len().div_ceil(MOST).max(1);
        let mut rows: Vec<[f64; 3]> = rows.into_iter().step_by(stride).collect();
        let (low, high) =
            rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r[0]), h.max(r[0])));
        rows.iter_mut().for_each(|row| row[0] = (row[0] - low) / (high - low) - 0.5);
        rows
    }
}

/// Residual of the best fit of a single pole with a linear numerator to complex points, relative to their spread;
/// infinite if there is none.
fn of_pole(points: &[(f64, Phasor)]) -> f64 {
    let mean = points.iter().map(|(_, z)| *z).sum::<Phasor>() / points.len() as f64;
    let spread: f64 = points.iter().map(|(_, z)| (z - mean).norm_sqr()).sum();
    let (mut weights, mut residual) = (vec![1.0; points.len()], f64::INFINITY);
    for _ in 0..PASSES {
        // z (u - a) = b + c u is linear in a, b and c; the weights are the inverse distances to the previous pole.
        let row = |(u, z): &(f64, Phasor), w: f64| [z * w, Phasor::new(w, 0.0), Phasor::new(u * w, 0.0)];
        let rows = points.iter().zip(&weights).map(|(p, w)| (row(p, *w), p.1 * (p.0 * w)));
        let Some([a, b, c]) = least_squares(rows) else { return f64::INFINITY };
        let of = |u: f64| Phasor::new(u, 0.0) - a;
        let left = |(u, z): &(f64, Phasor)| (z - (b + c * u) / of(*u)).norm_sqr();
        residual = (points.iter().map(left).sum::<f64>() / spread).sqrt();
        weights = points.iter().map(|(u, _)| 1.0 / of(*u).norm().max(1e-6)).collect();
    }
    if residual.is_finite() { residual } else { f64::INFINITY }
}

/// Residual of the best fit of a resonance, whose inverse squares are a parabola, to amplitudes, relative to their
/// spread; infinite if one of them is not positive.
fn of_amplitude(points: &[(f64, f64)]) -> f64 {
    let largest = points.iter().map(|(_, a)| *a).fold(0.0, f64::max);
    if points.len() < 4 || points.iter().any(|(_, a)| !(*a > 0.0 && a.is_finite())) {
        return f64::INFINITY;
    }
    let points: Vec<(f64, f64)> = points.iter().map(|(u, a)| (*u, a / largest)).collect();
    let mean = points.iter().map(|(_, a)| a).sum::<f64>() / points.len() as f64;
    let spread: f64 = points.iter().map(|(_, a)| (a - mean).powi(2)).sum();
    let real = |v: f64| Phasor::new(v, 0.0);
    // The error of 1/a^2 is 2/a^3 times that of the amplitude.
    let rows = points.iter().map(|(u, a)| {
        let w = 0.5 * a.powi(3);
        ([real(w), real(w * u), real(w * u * u)], real(w / (a * a)))
    });
    let Some([c, b, a]) = least_squares(rows) else { return f64::INFINITY };
    let left = |(u, amplitude): &(f64, f64)| {
        let inverse = c.re + u * (b.re + u * a.re);
        let fitted = if inverse > 0.0 { inverse.sqrt().recip() } else { 0.0 };
        (amplitude - fitted).powi(2)
    };
    let residual = (points.iter().map(left).sum::<f64>() / spread).sqrt();
    if residual.is_finite() { residual } else { f64::INFINITY }
}

/// Solves linear equations in three complex unknowns by least squares; `None` if they are underdetermined.
fn least_squares(rows: impl Iterator<Item = ([Phasor; 3], Phasor)>) -> Option<[Phasor; 3]> {
    let mut normal = [[Phasor::new(0.0, 0.0); 4]; 3];
    for (row, value) in rows {
        for (i, of) in normal.iter_mut().enumerate() {
            let conjugate = row[i].conj();
            (0..3).for_each(|j| of[j] += conjugate * row[j]);
            of[3] += conjugate * value;
        }
    }
    for column in 0..3 {
        let pivot =
            (column..3).max_by(|a, b| normal[*a][column].norm().total_cmp(&normal[*b][column].norm()))?;
        normal.swap(column, pivot);
        let by = normal[column][column];
        if !(by.norm() > 0.0 && by.norm().is_finite()) {
            return None;
        }
        normal[column].iter_mut().for_each(|v| *v /= by);
        let of = normal[column];
        for (_, row) in normal.iter_mut().enumerate().filter(|(i, _)| *i != column) {
            let times = row[column];
            row.iter_mut().zip(of).for_each(|(v, p)| *v -= times * p);
        }
    }
    Some([normal[0][3], normal[1][3], normal[2][3]])
}
