//! Curves of levels with a loss in addition to the viscous one.

use super::criteria::LevelCriteria;

/// Dependence on the amplitude of the ratio of a further loss to the viscous one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Growth {
    /// Proportional to the amplitude: drag.
    Square,
    /// Proportional to the square of the amplitude: cubic damping, or a compressive detector.
    Cube,
}

impl Growth {
    pub(super) const ALL: [Self; 2] = [Self::Square, Self::Cube];

    /// The further loss at an amplitude for a coefficient of one.
    pub(super) fn of(self, amplitude: f64) -> f64 {
        let square = amplitude * amplitude;
        if self == Self::Square { square } else { square * amplitude }
    }

    /// The power of the inverse amplitude that is the unit of the coefficient.
    pub(super) fn of_coefficient(self) -> i32 {
        if self == Self::Square { 1 } else { 2 }
    }

    /// Prior odds relative to drag.
    pub(super) fn odds(self, c: &LevelCriteria) -> f64 {
        if self == Self::Square { 1.0 } else { c.cube_odds }
    }

    /// The amplitude for a value `line` of the straight line, and its derivative with respect to that value; `None`
    /// beyond the turning point of the curve.
    pub(super) fn on_curve(self, line: f64, coefficient: f64) -> Option<[f64; 2]> {
        match self {
            Self::Square => {
                let root = (1.0 + 4.0 * coefficient * line).sqrt();
                (root > 0.0).then(|| [2.0 * line / (1.0 + root), 1.0 / root])
            }
            Self::Cube => {
                // Triple-angle formula of the hyperbolic sine, or of the sine.
                let scale = (3.0 * coefficient.abs()).sqrt();
                let argument = 1.5 * scale * line;
                let y = if argument.abs() < LINEAR {
                    line
                } else if coefficient > 0.0 {
                    2.0 * (argument.asinh() / 3.0).sinh() / scale
                } else {
                    2.0 * (argument.asin() / 3.0).sin() / scale
                };
                let rise = 1.0 + 3.0 * coefficient * y * y;
                (rise > 0.0 && y.is_finite()).then(|| [y, 1.0 / rise])
            }
        }
    }
}

/// Argument below which the curve equals its line to the last digit.
const LINEAR: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_solves_its_equation() {
        for growth in Growth::ALL {
            for c in [0.0, 1e-22, 1e-3, 0.3, 40.0, -1e-3, -0.1] {
                for line in [-1e-3, 0.0, 1e-12, 0.01, 0.5, 1.0] {
                    let [y, rise] = growth.on_curve(line, c).unwrap();
                    assert!((y + c * growth.of(y) - line).abs() < 1e-14, "{growth:?} {c} {line}: {y}");
                    let of = |line: f64| growth.on_curve(line, c).unwrap()[0];
                    let slope = (of(line + 1e-6) - of(line - 1e-6)) / 2e-6;
                    assert!((rise - slope).abs() < 1e-6 * slope, "{growth:?} {c} {line}: {rise} {slope}");
                }
            }
            assert!(growth.on_curve(1.0, -1.0).is_none());
        }
    }
}
