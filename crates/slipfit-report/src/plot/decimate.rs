//! Reduces long records to as many points as the screen shows.

use super::figure::Point;

/// Reduces points so that they draw the same picture on `columns` columns: the first, lowest, highest and last of
/// each column, in their order. Short records are returned unchanged.
///
/// ```
/// let wave = (0..1000).map(|i| [f64::from(i), (0.1 * f64::from(i)).sin()]);
/// let drawn = slipfit_report::plot::decimate(wave, [0.0, 999.0], 50);
/// assert!(drawn.len() <= 4 * 51);
/// ```
pub fn decimate(
    points: impl ExactSizeIterator<Item = [f64; 2]>,
    range: [f64; 2],
    columns: usize,
) -> Vec<[f64; 2]> {
    if points.len() <= 4 * columns {
        return points.collect();
    }
    let per_unit = columns as f64 / (range[1] - range[0]);
    let mut kept: Vec<Point> = Vec::with_capacity(4 * columns);
    let mut column = Column::default();
    let mut current = usize::MAX;
    for (order, point) in points.enumerate() {
        let place = ((point[0] - range[0]) * per_unit).max(0.0) as usize;
        if place != current {
            column.drain_into(&mut kept);
            current = place;
        }
        column.add(order, point);
    }
    column.drain_into(&mut kept);
    kept
}

#[derive(Default)]
struct Column {
    /// First, lowest, highest and last point, with their order.
    extremes: Option<[(usize, Point); 4]>,
}

impl Column {
    fn add(&mut self, order: usize, point: Point) {
        let here = (order, point);
        match &mut self.extremes {
            None => self.extremes = Some([here; 4]),
            Some([_, low, high, last]) => {
                if point[1] < low.1[1] {
                    *low = here;
                }
                if point[1] > high.1[1] {
                    *high = here;
                }
                *last = here;
            }
        }
    }

    fn drain_into(&mut self, kept: &mut Vec<Point>) {
        if let Some(mut extremes) = self.extremes.take() {
            extremes.sort_by_key(|e| e.0);
            let mut previous = None;
            for (order, point) in extremes {
                if previous != Some(order) {
                    kept.push(point);
                }
                previous = Some(order);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_outlier_among_many_samples_survives() {
        let n = 1_000_000;
        let points =
            (0..n).map(|i| [f64::from(i), if i == 777_777 { 9.0 } else { (f64::from(i) * 0.1).sin() }]);
        let kept = decimate(points, [0.0, f64::from(n)], 400);
        assert!(kept.len() <= 4 * 401);
        assert!(kept.contains(&[777_777.0, 9.0]));
        assert!(kept.windows(2).all(|w| w[0][0] < w[1][0]));
    }

    #[test]
    fn short_records_pass_whole() {
        let kept = decimate((0..10).map(|i| [f64::from(i), 0.0]), [0.0, 9.0], 100);
        assert_eq!(kept.len(), 10);
    }
}
