//! The page of thresholds in the book is the table of the code.

use slipfit::ringdown::Criteria;
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "\
# Criteria

Every number that decides something in the analysis of a ring-down, in the order of the steps. A
program sets them through `slipfit::ringdown::analyse_with`. Lengths without a unit count blocks of
some cycles, samples, or parts of an amplitude, as the meaning says.

";

fn page() -> String {
    let mut page = HEAD.to_owned();
    page.push_str("| name | value | meaning | source | moves |\n|---|---|---|---|---|\n");
    for row in Criteria::default().table() {
        // Two thirds are the only value with many digits.
        let value = if row.value.fract() == 0.0 { row.value.to_string() } else { rounded(row.value) };
        writeln!(page, "| `{}` | {value} | {} | {} | {} |", row.name, row.meaning, row.source, row.statistic)
            .expect("a string takes all");
    }
    page
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
