//! Touchstone files: scattering parameters of one or two ports over frequency.

use crate::{
    columns::head::Head,
    error::ReadProblem,
    format::Format,
    report::Skipped,
    tables::{arrays, table::LoadedTables},
};

/// Words after `#`: unit of frequency, kind of parameter, form of the pairs.
#[derive(Debug, Clone, PartialEq)]
struct Options {
    unit: &'static str,
    parameter: char,
    form: Form,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    Magnitude,
    Decibel,
    Real,
}

impl Options {
    /// Options in a line such as `# GHz S MA R 50`; `None` for any other remark.
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<String> =
            line.trim().strip_prefix('#')?.split_whitespace().map(str::to_ascii_uppercase).collect();
        let unit = words.iter().find_map(|w| match w.as_str() {
            "HZ" => Some("Hz"),
            "KHZ" => Some("kHz"),
            "MHZ" => Some("MHz"),
            "GHZ" => Some("GHz"),
            _ => None,
        });
        let form = words.iter().find_map(|w| match w.as_str() {
            "MA" => Some(Form::Magnitude),
            "DB" => Some(Form::Decibel),
            "RI" => Some(Form::Real),
            _ => None,
        });
        let parameter = words.iter().find_map(|w| match w.as_str() {
            "S" | "Y" | "Z" | "H" | "G" => w.chars().next(),
            _ => None,
        });
        // A remark above a table has none of these words; missing ones take the defaults of the standard.
        let known = [unit.is_some(), form.is_some(), parameter.is_some()].iter().filter(|k| **k).count();
        (known >= 2).then_some(Self {
            unit: unit.unwrap_or("GHz"),
            parameter: parameter.unwrap_or('S'),
            form: form.unwrap_or(Form::Magnitude),
        })
    }
}

/// Whether a text begins like these files: remarks with `!`, then the options.
pub(crate) fn fits(head: &[u8]) -> bool {
    String::from_utf8_lossy(head)
        .lines()
        .map(str::trim)
        .find(|l| !l.is_empty() && !l.starts_with('!'))
        .is_some_and(|l| Options::parse(l).is_some())
}

/// Reads the network data; noise data after them are left out and counted.
pub(crate) fn tables(bytes: &[u8]) -> Result<LoadedTables, ReadProblem> {
    let text = String::from_utf8_lossy(bytes);
    let (mut options, mut rows, mut skipped) = (None, Vec::<Vec<f64>>::new(), Vec::<Skipped>::new());
    let mut skip =
        |reason: &str, row: usize| match skipped.iter_mut().find(|s: &&mut Skipped| s.reason == reason) {
            Some(s) => s.rows += 1,
            None => skipped.push(Skipped { reason: reason.to_owned(), rows: 1, first_row: row as u64 + 1 }),
        };
    let mut noise = false;
    for (i, line) in text.lines().enumerate() {
        let line = line.split('!').next().unwrap_or_default().trim();
        if line.starts_with('#') {
            options = options.or_else(|| Options::parse(line));
            continue;
        }
        if line.is_empty() || line.starts_with('[') {
            continue;
        }
        let numbers: Option<Vec<f64>> =
            line.split_whitespace().map(|w| w.parse().ok().filter(|v: &f64| v.is_finite())).collect();
        match (numbers, rows.first()) {
            (None, _) => skip("not all cells are numbers", i),
            // Noise data restart at a lower frequency, with five numbers per row.
            (Some(numbers), Some(first)) => {
                noise |= numbers.len() == 5 && first.len() == 9;
                if noise {
                    skip("noise data", i);
                } else if numbers.len() == first.len() {
                    rows.push(numbers);
                } else {
                    skip("another number of cells than the first row", i);
                }
            }
            (Some(numbers), None) => rows.push(numbers),
        }
    }
    let options =
        options.ok_or_else(|| Format::Touchstone.broken("it has no line of options (# Hz S MA R 50)"))?;
    let ports: &[&str] = match rows.first().map(Vec::len) {
        Some(3) => &["11"],
        // Only two-port data are written column by column.
        Some(9) => &["11", "21", "12", "22"],
        Some(n) => {
            return Err(
                Format::Touchstone.broken(format!("rows of {n} numbers; one port has 3, two ports 9"))
            );
        }
        None => return Err(Format::Touchstone.broken("it has no rows of numbers")),
    };
    let mut headers = vec![format!("Frequency ({})", options.unit)];
    for port in ports {
        let name = format!("{}{port}", options.parameter);
        headers.extend(match options.form {
            Form::Magnitude => [format!("{name} magnitude"), format!("{name} phase (deg)")],
            Form::Decibel => [format!("{name} magnitude (dB)"), format!("{name} phase (deg)")],
            Form::Real => arrays::parts(&name),
        });
    }
    let columns = (0..headers.len()).map(|c| rows.iter().map(|r| r[c]).collect()).collect();
    let mut tables = LoadedTables::default();
    tables.push(Head::of(headers), columns, skipped);
    Ok(tables)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_told_from_remarks() {
        let of = |line: &str| Options::parse(line).map(|o| (o.unit, o.parameter, o.form));
        assert_eq!(of("# GHz S MA R 50"), Some(("GHz", 'S', Form::Magnitude)));
        assert_eq!(of("#hz y ri"), Some(("Hz", 'Y', Form::Real)));
        assert_eq!(of("# S DB R 75"), Some(("GHz", 'S', Form::Decibel)));
        for remark in ["# time (s), x (m)", "#", "# Hz", "# measured in S"] {
            assert_eq!(of(remark), None, "{remark}");
        }
        assert!(fits(b"! made by hand\n\n# Hz S RI R 50\n1 2 3\n"));
        assert!(!fits(b"# time,accel_x\n1,2\n"));
    }
}
