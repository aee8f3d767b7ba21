//! `slipfit paper` and `slipfit atlas`, as users see them.

use crate::common::{slipfit, stdout};
use std::fs;
use std::path::Path;

fn whole(folder: &Path, name: &str) -> String {
    let bytes = fs::read(folder.join(name)).unwrap();
    if name.ends_with(".png") {
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"), "{name}");
        assert!(bytes.len() > 20_000, "{name}");
        return String::new();
    }
    let text = String::from_utf8(bytes).unwrap();
    assert!(!text.contains("NaN"), "{name}");
    assert!(!text.contains(",inf"), "{name}");
    assert!(!text.contains("-inf"), "{name}");
    text
}

#[test]
fn the_paper_is_reproduced_with_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("made/for/it");
    stdout(slipfit().arg("paper").arg("--out").arg(&out));
    for name in ["fig1", "fig2"] {
        whole(&out, &format!("{name}.png"));
        assert!(whole(&out, &format!("{name}.svg")).ends_with("</svg>\n"));
        for letter in ["a", "b", "c", "d"] {
            let table = whole(&out, &format!("{name}_{letter}.csv"));
            assert!(table.lines().count() > 100, "{name}_{letter}");
        }
    }
    let page = whole(&out, "paper.md");
    assert_eq!(page.matches("| eq. (8) off resonance |").count(), 5);
    for said in ["4.205794", "+19.9 %", "−9.1 %", "0.04497", "fig2.svg", "13 nN"] {
        assert!(page.contains(said), "{said}\n{page}");
    }
    // Fig. 2 (d): without friction there is no response at three times the frequency; with friction there is a
    // resonance.
    let table = whole(&out, "fig2_d.csv");
    let of = |curve: &str| -> Vec<f64> {
        let mine = table.lines().filter(|l| l.split(',').next() == Some(curve));
        mine.map(|l| l.rsplit(',').next().unwrap().parse().unwrap()).collect()
    };
    assert!(of("free").iter().all(|a| *a < 1e-9));
    let loaded = of("F = 16 nN");
    let top = loaded.iter().copied().fold(0.0, f64::max);
    assert!(top > 3.0 * loaded[0], "{top} {}", loaded[0]);
    assert!(top > 0.5, "{top} {}", loaded[0]);
    // Every row names its curve, and each fit its load.
    for (name, fits) in [
        ("fig2_a", ["fit of eq. (16), free", "fit of eq. (16), load 9 nN", "fit of eq. (16), load 13 nN"]),
        ("fig2_c", ["Lorentzian fit, free", "Lorentzian fit, F = 16 nN", "Lorentzian fit, F = 48 nN"]),
    ] {
        let table = whole(&out, &format!("{name}.csv"));
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(table.as_bytes());
        let curves: Vec<String> = reader.records().map(|row| row.unwrap()[0].to_owned()).collect();
        assert!(curves.iter().all(|curve| !curve.is_empty()), "{name}");
        for fit in fits {
            assert!(curves.iter().any(|curve| curve == fit), "{name}: {fit}");
        }
    }
    // In the figure one legend entry represents all fits.
    let picture = whole(&out, "fig2.svg");
    assert_eq!(picture.matches("fits of eq. (16)<").count(), 2);
    assert!(!picture.contains("fit of eq. (16), load"), "a row of the legend for each");
    // The same seed, the same bytes.
    let again = folder.path().join("again");
    stdout(slipfit().arg("paper").arg("--out").arg(&again));
    assert_eq!(page, whole(&again, "paper.md"));
}

#[test]
fn the_atlas_covers_its_map() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    stdout(slipfit().arg("atlas").arg("--out").arg(out).args(["--q-points", "8", "--beta-points", "5"]));
    whole(out, "atlas.png");
    whole(out, "atlas.svg");
    let table = whole(out, "atlas.csv");
    let mut lines = table.lines().filter(|l| !l.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let cells: Vec<Vec<&str>> = lines.map(|l| l.split(',').collect()).collect();
    assert_eq!(cells.len(), 40);
    assert!(cells.iter().all(|c| c.len() == names.len()));
    let column = |name: &str| names.iter().position(|n| *n == name).unwrap();
    assert_eq!((cells[0][0], cells[39][1]), ("2", "0.99"));
    assert!(cells.iter().all(|c| ["closed_form", "shooting", "full_stick"].contains(&c[column("way")])));
    // Without friction eqs. (8) and (14) are exact.
    for c in &cells[..8] {
        assert!(c[column("leading_flank_error")].parse::<f64>().unwrap() < 1e-9, "{c:?}");
    }
    // At high Q and moderate beta, eq. (8) is good and (14) is not.
    let c = &cells[2 * 8 + 7];
    assert!(c[column("leading_flank_error")].parse::<f64>().unwrap() < 1e-4, "{c:?}");
    assert!(c[column("lorentzian_flank_error")].parse::<f64>().unwrap() > 1e-2, "{c:?}");
}
