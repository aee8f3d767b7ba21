//! The page of thresholds in the book is the table of the code.

use slipfit::signal::demodulate;
use slipfit::{Criterion, levels, record, resonance, ringdown, series};
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "\
# Criteria

Every number that decides something in an analysis, in the order of the steps. Numbers without a
unit are counts or ratios, as the meaning says.

";

const CLOCKS: &str = "\
## Clocks

By these the rows of a record are put in order of time when it is made.

";

const RINGDOWN: &str = "
## Ring-downs

A program sets these through `slipfit::ringdown::analyse_with`. Lengths count blocks of some cycles,
samples, or parts of an amplitude.

";

const TRACES: &str = "
## Traces of batches and maps

Of the bare fit of amplitudes, the method `fit`.

";

const RESONANCE: &str = "
## Resonance curves

A program sets these through `slipfit::resonance::analyse_with`.

";

const LEVELS: &str = "
## Drive levels

A program sets these through `slipfit::levels::analyse_with`; of the group `inference`, which is that of the analyses
above, `detected` decides here.

";

const DEMODULATION: &str = "
## Driven records

A program sets these through `slipfit::signal::demodulate::demodulate_with`.

";

const SERIES: &str = "
## Series

A program sets these through `slipfit::series::analyse_with`.

";

fn page() -> String {
    let clocks = table(&record::ClockCriteria::default().table());
    let ringdown = table(&ringdown::Criteria::default().table());
    let traces = table(&ringdown::TraceCriteria::default().table());
    let resonance = table(&resonance::Criteria::default().table());
    let levels = table(&levels::LevelCriteria::default().table());
    let demodulation = table(&demodulate::Criteria::default().table());
    let series = table(&series::Criteria::default().table());
    [
        HEAD,
        CLOCKS,
        &clocks,
        RINGDOWN,
        &ringdown,
        TRACES,
        &traces,
        RESONANCE,
        &resonance,
        LEVELS,
        &levels,
        DEMODULATION,
        &demodulation,
        SERIES,
        &series,
    ]
    .concat()
}

fn table(rows: &[Criterion]) -> String {
    let mut table = "| name | value | meaning | source | moves |\n|---|---|---|---|---|\n".to_owned();
    for row in rows {
        // Two thirds is the only value with many digits.
        let value = if row.value.fract() == 0.0 { row.value.to_string() } else { rounded(row.value) };
        writeln!(
            table,
            "| `{}` | {value} | {} | {} | {} |",
            row.name, row.meaning, row.source, row.statistic
        )
        .expect("a string takes all");
    }
    table
}

fn rounded(value: f64) -> String {
    if value < 1e-3 { format!("{value:e}") } else { format!("{value:.4}").trim_end_matches('0').to_owned() }
}

/// `SLIPFIT_WRITE=1 cargo test --test criteria_table` renews the page.
#[test]
fn the_page_of_criteria_is_the_table_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/criteria.md");
    if std::env::var_os("SLIPFIT_WRITE").is_some() {
        std::fs::write(&path, page()).expect("writable");
    }
    let stored = std::fs::read_to_string(&path).expect("docs/criteria.md").replace("\r\n", "\n");
    assert!(stored == page(), "docs/criteria.md differs from the code: SLIPFIT_WRITE=1 renews it");
}
