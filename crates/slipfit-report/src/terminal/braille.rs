//! A small plot in characters, for the terminal.

/// Rows of text and columns of it.
const ROWS: usize = 9;
const COLUMNS: usize = 66;

/// Dots in one character: two across, four down, as Braille has them.
const DOTS: [[u32; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

/// Plot of values over positions in Braille dots: at each position all dots between the least and the greatest
/// value are set, so that an oscillation too fast to resolve becomes its envelope. Returns the lines from the
/// top, and the least and the greatest value; `None` if there is nothing to draw.
pub(crate) fn plot(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<(Vec<String>, [f64; 2])> {
    let finite = points.filter(|(x, y)| x.is_finite() && y.is_finite());
    let range = |pick: fn(&(f64, f64)) -> f64| {
        finite
            .clone()
            .map(|p| pick(&p))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let ([left, right], [low, high]) = (range(|p| p.0), range(|p| p.1));
    if !(right > left && high > low && (right - left).is_finite() && (high - low).is_finite()) {
        return None;
    }
    let (width, height) = (2 * COLUMNS, 4 * ROWS);
    let place = |v: f64, from: f64, to: f64, dots: usize| {
        (((v - from) / (to - from) * dots as f64) as usize).min(dots - 1)
    };
    let mut spans: Vec<Option<[usize; 2]>> = vec![None; width];
    for (x, y) in finite {
        let (column, row) = (place(x, left, right, width), place(high - y + low, low, high, height));
        let span = spans[column].get_or_insert([row, row]);
        *span = [span[0].min(row), span[1].max(row)];
    }
    let mut cells = vec![[0_u32; COLUMNS]; ROWS];
    for (column, span) in spans.iter().enumerate() {
        let Some([top, bottom]) = span else { continue };
        for row in *top..=*bottom {
            cells[row / 4][column / 2] |= DOTS[row % 4][column % 2];
        }
    }
    let line = |cells: &[u32; COLUMNS]| {
        cells.iter().map(|dots| char::from_u32(0x2800 + dots).unwrap_or(' ')).collect::<String>()
    };
    Some((cells.iter().map(line).collect(), [low, high]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_goes_from_the_lower_left_to_the_upper_right() {
        let (lines, range) = plot((0..1000).map(|i| (f64::from(i), 2.0 * f64::from(i)))).unwrap();
        assert_eq!((lines.len(), range), (ROWS, [0.0, 1998.0]));
        let dots = |line: &str, column: usize| line.chars().nth(column).unwrap() as u32 - 0x2800;
        assert!(dots(&lines[0], COLUMNS - 1) != 0);
        assert!(dots(&lines[ROWS - 1], 0) != 0);
        assert!(dots(&lines[0], 0) == 0);
        assert!(dots(&lines[ROWS - 1], COLUMNS - 1) == 0);
    }

    #[test]
    fn nothing_is_drawn_of_nothing() {
        assert!(plot(std::iter::empty()).is_none());
        assert!(plot([(0.0, 1.0), (1.0, 1.0)].into_iter()).is_none());
        assert!(plot([(0.0, f64::NAN), (f64::INFINITY, 1.0)].into_iter()).is_none());
        assert!(plot([(-1e308, 0.0), (1e308, 1.0)].into_iter()).is_none());
    }
}
