//! Resonance curves in the quantities and units used in laboratories.

use std::f64::consts::{SQRT_2, TAU};

use slipfit::{SignalKind, motion::steady::Phasor, resonance::Response};
use slipfit_io::{ReadError, ReadOptions, SweepReading, read_sweep_from};

fn read(text: &str) -> SweepReading {
    with(text, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn with(text: &str, options: &ReadOptions) -> Result<SweepReading, ReadError> {
    read_sweep_from(text.as_bytes(), "sweep.csv", options)
}

fn amplitudes(reading: &SweepReading) -> Vec<f64> {
    (0..reading.curve.len()).map(|i| reading.curve.response().amplitude(i)).collect()
}

fn phasors(reading: &SweepReading) -> &[Phasor] {
    let Response::Complex(z) = reading.curve.response() else { panic!("no phase") };
    z
}

fn said(reading: &SweepReading) -> String {
    let notes = &reading.report.notes;
    notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Close to twelve digits: factors are exact to rounding.
fn close(found: &[f64], wanted: &[f64], of: &str) {
    assert_eq!(found.len(), wanted.len(), "{of}");
    let near = |(f, w): (&f64, &f64)| (f - w).abs() <= 1e-9 * w.abs().max(1e-300);
    assert!(found.iter().zip(wanted).all(near), "{of}: {found:?} for {wanted:?}");
}

#[test]
fn amplitudes_come_peak_to_peak_effective_and_as_densities() {
    for (header, unit, factor) in [
        ("amplitude (mVpp)", "mV", 0.5),
        ("amplitude (V pp)", "V", 0.5),
        ("Vpp (mV)", "mV", 0.5),
        ("R (Vrms)", "V", SQRT_2),
        ("RMS velocity (mm)", "mm", SQRT_2),
    ] {
        let text = format!("f (Hz),{header}\n9,1\n10,20\n11,2\n");
        let reading = read(&text);
        let kind = ReadOptions { kind: Some(SignalKind::Displacement), ..Default::default() };
        close(&amplitudes(&with(&text, &kind).unwrap()), &[factor, 20.0 * factor, 2.0 * factor], header);
        assert_eq!(with(&text, &kind).unwrap().curve.unit(), unit, "{header}");
        assert!(said(&reading).contains("unit names another"), "{header}: {}", said(&reading));
        let given = ReadOptions { unit: Some(unit.into()), ..kind };
        close(&amplitudes(&with(&text, &given).unwrap()), &[1.0, 20.0, 2.0], header);
    }
    for header in ["PSD (nm^2/Hz)", "S_xx [nm\u{b2}/Hz]", "psd (nm**2/Hz)"] {
        let reading = read(&format!("f (Hz),{header}\n9,1\n10,400\n11,4\n"));
        close(&amplitudes(&reading), &[1.0, 20.0, 2.0], header);
        assert_eq!(reading.curve.unit(), "nm/\u{221a}Hz", "{header}");
        assert!(said(&reading).contains("its square root was taken"), "{}", said(&reading));
    }
    let acceleration = read("f (Hz),PSD (g^2/Hz)\n9,1\n10,400\n11,4\n");
    assert_eq!(
        (acceleration.report.kind, acceleration.curve.unit()),
        (SignalKind::Acceleration, "g s^2/\u{221a}Hz")
    );
}

#[test]
fn standard_errors_are_scaled_with_the_amplitudes_they_belong_to() {
    let reading = read("f (Hz),A (mVpp),A err\n9,2,0.2\n10,20,0.2\n11,4,0.2\n");
    close(reading.curve.std_error().unwrap(), &[0.1; 3], "half of what the peak to peak has");
}

#[test]
fn a_response_to_a_force_is_what_its_unit_or_its_name_says() {
    for (header, kind, unit) in [
        ("mobility (m/s/N)", SignalKind::Velocity, "m/N"),
        ("|H| (mm/s/N)", SignalKind::Velocity, "mm/N"),
        ("Mobility", SignalKind::Velocity, ""),
        ("FRF magnitude ((m/s\u{b2})/N)", SignalKind::Acceleration, "m/N"),
        ("inertance (m/s^2/N)", SignalKind::Acceleration, "m/N"),
        ("accelerance (g/N)", SignalKind::Acceleration, "g s^2/N"),
        ("Inertance", SignalKind::Acceleration, ""),
        ("receptance (\u{b5}m/N)", SignalKind::Displacement, "\u{b5}m/N"),
    ] {
        let reading = read(&format!("f (Hz),{header},phase (deg)\n9,1,10\n10,20,0\n11,2,-20\n"));
        assert_eq!(reading.report.kind, kind, "{header}");
        assert!([unit, &format!("{unit} s"), " s"].contains(&reading.curve.unit()) || unit.is_empty());
        let times = match kind {
            SignalKind::Velocity => 1,
            SignalKind::Acceleration => 2,
            _ => 0,
        };
        let omega = TAU * 10.0;
        close(&amplitudes(&reading)[1..2], &[20.0 / omega.powi(times)], header);
    }
    let reading = read("f (Hz),mobility (m/s/N),force (N)\n9,1,2\n10,20,2\n11,2,2.5\n");
    assert_eq!(reading.curve.drive(), None);
    assert!(said(&reading).contains("drive divides it out"), "{}", said(&reading));
    let text = "f (Hz),velocity (m/s),force (N)\n9,1,2\n10,20,2\n11,2,2.5\n";
    assert_eq!(read(text).curve.drive(), Some(&[2.0, 2.0, 2.5][..]));
}

#[test]
fn impedances_and_admittances_of_modulus_and_angle_are_those_of_two_parts() {
    // The same quartz, a conductance of 20 mS on a capacitance of 1 mS, in four exports.
    let points = [(9e6, 1e-4, 1e-3), (1e7, 2e-2, 1e-3), (1.1e7, 1e-4, -1e-3)];
    let table = |head: &str, row: &dyn Fn(Phasor) -> [f64; 2]| {
        let line = |(f, g, b): &(f64, f64, f64)| {
            let [first, second] = row(Phasor::new(*g, *b));
            format!("{f},{first},{second}\n")
        };
        format!("f (Hz),{head}\n{}", points.iter().map(line).collect::<String>())
    };
    let wanted: Vec<f64> =
        phasors(&read(&table("G (S),B (S)", &|y| [y.re, y.im]))).iter().flat_map(|z| [z.re, z.im]).collect();
    let inverse = |y: Phasor| Phasor::new(1.0, 0.0) / y;
    let degrees = |z: Phasor, times: f64| [z.norm() * times, z.arg().to_degrees()];
    for (head, text) in [
        ("|Y| (S),theta (deg)", table("|Y| (S),theta (deg)", &|y| degrees(y, 1.0))),
        ("Y (mS),phase (\u{b0})", table("Y (mS),phase (\u{b0})", &|y| degrees(y, 1e3))),
        ("Admittance (S),theta", table("Admittance (S),theta", &|y| degrees(y, 1.0))),
        ("|Z| (Ohm),theta (deg)", table("|Z| (Ohm),theta (deg)", &|y| degrees(inverse(y), 1.0))),
        (
            "Impedance (kOhm),Phase (deg)",
            table("Impedance (kOhm),Phase (deg)", &|y| degrees(inverse(y), 1e-3)),
        ),
        ("|Z|,theta", table("|Z|,theta", &|y| degrees(inverse(y), 1.0))),
    ] {
        let reading = read(&text);
        let found: Vec<f64> = phasors(&reading).iter().flat_map(|z| [z.re, z.im]).collect();
        // Degrees of an angle of a few microradians lose digits.
        let near = |(f, w): (&f64, &f64)| (f - w).abs() <= 1e-9 * wanted[3].abs();
        assert!(found.iter().zip(&wanted).all(near), "{head}: {found:?} for {wanted:?}");
        assert_eq!((reading.report.kind, reading.curve.unit()), (SignalKind::Velocity, "F"), "{head}");
        assert!(said(&reading).contains("parallel capacitance is a constant background"), "{head}");
    }
    let alone = read("f (Hz),|Z| (Ohm)\n9,100\n10,5\n11,100\n");
    close(&amplitudes(&alone), &[0.01 / (TAU * 9.0), 0.2 / (TAU * 10.0), 0.01 / (TAU * 11.0)], "|Z|");
    assert!(said(&alone).contains("phases in addition to the amplitudes"), "{}", said(&alone));
    let refused = with("f (Hz),|Z| (Ohm)\n9,100\n10,-5\n11,100\n", &ReadOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("row 3"), "{refused}");
}

#[test]
fn phases_come_in_cycles_and_in_multiples_of_pi() {
    for (header, times) in [("phase (cycles)", 360.0), ("phase (rev)", 360.0), ("phase (\u{3c0} rad)", 180.0)]
    {
        let rows: String = [(9.0, -10.0), (10.0, -90.0), (11.0, -170.0)]
            .iter()
            .map(|(f, degrees)| format!("{f},1,{}\n", degrees / times))
            .collect();
        let reading = read(&format!("f (Hz),R (nm),{header}\n{rows}"));
        let degrees: Vec<f64> = phasors(&reading).iter().map(|z| z.arg().to_degrees()).collect();
        close(&degrees, &[-10.0, -90.0, -170.0], header);
    }
}

#[test]
fn frequencies_come_as_logarithms() {
    let hz = [90.0_f64, 100.0, 110.0];
    for (header, to_written) in [
        ("log10 f", (|f| f.log10()) as fn(f64) -> f64),
        ("log10(f/kHz)", |f| (f / 1e3).log10()),
        ("lg f (Hz)", |f| f.log10()),
        ("ln(omega)", |f| (TAU * f).ln()),
    ] {
        let rows: String =
            hz.iter().zip([1, 3, 2]).map(|(f, a)| format!("{},{a}\n", to_written(*f))).collect();
        let reading = read(&format!("{header},A (nm)\n{rows}"));
        close(reading.curve.frequency_hz(), &hz, header);
        assert!(said(&reading).contains("frequency_unit gives another"), "{}", said(&reading));
    }
    let unit = |unit: &str| ReadOptions { frequency_unit: Some(unit.into()), ..Default::default() };
    let unit_of_first = |text: &str| ReadOptions { frequency: Some("1".into()), ..unit(text) };
    let text = "level,A\n-1,1\n0,3\n0.5,2\n";
    close(
        with(text, &unit_of_first("log10 kHz")).unwrap().curve.frequency_hz(),
        &[100.0, 1e3, 1e3 * 10f64.sqrt()],
        "given",
    );
    let plain = with("log10 f,A\n1.9,1\n2,3\n2.1,2\n", &unit("Hz")).unwrap();
    close(plain.curve.frequency_hz(), &[1.9, 2.0, 2.1], "not a logarithm");
}

#[test]
fn what_goes_in_is_the_drive_of_what_comes_out() {
    for header in ["U_in [V],U_out [V]", "Vin (V),Vout (V)", "Input (V),Output (V)", "U_in,U_out"] {
        let reading = read(&format!("f (Hz),{header}\n9,1,2\n10,1.1,9\n11,1.2,3\n"));
        assert_eq!(reading.curve.drive(), Some(&[1.0, 1.1, 1.2][..]), "{header}");
        close(&amplitudes(&reading), &[2.0, 9.0, 3.0], header);
    }
}

#[test]
fn of_two_channels_the_one_with_the_peak_is_the_response() {
    let rows: String = (0..30)
        .map(|i| {
            let f = 97.0 + 0.2 * f64::from(i);
            format!("{f},{},{}\n", 1.0 + 0.01 * f64::from(i), 5.0 / (1.0 + (f - 100.0).powi(2)))
        })
        .collect();
    let table = |header: &str| format!("f (Hz),{header}\n{rows}");
    let reading = read(&table("Ch1 (V),Ch2 (V)"));
    assert_eq!(reading.report.column("amplitude").unwrap().column.number, 3);
    assert_eq!(reading.curve.drive().unwrap()[29], 1.29);
    let said_so = said(&reading);
    assert!(said_so.contains("amplitude names the response") && said_so.contains("or none"), "{said_so}");
    let none = ReadOptions { drive: Some("none".into()), ..Default::default() };
    assert_eq!(with(&table("Ch1 (V),Ch2 (V)"), &none).unwrap().curve.drive(), None);
    // A channel in another unit may be anything.
    assert_eq!(read(&table("Ch1 (degC),Ch2 (V)")).curve.drive(), None);
}

#[test]
fn the_motion_of_a_base_is_the_drive_and_said_to_be() {
    let omega = |f: f64| TAU * f;
    let reading = read("f (Hz),base (g),mass (g)\n9,1,2\n10,1.1,9\n11,1.2,3\n");
    assert_eq!(reading.report.kind, SignalKind::Acceleration);
    close(&amplitudes(&reading)[1..2], &[9.0 / omega(10.0).powi(2)], "mass");
    close(&reading.curve.drive().unwrap()[1..2], &[1.1 / omega(10.0).powi(2)], "base");
    assert!(said(&reading).contains("drive names another drive, or none"), "{}", said(&reading));
    let mixed = read("f (Hz),Base displacement (mm),velocity (mm/s)\n9,1,2\n10,1.1,9\n11,1.2,3\n");
    close(mixed.curve.drive().unwrap(), &[1.0, 1.1, 1.2], "a displacement stays one");
    let rests = read("f (Hz),base (g),mass (g)\n9,0,2\n10,1.1,9\n11,1.2,3\n");
    assert_eq!(rests.curve.drive(), None);
    assert!(said(&rests).contains("not above zero throughout"), "{}", said(&rests));
}

/// A resonance at 100 Hz with a width of 1 Hz, sampled between 97 and 103 Hz, with a small deterministic disturbance:
/// `(f, re, im)`.
fn resonance() -> Vec<(f64, f64, f64)> {
    let point = |i: u32| {
        let f = 97.0 + 0.1 * f64::from(i);
        let z = Phasor::new(20.0, 0.0) / Phasor::new(100.0 - f, -0.5);
        let noise = |k: u32| 0.2 * f64::from((i * k) % 7).sin();
        (f, z.re + noise(3), -z.im + noise(5))
    };
    (0..60).map(point).collect()
}

fn rows(columns: impl Fn(Phasor) -> Vec<f64>) -> String {
    let line = |(f, re, im): (f64, f64, f64)| {
        let cells: Vec<String> = columns(Phasor::new(re, im)).iter().map(f64::to_string).collect();
        format!("{f},{}\n", cells.join(","))
    };
    resonance().into_iter().map(line).collect()
}

#[test]
fn columns_without_names_are_what_a_resonance_fits_best() {
    let wanted: Vec<f64> = resonance().iter().map(|(_, re, im)| re.hypot(*im)).collect();
    let level = |z: Phasor| 20.0 * z.norm().log10();
    for (of, text, phased, note) in [
        ("X, Y", rows(|z| vec![z.re, z.im]), true, "real and imaginary part"),
        ("R, degrees", rows(|z| vec![z.norm(), z.arg().to_degrees()]), true, "degrees"),
        ("dB, degrees", rows(|z| vec![level(z), z.arg().to_degrees()]), true, "levels in dB"),
        ("R", rows(|z| vec![z.norm()]), false, "names no unit"),
        ("dB", rows(|z| vec![level(z)]), false, "levels in dB"),
    ] {
        let reading = read(&text);
        close(&amplitudes(&reading), &wanted, of);
        assert_eq!(matches!(reading.curve.response(), Response::Complex(_)), phased, "{of}");
        assert!(said(&reading).contains(note), "{of}: {}", said(&reading));
    }
    // Options determine the meaning of the numbers, whatever fits.
    let options = ReadOptions { amplitude: Some("2".into()), unit: Some("V".into()), ..Default::default() };
    let reading = with(&rows(|z| vec![level(z)]), &options).unwrap();
    close(
        &amplitudes(&reading)[..1],
        &[level(Phasor::new(resonance()[0].1, resonance()[0].2))],
        "as it stands",
    );
}

#[test]
fn overloads_are_no_points() {
    for mark in ["9999", "9.9e37", "OVLD", "-999", "1E+30"] {
        let text: String = (0..40)
            .map(|i| {
                let f = 98.0 + 0.1 * f64::from(i);
                let a = 20.0 / (1.0 + (f - 100.0).powi(2));
                if i == 17 || i == 30 { format!("{f},{mark}\n") } else { format!("{f},{a}\n") }
            })
            .collect();
        let reading = read(&format!("f (Hz),A (nm)\n{text}"));
        assert_eq!((reading.curve.len(), reading.report.rows_skipped()), (38, 2), "{mark}");
        assert_eq!(reading.report.skipped[0].first_row, 19, "{mark}: {:?}", reading.report.skipped);
        assert!(amplitudes(&reading).iter().all(|a| *a < 21.0));
    }
}

#[test]
fn cells_that_hold_more_than_a_number_are_taken_apart() {
    let wanted: Vec<f64> = resonance().iter().map(|(_, re, im)| re.hypot(*im)).collect();
    let table = |header: &str, row: &dyn Fn(f64, Phasor) -> String| {
        let line = |(f, re, im): (f64, f64, f64)| format!("{}\n", row(f, Phasor::new(re, im)));
        format!("{header}\n{}", resonance().into_iter().map(line).collect::<String>())
    };
    for (header, phased, row) in [
        (
            "f,A,phase",
            true,
            (|f, z: Phasor| format!("{f} Hz,{} nm,{}\u{b0}", z.norm(), z.arg().to_degrees()))
                as fn(f64, Phasor) -> String,
        ),
        ("f,A", false, |f, z: Phasor| format!("{} kHz,{} nm", f / 1e3, z.norm())),
        ("f (Hz),A (nm)", false, |f, z: Phasor| format!("{f} \u{b1} 0.01,{} \u{b1} 0.5", z.norm())),
        ("f (Hz),response (nm)", true, |f, z: Phasor| format!("{f},{}{:+}j", z.re, z.im)),
        ("f (Hz);response (nm)", true, |f, z: Phasor| format!("{f};({} + {}i)", z.re, z.im)),
    ] {
        let text = table(header, &row);
        let reading = read(&text);
        close(&amplitudes(&reading), &wanted, header);
        assert_eq!(reading.curve.unit(), "nm", "{header}");
        assert_eq!(matches!(reading.curve.response(), Response::Complex(_)), phased, "{header}");
        close(&reading.curve.frequency_hz()[..1], &[97.0], header);
        assert!(said(&reading).contains("cells hold more than numbers"), "{header}: {}", said(&reading));
        let errors = reading.curve.std_error().map(<[f64]>::to_vec);
        assert_eq!(errors.is_some(), text.contains('\u{b1}'), "{header}");
    }
}
