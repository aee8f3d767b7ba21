//! The page that compares printed statement, correction and error.

use super::response::Fitted;
use super::ringdowns::{NOISE_M, RingDown, STIFFNESS};
use slipfit::paper::{Measure, Statement};
use std::fmt::Write as _;

pub(super) fn markdown(
    statements: &[Statement],
    notes: &[String],
    ringdowns: &[RingDown],
    fits: &[Fitted],
    seed: u64,
) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write_page(&mut text, statements, notes, ringdowns, fits, seed);
    text
}

fn write_page(
    text: &mut String,
    statements: &[Statement],
    notes: &[String],
    ringdowns: &[RingDown],
    fits: &[Fitted],
    seed: u64,
) -> std::fmt::Result {
    writeln!(
        text,
        "# Effect of sliding friction in harmonic oscillators: print, correction, exact motion\n"
    )?;
    writeln!(
        text,
        "M. V. Vitorino, A. Vieira and M. S. Rodrigues, *Effect of sliding friction in harmonic oscillators*. \
         Every number below was computed by slipfit {} when this page was written: by the printed formula, by \
         the corrected one, and from the exact motion.\n",
        env!("CARGO_PKG_VERSION")
    )?;
    writeln!(text, "## Where the printed text does not hold\n")?;
    writeln!(text, "| where | printed | correct |\n|---|---|---|")?;
    for s in statements {
        writeln!(text, "| {} | {} | {} |", cell(s.place), cell(s.printed), cell(s.holds))?;
    }
    writeln!(text, "\n## Size of the errors\n")?;
    writeln!(
        text,
        "| where | case | quantity | exact | printed | error | corrected | error |\n|---|---|---|---|---|---|---|---|"
    )?;
    for s in statements {
        for Measure { quantity, printed, holds, exact } in &s.measures {
            let measure = Measure { quantity, printed: *printed, holds: *holds, exact: *exact };
            writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} | {} | {} |",
                cell(s.place),
                cell(s.case),
                cell(quantity),
                digits(*exact),
                digits(*printed),
                error(measure.printed_error()),
                digits(*holds),
                error(measure.holds_error()),
            )?;
        }
    }
    writeln!(text, "\n## Fig. 1\n\n![Fig. 1](fig1.svg)\n")?;
    writeln!(text, "Q = 10⁴, driven at ω_0. Numbers: fig1_a.csv to fig1_d.csv.\n")?;
    for note in notes {
        writeln!(text, "- {note}")?;
    }
    writeln!(text, "\n## Fig. 2\n\n![Fig. 2](fig2.svg)\n")?;
    writeln!(text, "Numbers: fig2_a.csv to fig2_d.csv.\n")?;
    writeln!(
        text,
        "Ring-downs, (a) and (b): k = {STIFFNESS} N/m, noise {:.2} nm on X and on Y, seed {seed}; found by \
         `slipfit::ringdown`.\n",
        NOISE_M * 1e9
    )?;
    writeln!(
        text,
        "| load | F (nN) | F found (nN) | γ (µN s/m) | γ found (µN s/m) | stop (ms) |\n|---|---|---|---|---|---|"
    )?;
    for r in ringdowns {
        let [f, g] = &r.found;
        let stop = r.stop_time_s.map_or("none".to_owned(), |t| format!("{:.2}", t * 1e3));
        writeln!(
            text,
            "| {} | {:.1} | {:.2} ± {:.2} | {:.1} | {:.2} ± {:.2} | {stop} |",
            r.load,
            r.coulomb_force * 1e9,
            f.value * 1e9,
            f.std_error * 1e9,
            r.viscous * 1e6,
            g.value * 1e6,
            g.std_error * 1e6,
        )?;
    }
    writeln!(
        text,
        "\nResonance curves, (c): Lorentzians, eq. (14), fitted to the exact curves without noise, and inverted \
         with a = 4/3 as the paper does.\n"
    )?;
    writeln!(
        text,
        "| F (nN) | Q | Q_f fitted | F by a = 4/3 (nN) | Q by a = 4/3 | residual (pm) |\n|---|---|---|---|---|---|"
    )?;
    for f in fits {
        writeln!(
            text,
            "| {:.0} | {:.0} | {:.0} | {:.2} | {:.0} | {:.2} |",
            f.coulomb_force * 1e9,
            f.true_q,
            f.line.effective_q_factor,
            f.inversion.friction_displacement * STIFFNESS * 1e9,
            f.inversion.q_factor,
            f.line.residual_rms * 1e12,
        )?;
    }
    writeln!(text, "\nslipfit {}", env!("CARGO_PKG_VERSION"))
}

/// A bar would end the table cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn digits(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        format!("{value:.4e}")
    } else {
        let text = format!("{value:.6}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

fn error(relative: f64) -> String {
    let size = relative.abs();
    let sign = if relative < 0.0 { "−" } else { "+" };
    match size {
        0.0 => "0".to_owned(),
        s if s < 1e-3 => format!("{sign}{:.0e}", s),
        s => format!("{sign}{:.1} %", 100.0 * s),
    }
}
