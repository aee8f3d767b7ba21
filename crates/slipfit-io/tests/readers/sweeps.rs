//! Resonance curves as written in laboratories.

use slipfit::answer::hint::{HintValue, spelled};
use slipfit_io::{
    LevelReading, ReadError, ReadOptions, ReadProblem, SweepReading, read_levels_from, read_sweep_from,
};

fn read(text: &str) -> SweepReading {
    with(text, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn with(text: &str, options: &ReadOptions) -> Result<SweepReading, ReadError> {
    read_sweep_from(text.as_bytes(), "sweep.csv", options)
}

fn hint_of(error: &ReadError) -> String {
    spelled(&error.hints(), &|option, value| match value {
        Some(value) => format!("{option} = {value}"),
        None => option.to_owned(),
    })
}

fn close(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len());
    for (f, w) in found.iter().zip(wanted) {
        assert!((f - w).abs() <= 1e-9 * w.abs().max(1e-9), "{found:?} for {wanted:?}");
    }
}

fn phases_deg(reading: &SweepReading) -> Vec<f64> {
    let slipfit::resonance::Response::Complex(z) = reading.curve.response() else { panic!("no phase") };
    z.iter().map(|z| z.arg().to_degrees()).collect()
}

fn amplitudes(reading: &SweepReading) -> Vec<f64> {
    (0..reading.curve.len()).map(|i| reading.curve.response().amplitude(i)).collect()
}

#[test]
fn frequencies_come_in_every_unit() {
    use std::f64::consts::TAU;
    for (header, numbers, wanted) in [
        ("f (Hz)", ["9", "10", "11"], [9.0, 10.0, 11.0]),
        ("Freq [kHz]", ["0.009", "0.01", "0.011"], [9.0, 10.0, 11.0]),
        ("MHz", ["9", "10", "11"], [9e6, 1e7, 1.1e7]),
        ("f_mHz", ["9", "10", "11"], [9e-3, 1e-2, 1.1e-2]),
        ("omega (rad/s)", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("omega", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("rpm", ["540", "600", "660"], [9.0, 10.0, 11.0]),
        ("\u{3c9} [1/s]", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("\u{3c9} in 1/s", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("omega (s^-1)", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("Kreisfrequenz in 1/s", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("angular frequency (s-1)", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("Erregerkreisfrequenz \u{3c9}/(1/s)", ["9", "10", "11"], [9.0 / TAU, 10.0 / TAU, 11.0 / TAU]),
        ("f in 1/s", ["9", "10", "11"], [9.0, 10.0, 11.0]),
        ("f (1/s)", ["9", "10", "11"], [9.0, 10.0, 11.0]),
        ("frequency (s^-1)", ["9", "10", "11"], [9.0, 10.0, 11.0]),
        ("Drive frequency (Hz)", ["9", "10", "11"], [9.0, 10.0, 11.0]),
        ("f_exc", ["9", "10", "11"], [9.0, 10.0, 11.0]),
        ("Erregerfrequenz", ["9", "10", "11"], [9.0, 10.0, 11.0]),
        ("T (s)", ["0.5", "0.4", "0.25"], [2.0, 2.5, 4.0]),
        ("Period (ms)", ["500", "400", "250"], [2.0, 2.5, 4.0]),
        ("frequency", ["9", "10", "11"], [9.0, 10.0, 11.0]),
    ] {
        let rows: String = numbers.iter().zip([1, 3, 2]).map(|(f, a)| format!("{f},{a}\n")).collect();
        let reading = read(&format!("{header},amp\n{rows}"));
        close(reading.curve.frequency_hz(), &wanted);
        close(&amplitudes(&reading), &[1.0, 3.0, 2.0]);
    }
}

#[test]
fn shifts_are_counted_from_their_centre() {
    let rows = "-1,2\n0,5\n1,2\n";
    let beside = read(&format!("# Center Frequency (kHz) = 30\nFrequency Shift (Hz),Amplitude (m)\n{rows}"));
    close(beside.curve.frequency_hz(), &[29_999.0, 30_000.0, 30_001.0]);
    let column = read("Frequency Shift (Hz),Center Frequency (Hz),Amplitude (m)\n-1,50,2\n0,50,5\n1,50,2\n");
    close(column.curve.frequency_hz(), &[49.0, 50.0, 51.0]);
    assert_eq!(column.report.column("centre").unwrap().column.number, 2);
    let given = ReadOptions { centre_hz: Some(100.0), ..Default::default() };
    close(with(&format!("df,A\n{rows}"), &given).unwrap().curve.frequency_hz(), &[99.0, 100.0, 101.0]);
    let error = with(&format!("df,A\n{rows}"), &ReadOptions::default()).unwrap_err();
    assert!(matches!(error.problem, ReadProblem::NoCentre { .. }), "{error}");
    assert!(hint_of(&error).contains("centre_hz"));
}

#[test]
fn amplitudes_come_as_numbers_levels_and_powers() {
    for (header, unit, wanted) in [
        ("R (V)", "V", 20.0),
        ("S21 (dB)", "", 10.0),
        ("level [dBm]", "√mW", 10.0),
        ("power (mW)", "√mW", 20f64.sqrt()),
        ("Power (a.u.)", "", 20f64.sqrt()),
        ("|A|^2", "", 20f64.sqrt()),
        ("A^2 (nm^2)", "nm", 20f64.sqrt()),
        ("R² (V²)", "V", 20f64.sqrt()),
        ("db:Trc1_S21", "", 10.0),
        ("amplitude in mm", "mm", 20.0),
    ] {
        let reading = read(&format!("f (Hz),{header}\n9,1\n10,20\n11,2\n"));
        close(&amplitudes(&reading)[1..2], &[wanted]);
        assert_eq!(reading.curve.unit(), unit);
    }
    for (header, says) in [("|A|^2", true), ("Power (V)", true), ("intensity", true), ("A (V)", false)] {
        let reading = read(&format!("f (Hz),{header}\n9,1\n10,20\n11,2\n"));
        let said =
            reading.report.notes.iter().any(|n| n.text.contains("square root") || n.text.contains("powers"));
        assert_eq!(said, says, "{header}: {:?}", reading.report.notes);
    }
    let options = ReadOptions { unit: Some("dB".into()), ..Default::default() };
    let reading = with("f (Hz),A\n9,-20\n10,0\n11,-20\n", &options).unwrap();
    close(&amplitudes(&reading), &[0.1, 1.0, 0.1]);
}

#[test]
fn phases_come_in_degrees_and_radians_wrapped_or_not() {
    let degrees = [-10.0, -90.0, -170.0];
    for (header, numbers) in [
        ("phase (deg)", ["-10", "-90", "-170"]),
        ("phi [°]", ["350", "270", "-530"]),
        ("phase", ["-10", "-90", "-170"]),
        ("Phase (rad)", ["-0.174532925199", "-1.570796326795", "-2.967059728390"]),
        ("theta (rad)", ["-0.174532925199", "4.712388980385", "3.316125578790"]),
        ("\u{398}", ["-10", "-90", "-170"]),
        ("Ang", ["-10", "-90", "-170"]),
        ("Angle", ["-10", "-90", "-170"]),
        ("deg", ["-10", "-90", "-170"]),
        ("S21(DEG)", ["-10", "-90", "-170"]),
        ("ang:Trc1_S21", ["-10", "-90", "-170"]),
    ] {
        let rows: String = numbers.iter().zip([9, 10, 11]).map(|(p, f)| format!("{f},1,{p}\n")).collect();
        let reading = read(&format!("f (Hz),R,{header}\n{rows}"));
        for (found, wanted) in phases_deg(&reading).iter().zip(degrees) {
            assert!((found - wanted).abs() < 1e-6, "{header}: {found} for {wanted}");
        }
    }
}

#[test]
fn complex_responses_come_in_parts() {
    for header in [
        "f,Re(X),Im(X)",
        "f (Hz),X (V),Y (V)",
        "frequency,real,imag",
        "f,inphase,quadrature",
        "f,re:Trc1_S21,im:Trc1_S21",
        "Drive frequency (Hz),In-phase (V),Out-of-phase (V)",
        "f,Demod x,Demod y",
        "f,Input 1 X (V),Input 1 Y (V)",
        "f,I,Q",
        "f,elastic,absorptive",
    ] {
        let reading = read(&format!("{header}\n9,1,-0.1\n10,0,-5\n11,-1,-0.1\n"));
        let slipfit::resonance::Response::Complex(z) = reading.curve.response() else { panic!("{header}") };
        assert_eq!((z[1].re, z[1].im), (0.0, -5.0), "{header}");
    }
    let half = with("f,Re(X)\n9,1\n10,0\n", &ReadOptions { real: Some("2".into()), ..Default::default() });
    assert!(matches!(half.unwrap_err().problem, ReadProblem::HalfComplex { .. }));
}

#[test]
fn a_touchstone_file_of_real_and_imaginary_parts_has_phases() {
    let text = "! by hand\n# Hz S RI R 50\n9 1 -0.1\n10 0 -5\n11 -1 -0.1\n";
    let slipfit::resonance::Response::Complex(z) = read(text).curve.response().clone() else { panic!() };
    assert_eq!((z[1].re, z[1].im), (0.0, -5.0));
}

#[test]
fn a_reflection_is_told_with_the_transmission_beside_it() {
    let row = |ports: usize| {
        let row = move |k: usize| {
            let f = 990.0 + 0.1 * k as f64;
            let (re, im) = (1.0, 100.0 * (f / 1000.0 - 1000.0 / f));
            let size = re * re + im * im;
            let through = format!("{:.9} {:.9}", re / size, -im / size);
            let back = format!("{:.9} {:.9}", 1.0 - re / size, im / size);
            let all = [back.as_str(), &through, &through, &back];
            format!("{f:.2} {}\n", all[..ports * ports].join(" "))
        };
        (0..201).map(row).collect::<String>()
    };
    let told = |text: &str, options: &ReadOptions| {
        let spell = |option: &str, value: Option<&HintValue>| match value {
            Some(value) => format!("{option} = {value}"),
            None => option.to_owned(),
        };
        let notes = with(text, options).unwrap().report.notes;
        notes.iter().map(|note| note.spelled(&spell)).collect::<Vec<_>>().join("\n")
    };
    let (one, two) = (row(1), row(2));
    let of_one = told(&format!("# HZ S RI R 50\n{one}"), &ReadOptions::default());
    assert!(of_one.contains("column 2 `S11 in-phase` is a reflection"), "{of_one}");
    assert!(of_one.contains("a transmission (S21) has no such background"), "{of_one}");
    let of_two = told(&format!("# HZ S RI R 50\n{two}"), &ReadOptions::default());
    assert!(of_two.contains("real = 4 reads the transmission, column 4 `S21 in-phase`"), "{of_two}");
    assert!(of_two.contains("imaginary = 5 its other part, column 5 `S21 quadrature`"), "{of_two}");
    let through =
        ReadOptions { real: Some("4".into()), imaginary: Some("5".into()), ..ReadOptions::default() };
    assert!(!told(&format!("# HZ S RI R 50\n{two}"), &through).contains("reflection"));
    assert!(!told(&format!("# HZ Y RI R 50\n{one}"), &ReadOptions::default()).contains("reflection"));
}

#[test]
fn an_angle_that_has_a_peak_is_no_phase() {
    let reading = read("f (Hz),A (V),angle\n9,1,0.1\n10,5,2\n11,1,0.1\n");
    assert!(matches!(reading.curve.response(), slipfit::resonance::Response::Amplitude(_)));
    let of_one_name = read("f (Hz),H_dB,H_deg\n9,0,-10\n10,20,-90\n11,0,-170\n");
    close(&amplitudes(&of_one_name), &[1.0, 10.0, 1.0]);
    assert!((phases_deg(&of_one_name)[2] + 170.0).abs() < 1e-9);
}

#[test]
fn ratios_of_frequencies_ask_for_what_one_stands_for() {
    let text = "f/f0,A/A0\n0.9,0.2\n1,1\n1.1,0.2\n";
    let error = with(text, &ReadOptions::default()).unwrap_err();
    assert!(matches!(error.problem, ReadProblem::FrequencyRatio { .. }), "{error}");
    assert!(hint_of(&error).contains("frequency_unit says what 1 stands for"), "{}", hint_of(&error));
    let given = |unit: &str| ReadOptions { frequency_unit: Some(unit.into()), ..Default::default() };
    close(with(text, &given("80 Hz")).unwrap().curve.frequency_hz(), &[72.0, 80.0, 88.0]);
    close(with(text, &given("Hz")).unwrap().curve.frequency_hz(), &[0.9, 1.0, 1.1]);
    let beside = read("f/f0,f (Hz),A\n0.9,9,0.2\n1,10,1\n1.1,11,0.2\n");
    close(beside.curve.frequency_hz(), &[9.0, 10.0, 11.0]);
}

#[test]
fn drives_and_standard_errors_are_taken_along() {
    let reading =
        read("f (Hz),amp (mm),amp_err,drive (V),temp\n9,1,0.1,2,20\n10,3,0.1,2,20\n11,1,0.2,3,21\n");
    assert_eq!(reading.curve.drive(), Some(&[2.0, 2.0, 3.0][..]));
    assert_eq!(reading.curve.std_error(), Some(&[0.1, 0.1, 0.2][..]));
    assert!(reading.report.notes.iter().any(|n| n.text.contains("not used: column 5 `temp`")));
}

#[test]
fn a_quartz_is_read_by_its_admittance() {
    use std::f64::consts::TAU;
    let reading = read("f (MHz),Gp,Bp\n9,1e-4,1e-3\n10,2e-2,1e-3\n11,1e-4,-1e-3\n");
    let slipfit::resonance::Response::Complex(z) = reading.curve.response() else { panic!() };
    // Y/(i omega): a conductance of 20 mS lags by a quarter period.
    assert!((z[1].im * TAU * 1e7 + 2e-2).abs() < 1e-12);
    assert!((z[1].re * TAU * 1e7 - 1e-3).abs() < 1e-12);
    let alone = read("f (MHz),Rs (Ohm)\n9,1\n10,100\n11,4\n");
    let a = amplitudes(&alone);
    assert!((a[2] / a[1] - 0.2 * 10.0 / 11.0).abs() < 1e-12);
    assert!(alone.report.notes.iter().any(|n| n.text.contains("is given without its other part")));
}

#[test]
fn a_quartz_gives_the_same_capacitance_in_any_unit() {
    let complex = |reading: &SweepReading| {
        assert_eq!(reading.curve.unit(), "F");
        let slipfit::resonance::Response::Complex(z) = reading.curve.response() else { panic!() };
        z.iter().flat_map(|z| [z.re, z.im]).collect::<Vec<f64>>()
    };
    let table = |head: &str, [a, b]: [f64; 2]| {
        let row = |(f, re, im): (f64, f64, f64)| format!("{f},{},{}\n", re * a, im * b);
        let rows = [(9.0, 1e-4, 1e-3), (10.0, 2e-2, 1e-3), (11.0, 1e-4, -1e-3)].map(row);
        format!("f (MHz),{head}\n{}", rows.concat())
    };
    let close = |found: &[f64], wanted: &[f64], head: &str| {
        let near = |(f, w): (&f64, &f64)| (f - w).abs() <= 1e-9 * w.abs();
        assert!(found.iter().zip(wanted).all(near), "{head}: {found:?} for {wanted:?}");
    };
    let wanted = complex(&read(&table("G (S),B (S)", [1.0; 2])));
    for (head, factors) in [
        ("G (mS),B (mS)", [1e3; 2]),
        ("G (\u{b5}S),B (\u{3bc}S)", [1e6; 2]),
        ("Gp (uS),Bp", [1e6; 2]),
        ("Gp (S),Bp (mS)", [1.0, 1e3]),
    ] {
        close(&complex(&read(&table(head, factors))), &wanted, head);
    }
    let options = ReadOptions { unit: Some("mS".into()), ..Default::default() };
    close(&complex(&with(&table("Gp,Bp", [1e3; 2]), &options).unwrap()), &wanted, "--unit mS");
    let [ohm, kilo] = [("Rs (Ohm),Xs (Ohm)", 1.0), ("Rs (k\u{3a9}),Xs (k\u{3a9})", 1e-3)]
        .map(|(head, factor)| complex(&read(&table(head, [factor; 2]))));
    close(&kilo, &ohm, "impedance");
    let [siemens, milli] = [("G (S),none", 1.0), ("G (mS),none", 1e3)]
        .map(|(head, factor)| amplitudes(&read(&table(head, [factor, 1.0]))));
    close(&milli, &siemens, "alone");
}

#[test]
fn velocities_and_accelerations_become_displacements() {
    let text = "f (Hz),velocity amplitude (mm/s)\n9,1\n10,62.83185307179586\n11,1\n";
    let reading = read(text);
    close(&amplitudes(&reading)[1..2], &[1.0]);
    assert_eq!((reading.curve.unit(), reading.report.kind), ("mm", slipfit::SignalKind::Velocity));
    let options = ReadOptions { kind: Some(slipfit::SignalKind::Displacement), ..Default::default() };
    close(&amplitudes(&with(text, &options).unwrap())[..1], &[1.0]);
}

#[test]
fn several_curves_in_groups_of_columns_offer_a_choice() {
    let text = "f (Hz),A (mm),f (Hz),A (mm)\n9,1,19,4\n10,2,20,5\n11,1,,\n";
    assert_eq!(read(text).curve.frequency_hz(), [9.0, 10.0, 11.0]);
    let second = with(text, &ReadOptions { run: Some(2), ..Default::default() }).unwrap();
    assert_eq!(second.curve.frequency_hz(), [19.0, 20.0]);
    assert_eq!(second.report.rows_skipped(), 1);
    let third = with(text, &ReadOptions { run: Some(3), ..Default::default() }).unwrap_err();
    assert!(matches!(third.problem, ReadProblem::Option { option: "run", .. }));
}

#[test]
fn rows_without_a_number_are_counted() {
    let reading = read("f,A\n9,1\n10,nan\n11,\n12,4\n13,oops\n");
    assert_eq!((reading.curve.len(), reading.report.rows_read, reading.report.rows_skipped()), (2, 2, 3));
}

#[test]
fn what_is_no_curve_is_refused_with_a_hint() {
    let problem = |text: &str| {
        let error = with(text, &ReadOptions::default()).unwrap_err();
        (error.to_string(), hint_of(&error))
    };
    let (said, hint) = problem("f,A\n9,1\n-10,2\n11,1\n");
    assert!(said.contains("shifts"), "{said} {hint}");
    assert!(hint.contains("centre_hz"), "{said} {hint}");
    let (said, hint) = problem("f,A\n9,1\n10,-2\n11,1\n");
    assert!(said.contains("row 3"), "{said} {hint}");
    assert!(said.contains("`A`"), "{said} {hint}");
    assert!(hint.contains("unit = dB"), "{said} {hint}");
    let (said, hint) = problem("t (s),x (mm)\n0,1\n0.1,-2\n0.2,1\n");
    assert!(said.contains("not a resonance curve"), "{said} {hint}");
    assert!(hint.contains("ringdown"), "{said} {hint}");
    let (said, hint) = problem("phase (deg),A\n9,1\n10,2\n11,1\n");
    assert!(said.contains("no column of frequencies"), "{said} {hint}");
    assert!(hint.contains("frequency"), "{said} {hint}");
    let (said, hint) = problem("drive/V,A/mA\n1,1.3\n2,2.6\n3,3.8\n");
    assert!(said.contains("no column of frequencies"), "{said} {hint}");
    assert!(hint.starts_with("analysis = levels reads amplitudes over drive levels"), "{said} {hint}");
    let (said, hint) = problem("f (Hz),phase (deg)\n9,1\n10,2\n11,1\n");
    assert!(said.contains("could be the amplitude"), "{said} {hint}");
    assert!(hint.contains("amplitude"), "{said} {hint}");
    let units = ReadOptions { frequency_unit: Some("horses".into()), ..Default::default() };
    let error = with("f,A\n9,1\n10,2\n", &units).unwrap_err();
    assert!(hint_of(&error).contains("MHz"));
}

fn levels(text: &str) -> LevelReading {
    read_levels_from(text.as_bytes(), "levels.csv", &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn levels_of_two_parts_are_their_modulus() {
    for header in [
        "Drive (V),X (V),Y (V)",
        "U_exc,Demod x,Demod y",
        "F (N),Re,Im",
        "F0 (mN),In-phase (V),Out-of-phase (V)",
    ] {
        let reading = levels(&format!("{header}\n1,-3,4\n2,6,-8\n3,-9,12\n4,12,-16\n"));
        close(reading.levels.amplitude(), &[5.0, 10.0, 15.0, 20.0]);
        close(reading.levels.drive(), &[1.0, 2.0, 3.0, 4.0]);
        let taken =
            ["drive", "real", "imaginary"].map(|what| reading.report.column(what).unwrap().column.number);
        assert_eq!(taken, [1, 2, 3], "{header}");
    }
    let beside = levels("Drive (V),X (V),Y (V),R (V)\n1,-3,4,5\n2,6,-8,10\n3,-9,12,15\n");
    assert_eq!(beside.report.column("amplitude").unwrap().column.number, 4);
    let text = "a,b,c\n1,-3,4\n2,6,-8\n3,-9,12\n";
    let asked = |real: Option<&str>, imaginary: Option<&str>| ReadOptions {
        real: real.map(str::to_owned),
        imaginary: imaginary.map(str::to_owned),
        ..Default::default()
    };
    let both = read_levels_from(text.as_bytes(), "l.csv", &asked(Some("2"), Some("3"))).unwrap();
    close(both.levels.amplitude(), &[5.0, 10.0, 15.0]);
    let half = read_levels_from(text.as_bytes(), "l.csv", &asked(None, Some("3"))).unwrap_err();
    assert!(matches!(half.problem, ReadProblem::HalfComplex { .. }), "{half}");
}

#[test]
fn an_amplitude_is_not_read_from_the_column_of_the_drive() {
    let read = |text: &str, drive: Option<&str>| {
        let options = ReadOptions {
            amplitude: Some("1".to_owned()),
            drive: drive.map(str::to_owned),
            ..ReadOptions::default()
        };
        read_levels_from(text.as_bytes(), "l.csv", &options)
    };
    let nameless = "5,1\n10,2\n15,3\n";
    let other = read(nameless, None).unwrap();
    close(other.levels.drive(), &[1.0, 2.0, 3.0]);
    close(other.levels.amplitude(), &[5.0, 10.0, 15.0]);
    let named = "drive (V),R (V)\n1,5\n2,10\n3,15\n";
    for (text, drive, column) in [(nameless, Some("1"), "column 1"), (named, None, "column 1 `drive (V)`")] {
        let refused = read(text, drive).unwrap_err().to_string();
        assert!(refused.contains(&format!("amplitude = 1: {column} is also the drive")), "{refused}");
    }
}

#[test]
fn drive_levels_come_one_a_row_or_one_a_curve() {
    let plain = levels("drive amplitude (nm),amplitude (nm),phase (deg)\n0.1,0,0\n0.2,3,-90\n0.3,8,-90\n");
    assert_eq!(plain.levels.drive(), [0.1, 0.2, 0.3]);
    assert_eq!(plain.levels.amplitude(), [0.0, 3.0, 8.0]);
    assert_eq!((plain.levels.unit(), plain.levels.drive_unit()), ("nm", "nm"));
    let curves = levels(
        "force (N),f (Hz),R (V)\n1,9,0.1\n1,10,0.5\n1,11,0.2\n2,9,0.3\n2,10,1.6\n2,11,0.4\n3,9,1\n3,10,2.9\n3,11,0\n",
    );
    assert_eq!(curves.levels.amplitude(), [0.5, 1.6, 2.9]);
    assert!(
        curves.report.notes.iter().any(|n| n.text.contains("largest amplitude at each of 3 drive levels"))
    );
}

/// The peak lies between the points: the largest amplitude is 5 to 10 % low.
#[test]
fn levels_that_are_curves_are_as_high_as_their_resonance() {
    let mut text = String::from("drive (V),f (Hz),R (nm)\n");
    for level in [1.0, 2.0, 3.0] {
        for i in 0..14 {
            let f = 96.7 + 0.5 * f64::from(i);
            let (r, q) = (f / 100.0, 50.0);
            text += &format!("{level},{f},{}\n", level / (1.0 - r * r).hypot(r / q));
        }
    }
    let read = levels(&text);
    for (drive, amplitude) in read.levels.drive().iter().zip(read.levels.amplitude()) {
        assert!((amplitude / (50.0 * drive) - 1.0).abs() < 1e-3, "{drive}: {amplitude}");
    }
    let said = "height of the resonance fitted at each of 3 drive levels";
    assert!(read.report.notes.iter().any(|n| n.text.contains(said)));
}

/// Rows of a curve over 41 frequencies around 100 Hz.
fn curve_rows(row: impl Fn(f64, f64) -> String) -> String {
    (0..41)
        .map(|i| 99.0 + 0.05 * f64::from(i))
        .map(|f| row(f, 1.0 / (1.0 + (20.0 * (f - 100.0)).powi(2)).sqrt()))
        .collect()
}

#[test]
fn a_drive_that_strays_is_one_level_and_a_single_curve_is_none() {
    let mut text = String::from("f (Hz),force (N),amplitude (mm)\n");
    for level in [0.2, 0.5, 1.0, 1.7] {
        text += &curve_rows(|f, a| format!("{f},{},{}\n", level * (1.0 + 0.02 * (7.0 * f).sin()), level * a));
    }
    let read = levels(&text);
    assert_eq!(read.levels.drive().len(), 4, "{:?}", read.levels.drive());
    let one = curve_rows(|f, a| format!("{f},{},{a}\n", 1.0 + 0.2 * (7.0 * f).sin()));
    let said = levels_refused(&format!("f (Hz),force (N),amplitude (mm)\n{one}"));
    assert!(said.contains("resonance curve"), "{said}");
    // Levels with shifted resonances remain levels.
    let rows: String = (1..9).map(|i| format!("{},{i},{}\n", 100.0 - 0.1 * f64::from(i), 3 * i)).collect();
    assert_eq!(levels(&format!("f (Hz),force (N),amplitude (mm)\n{rows}")).levels.drive().len(), 8);
}

fn refused(text: &str) -> String {
    let error = with(text, &ReadOptions::default()).unwrap_err();
    format!("{error}; {}", hint_of(&error))
}

fn levels_refused(text: &str) -> String {
    let error = read_levels_from(text.as_bytes(), "levels.csv", &ReadOptions::default()).unwrap_err();
    format!("{error}; {}", hint_of(&error))
}

#[test]
fn a_record_over_time_is_no_table_of_levels() {
    let rows: String =
        (0..50).map(|i| format!("{},{}\n", 0.1 * f64::from(i), f64::from(i).cos().abs())).collect();
    let said = levels_refused(&format!("Zeit t / s,Winkel / rad\n{rows}"));
    assert!(said.contains("holds times"), "{said}");
    assert!(!said.contains("frequency "), "{said}");
}

#[test]
fn slips_below_zero_are_left_out_and_counted() {
    let rows = curve_rows(|f, a| format!("{f},{a}\n"));
    let slip = read(&format!("f (Hz),amplitude (mm)\n-99.5,0.1\n{rows}"));
    assert_eq!((slip.curve.len(), slip.report.rows_skipped()), (41, 1));
    assert_eq!(slip.report.skipped[0].reason, "frequency below zero");
    let periods = |sign: f64| curve_rows(|f, a| format!("{},{a}\n", sign / f));
    let slip = read(&format!("T (s),amplitude (mm)\n-0.01,0.1\n{}", periods(1.0)));
    assert_eq!(slip.report.skipped[0].reason, "period below zero");
    let said = refused(&format!("T (s),amplitude (mm)\n{}", periods(-1.0)));
    assert!(said.contains("period -"), "{said}");
    assert!(said.contains("below zero"), "{said}");
    let shifts = curve_rows(|f, a| format!("{},{a}\n", f - 100.0));
    assert!(refused(&format!("f (Hz),amplitude (mm)\n{shifts}")).contains("shifts"));
}

#[test]
fn one_frequency_is_no_curve() {
    for (f, word) in [("0", "is 0 Hz in all of 41 points"), ("32000", "is 32000 Hz in all of 41 points")] {
        let rows = curve_rows(|_, a| format!("{f},{a}\n"));
        let said = refused(&format!("f (Hz),amplitude (mm)\n{rows}"));
        assert!(said.contains(word), "{said}");
    }
}

#[test]
fn a_conductance_asked_for_is_read_with_its_susceptance() {
    let rows = curve_rows(|f, a| format!("{f},{},{},{a},45\n", a * a, a));
    let text = format!("f (Hz),Gp,Bp,|Zs|,<Zs\n{rows}");
    let read = with(&text, &ReadOptions { amplitude: Some("Gp".into()), ..Default::default() }).unwrap();
    assert!(read.report.column("phase").is_none());
    assert!(read.report.column("susceptance").is_some());
}

/// Series resistance and reactance of a quartz with viscous loss only, and constant noise in both.
fn quartz_impedance(seed: u64) -> String {
    let mut state = seed;
    // Sum of twelve uniform numbers: variance 1.
    let mut noise = || {
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    };
    let (resistance, f_0, q) = (100.0, 1000.0, 500.0);
    let mut text = String::from("f (Hz),Rs (Ohm),Xs (Ohm)\n");
    for i in 0..=200 {
        let f = f_0 + 0.08 * f64::from(i - 100);
        let reactance = resistance * q * (f / f_0 - f_0 / f);
        text += &format!("{f},{},{}\n", resistance + 4.0 * noise(), reactance + 4.0 * noise());
    }
    text
}

#[test]
fn noise_in_an_impedance_gives_no_friction() {
    for seed in 1..=6 {
        let reading = read(&quartz_impedance(seed));
        let errors = reading.curve.std_error().unwrap();
        assert!(errors[100] > 3.0 * errors[0], "{errors:?}");
        let answer = slipfit::resonance::analyse(&reading.curve, &Default::default()).unwrap();
        assert!(!answer.sliding.detected, "seed {seed}: {:?}", answer.sliding);
    }
}

#[test]
fn errors_written_as_differentials_are_taken() {
    for header in ["dA", "\u{394}A", "u_A", "s_A"] {
        let rows = (0..30).map(|i| {
            let f = 90.0 + 0.7 * f64::from(i);
            let amplitude = 1.0 / (1.0 + (f - 100.0).powi(2));
            format!("{f},{amplitude},{}\n", 0.01 + 0.001 * f64::from(i))
        });
        let text: String = std::iter::once(format!("f (Hz),A (nm),{header} (nm)\n")).chain(rows).collect();
        let found = read(&text);
        let errors = found.curve.std_error().unwrap_or_else(|| panic!("{header} was not taken"));
        assert_eq!(errors.len(), 30);
    }
    // In another unit it is a different quantity.
    let text = "f (Hz),A (nm),dA (K)\n1,1,1\n2,3,1\n3,2,1\n4,1,2\n5,1,2\n6,1,2\n";
    assert!(read(text).curve.std_error().is_none());
}
