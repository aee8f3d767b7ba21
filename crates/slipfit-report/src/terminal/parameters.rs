//! Parameters on the screen.

use super::WIDTH;
use super::table::{Align, columns};
use crate::document::ParameterRow;

/// Parameters on the screen, one line each; an interval goes to the next line if the line is full.
pub(super) fn laid_out(rows: &[ParameterRow]) -> String {
    const MARGIN: usize = 2;
    const RELATIVE: usize = 8;
    let left = Align::Left;
    let align = [left, left, Align::Right, left, left, left];
    // A mark shows where the notes begin.
    let marked = |row: &ParameterRow| cells(row).into_iter().chain(["|".repeat(RELATIVE)]).collect();
    let lines = columns(&rows.iter().map(marked).collect::<Vec<_>>(), &align);
    let mut text = String::new();
    for (line, row) in lines.iter().zip(rows) {
        let filled = line.trim_end_matches('|');
        let place = MARGIN + filled.chars().count();
        let [behind, below] = notes(row);
        let gap = if behind.is_empty() || below.is_empty() { "" } else { "  " };
        let all = format!("{behind}{gap}{below}");
        if place + all.chars().count() <= WIDTH {
            text += format!("{:MARGIN$}{filled}{all}", "").trim_end();
        } else {
            text += format!("{:MARGIN$}{filled}{behind}", "").trim_end();
            let indent = place.min(WIDTH.saturating_sub(below.chars().count()));
            text += &format!("\n{:indent$}{below}", "");
        }
        text.push('\n');
    }
    text
}

fn cells(row: &ParameterRow) -> Vec<String> {
    let uncertainty = match row.uncertainty.as_str() {
        "" => String::new(),
        digits => format!("± {digits}"),
    };
    vec![row.words.clone(), row.symbol.to_owned(), row.value.clone(), uncertainty, row.unit.clone()]
}

/// The notes after the cells, and those that may go to the next line.
fn notes(row: &ParameterRow) -> [String; 2] {
    let relative = format!("{:>8}", row.relative).trim_end().to_owned();
    match (row.absent, row.asymmetric) {
        (true, _) if row.value == "-" => [String::new(), "not in model".to_owned()],
        (true, _) => [String::new(), "95 %, not in model".to_owned()],
        (_, true) => [relative, format!("95 %: {}", row.interval)],
        _ => [relative, String::new()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipfit::{Parameter, Quantity};

    #[test]
    fn an_interval_is_on_the_screen_where_it_is_asymmetric() {
        let mut q = Quantity::normal(1e-4, 1e-4, "rad");
        assert_eq!(notes(&ParameterRow::new(Parameter::InitialAmplitude, &q)), ["   100 %", ""]);
        q.interval_95 = [0.0, 3.1e-4];
        assert_eq!(
            notes(&ParameterRow::new(Parameter::InitialAmplitude, &q)),
            ["   100 %", "95 %: 0 to 310"]
        );
        assert_eq!(ParameterRow::new(Parameter::InitialAmplitude, &q).interval, "0 to 310");
    }

    #[test]
    fn an_interval_goes_below_where_the_line_is_full() {
        let asymmetric = |words: &str| {
            let mut q = Quantity::normal(1e-4, 1e-4, "rad");
            q.interval_95 = [0.0, 3.1e-4];
            ParameterRow {
                words: words.to_owned(),
                symbol: "",
                ..ParameterRow::new(Parameter::InitialAmplitude, &q)
            }
        };
        assert_eq!(laid_out(&[asymmetric("x")]), "  x  100  ± 100  µrad     100 %  95 %: 0 to 310\n");
        let long = "a name as long as those of quantities ever become";
        let text = laid_out(&[asymmetric(long), asymmetric("x")]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert!(lines.iter().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert_eq!(lines[1].trim_start(), "95 %: 0 to 310", "{text}");
        assert_eq!(lines[3], lines[1], "{text}");
    }
}
