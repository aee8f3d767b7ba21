//! Curves of levels that lose more than a viscous force takes.

use super::criteria::LevelCriteria;

/// How a loss beyond the viscous one grows with the amplitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Growth {
    /// In proportion to the amplitude over the viscous one: drag.
    Square,
    /// To its square: cubic damping, or a detector that compresses.
    Cube,
}

impl Growth {
    pub(super) const ALL: [Self; 2] = [Self::Square, Self::Cube];

    /// What is lost at an amplitude, over the coefficient.
    pub(super) fn of(self, amplitude: f64) -> f64 {
        let square = amplitude * amplitude;
        if self == Self::Square { square } else { square * amplitude }
    }

    /// The power of the amplitude whose inverse is the unit of the coefficient.
    pub(super) fn of_coefficient(self) -> i32 {
        if self == Self::Square { 1 } else { 2 }
    }

    /// Before the data, over those of drag.
    pub(super) fn odds(self, c: &LevelCriteria) -> f64 {
        if self == Self::Square { 1.0 } else { c.cube_odds }
    }

    /// The amplitude where the straight line lies at `line`, and its derivative by that; `None` where the curve has turned.
    pub(super) fn on_curve(self, line: f64, coefficient: f64) -> Option<[f64; 2]> {
        match self {
            Self::Square => {
                let root = (1.0 + 4.0 * coefficient * line).sqrt();
                (root > 0.0).then(|| [2.0 * line / (1.0 + root), 1.0 / root])
            }
            Self::Cube => {
                // By the triple angle of the hyperbolic sine, or of the sine.
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

/// Below this the curve lies on its line to the last digit.
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
