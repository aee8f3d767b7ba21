//! Texts as written on users' computers: encodings, thousands, stamps, headers in their languages. Each contains the
//! same swing, and assumptions are stated in the report.

use slipfit::{SignalKind, answer::hint::HintValue};
use slipfit_io::{ReadOptions, Reading, TimeSource, read_from, read_sweep_from};

pub(crate) const ROWS: usize = 300;
pub(crate) const STEP_S: f64 = 0.02;

/// The swing, in a unit in which its initial value is 1500.
pub(crate) fn x(k: usize) -> f64 {
    let t = k as f64 * STEP_S;
    (15000.0 * (-0.1 * t).exp() * (9.0 * t).cos()).round() / 10.0
}

/// A table of the swing: a header, and rows of a time and a value as text.
pub(crate) fn table(header: &str, row: impl Fn(usize) -> String) -> String {
    format!("{header}\n") + &(0..ROWS).map(|k| row(k) + "\n").collect::<String>()
}

pub(crate) fn plain(header: &str) -> String {
    table(header, |k| format!("{:.2};{:.1}", k as f64 * STEP_S, x(k)))
}

/// Reads the swing and compares every number.
pub(crate) fn swing(bytes: &[u8]) -> Reading {
    let reading = read_from(bytes, "swing.csv", &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let record = &reading.record;
    assert_eq!(record.len(), ROWS);
    for (k, value) in record.signal().iter().enumerate() {
        assert!((value - x(k)).abs() < 1e-9, "row {k}: {value}");
    }
    for (k, t) in record.times_s(0..ROWS).iter().enumerate() {
        // Seconds since 1970 are resolved to a quarter of a microsecond.
        let passed = t - record.times_s(0..1)[0];
        assert!((passed - k as f64 * STEP_S).abs() < 1e-6, "row {k}: {passed} s");
    }
    reading
}

pub(crate) fn notes(reading: &Reading) -> String {
    reading.report.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

pub(crate) fn time_unit(reading: &Reading) -> &str {
    match reading.report.time.as_ref().unwrap() {
        TimeSource::Column(taken) => &taken.unit,
        other => panic!("{other:?}"),
    }
}

#[test]
fn utf_16_with_and_without_its_mark_is_read() {
    let text = plain("Zeit (s);Größe (µm)");
    let units = || text.encode_utf16();
    let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
    for (bytes, encoding) in [
        (little.clone(), "UTF-16LE"),
        (big.clone(), "UTF-16BE"),
        ([&b"\xff\xfe"[..], &little].concat(), "UTF-16LE"),
        ([&b"\xfe\xff"[..], &big].concat(), "UTF-16BE"),
    ] {
        let reading = swing(&bytes);
        assert_eq!(reading.report.dialect.as_ref().unwrap().encoding, encoding);
        assert_eq!(reading.report.column("signal").unwrap().column.header, "Größe (µm)");
        assert_eq!(reading.record.unit(), "µm");
    }
}

#[test]
fn latin_1_is_read_with_its_headers() {
    let text = plain("Temps (s);Élongation (µm)");
    let bytes: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let reading = swing(&bytes);
    assert_eq!(reading.report.dialect.as_ref().unwrap().encoding, "windows-1252");
    let signal = reading.report.column("signal").unwrap();
    assert_eq!((signal.column.header.as_str(), signal.unit.as_str()), ("Élongation (µm)", "µm"));
}

/// A number with a mark between its thousands and another before its fraction.
fn grouped(value: f64, group: &str, mark: char) -> String {
    let text = format!("{:.1}", value.abs());
    let (whole, fraction) = text.split_once('.').unwrap();
    let sign = if value < 0.0 { "-" } else { "" };
    let whole = match whole.len() {
        n if n > 3 => format!("{}{group}{}", &whole[..n - 3], &whole[n - 3..]),
        _ => whole.to_owned(),
    };
    format!("{sign}{whole}{mark}{fraction}")
}

#[test]
fn thousands_set_apart_are_one_number() {
    for (group, mark, time_mark) in [
        (",", '.', "."),
        (".", ',', ","),
        (" ", ',', ","),
        ("\u{a0}", ',', ","),
        ("\u{202f}", ',', ","),
        ("'", '.', "."),
        ("\u{2019}", '.', "."),
    ] {
        for separator in [";", "\t"] {
            let row = |k: usize| {
                let t = format!("{:.2}", k as f64 * STEP_S).replace('.', time_mark);
                format!("{t}{separator}{}", grouped(x(k), group, mark))
            };
            let reading = swing(table(&format!("Time (s){separator}x (mm)"), row).as_bytes());
            assert_eq!(reading.report.rows_skipped(), 0, "{group:?} {mark} {separator:?}");
        }
    }
    // English spreadsheets quote cells that contain their separator.
    let row = |k: usize| format!("{:.2},\"{}\"", k as f64 * STEP_S, grouped(x(k), ",", '.'));
    swing(table("Time (s),x (mm)", row).as_bytes());
}

#[test]
fn records_are_read_with_headers_in_ten_languages() {
    use SignalKind::{Acceleration, Displacement, Velocity};
    for (language, headers) in [
        ("German", ["Zeit", "Auslenkung", "Winkel", "Geschwindigkeit", "Beschleunigung"]),
        ("French", ["Temps", "Élongation", "Angle", "Vitesse", "Accélération"]),
        ("Italian", ["Tempo", "Posizione", "Angolo", "Velocità", "Accelerazione"]),
        ("Spanish", ["Tiempo", "Posición", "Ángulo", "Velocidad", "Aceleración"]),
        ("Portuguese", ["Tempo", "Posição", "Ângulo", "Velocidade", "Aceleração"]),
        ("Chinese", ["时间", "位移", "角度", "速度", "加速度"]),
        ("traditional Chinese", ["時間", "位移", "角度", "速度", "加速度"]),
        ("Japanese", ["時刻", "変位", "角度", "速度", "加速度"]),
        ("Japanese, positions", ["時間", "位置", "角度", "速度", "加速度"]),
        ("Portuguese, displacements", ["Tempo", "Deslocamento", "Ângulo", "Velocidade", "Aceleração"]),
    ] {
        let [time, signals @ ..] = headers;
        let kinds = [Displacement, Displacement, Velocity, Acceleration];
        for (signal, kind) in signals.into_iter().zip(kinds) {
            // The times are last and a counter is first: only names distinguish them.
            let text =
                table(&format!("{signal};{time}"), |k| format!("{:.1};{:.2}", x(k), k as f64 * STEP_S));
            let reading = swing(text.as_bytes());
            assert_eq!(reading.report.kind, kind, "{language}: {signal}");
            let taken = reading.report.column("signal").unwrap();
            assert!(taken.why.contains("named like"), "{language}: {}", taken.why);
            let Some(TimeSource::Column(time)) = &reading.report.time else { panic!("{language}: no times") };
            assert!(time.why.contains("named like a time"), "{language}: {}", time.why);
            // No unit is given: the assumption is stated.
            assert!(notes(&reading).contains("its times were taken as seconds"), "{}", notes(&reading));
        }
    }
}

#[test]
fn curves_are_read_with_headers_in_ten_languages() {
    for (language, [frequency, amplitude, phase]) in [
        ("German", ["Frequenz", "Amplitude", "Phase"]),
        ("French", ["Fréquence", "Amplitude", "Phase"]),
        ("Italian", ["Frequenza", "Ampiezza", "Fase"]),
        ("Spanish", ["Frecuencia", "Amplitud", "Fase"]),
        ("Portuguese", ["Frequência", "Amplitude", "Fase"]),
        ("Chinese", ["频率", "振幅", "相位"]),
        ("traditional Chinese", ["頻率", "振幅", "相位"]),
        ("Japanese", ["周波数", "振幅", "位相"]),
    ] {
        let row = |k: usize| {
            let f = 9.0 + 0.05 * k as f64;
            let (re, im) = (1.0 - (f / 10.0).powi(2), f / 10.0 / 20.0);
            format!("{:.5};{f:.2};{:.3}\n", 1.0 / re.hypot(im), -im.atan2(re).to_degrees())
        };
        for (open, close) in [(" (", ")"), ("（", "）")] {
            let header =
                format!("{amplitude}{open}mm{close};{frequency}{open}Hz{close};{phase}{open}deg{close}\n");
            let text = header + &(0..41).map(row).collect::<String>();
            let reading = read_sweep_from(text.as_bytes(), "curve.csv", &ReadOptions::default())
                .unwrap_or_else(|e| panic!("{language}: {e}"));
            assert_eq!((reading.curve.frequency_hz()[20], reading.curve.unit()), (10.0, "mm"), "{language}");
            assert!(reading.report.column("phase").is_some(), "{language}");
        }
    }
}

#[test]
fn names_on_two_lines_are_joined() {
    for header in
        ["Time\tPosition\nrun A\trun A", "Time\tPosition\nraw\tfiltered", "Time\tPosition\n(s)\t(mm)"]
    {
        let text = table(header, |k| format!("{:.2}\t{:.1}", k as f64 * STEP_S, x(k)));
        let reading = swing(text.as_bytes());
        let signal = reading.report.column("signal").unwrap();
        assert!(signal.column.header.starts_with("Position"), "{header}: {}", signal.column.header);
        assert!(signal.why.contains("named like a position"), "{header}: {}", signal.why);
    }
}

#[test]
fn pixels_are_no_lock_in_and_a_lock_in_is_one() {
    let read = |text: &str| read_from(text.as_bytes(), "a.csv", &ReadOptions::default()).unwrap();
    // A track: the angle was never filled in, or is not the angle of x + i y.
    for theta in [|_: usize| 0.0, |k: usize| x(k) / 100.0] {
        let row = |k: usize| {
            let (t, y) = (k as f64 * STEP_S, x(k) / 10.0);
            format!("{t:.2},{:.1},{:.1},{:.3}", 400.0 + y, 150.0 + 0.01 * y * y, theta(k))
        };
        let reading = read(&table("time,x,y,theta", row));
        assert_ne!(reading.report.kind, SignalKind::LockIn, "{:?}", reading.report.taken);
    }
    for (companion, degrees) in [("r", 0.0), ("theta", 1.0), ("theta", 180.0 / std::f64::consts::PI)] {
        let row = |k: usize| {
            let (t, phase) = (k as f64 * STEP_S, 0.9 * k as f64);
            let r = 3.0 * (-0.01 * k as f64).exp();
            let (u, v) = (r * phase.cos(), r * phase.sin());
            let other = if companion == "r" { r } else { v.atan2(u) * degrees };
            format!("{t:.2},{u:.6},{v:.6},{other:.6}")
        };
        let reading = read(&table(&format!("time,x,y,{companion}"), row));
        assert_eq!(reading.report.kind, SignalKind::LockIn, "{companion}");
    }
}

#[test]
fn a_curve_without_names_may_have_its_phase_first() {
    let row = |k: usize| {
        let f = 130.0 + 0.1 * k as f64;
        let (re, im) = (1.0 - (f / 144.0).powi(2), f / 144.0 / 12.0);
        let noise = 1e-3 * (7.7 * (k * k) as f64).sin();
        let amplitude = 1e-4 * (1.0 / re.hypot(im) + noise);
        format!("{f:.1}\t{:.5}\t0.001\t{amplitude:.6e}\t1e-7\n", im.atan2(re) + noise)
    };
    let text: String = (0..280).map(row).collect();
    let reading = read_sweep_from(text.as_bytes(), "reed", &ReadOptions::default()).unwrap();
    let number = |what: &str| reading.report.column(what).map(|taken| taken.column.number);
    assert_eq!((number("amplitude"), number("phase")), (Some(4), Some(2)), "{:?}", reading.report.taken);
    // The usual order is kept.
    let swap = |line: &str| {
        let cells: Vec<&str> = line.split('\t').collect();
        format!("{}\t{}\t{}\n", cells[0], cells[3], cells[1])
    };
    let text: String = text.lines().map(swap).collect();
    let reading = read_sweep_from(text.as_bytes(), "reed", &ReadOptions::default()).unwrap();
    let number = |what: &str| reading.report.column(what).map(|taken| taken.column.number);
    assert_eq!((number("amplitude"), number("phase")), (Some(2), Some(3)), "{:?}", reading.report.taken);
}

#[test]
fn what_is_no_record_is_told_what_reads_it() {
    for (text, said, hint) in [
        (
            table("f/Hz,A/mA", |k| format!("{}.5,{:.1}", k, x(k).abs())),
            "no column of times, and column 1 `f/Hz` holds frequencies: this is a resonance curve",
            "slipfit resonance",
        ),
        (
            table("drive/V,A/mA", |k| format!("{}.5,{:.1}", k + 1, 5.0 * k as f64 + 1.3)),
            "no column could be the signal, and column 1 `drive/V` holds levels of a drive",
            "slipfit levels",
        ),
    ] {
        let error = read_from(text.as_bytes(), "curve.csv", &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains(said), "{error}");
        let spelled = |option: &'static str, value: Option<&HintValue>| match value {
            Some(value) if option == "analysis" => format!("slipfit {value}"),
            _ => option.to_owned(),
        };
        let hints = slipfit::answer::hint::spelled(&error.hints(), &spelled);
        assert!(hints.starts_with(hint), "{hints}");
    }
}

#[test]
fn names_of_rows_are_no_column_of_the_header() {
    for header in ["\"time\" \"pos\"", "time pos"] {
        for first in [0, 1] {
            let text = table(header, |k| format!("\"{}\" {:.2} {:.1}", k + first, k as f64 * STEP_S, x(k)));
            let reading = swing(text.as_bytes());
            assert_eq!(reading.report.column("signal").unwrap().column.header, "pos");
        }
    }
    let text = table("\"time\",\"pos\"", |k| format!("\"{}\",{:.2},{:.1}", k + 1, k as f64 * STEP_S, x(k)));
    swing(text.as_bytes());
    // If a header lacks the name of the last column, the names keep their positions.
    let text = table("t,x", |k| format!("{:.2},{:.1},{}", k as f64 * STEP_S, x(k), k % 3));
    assert_eq!(swing(text.as_bytes()).report.column("signal").unwrap().column.header, "x");
}

#[test]
fn decimal_commas_between_commas_are_read_or_refused() {
    let comma = |k: usize| format!("{:.2},{:.1}", k as f64 * STEP_S, x(k)).replace('.', ",");
    let text = table("t,x", comma);
    let reading = swing(text.as_bytes());
    assert!(notes(&reading).contains("and decimal marks"), "{}", notes(&reading));
    swing((0..ROWS).map(|k| comma(k) + "\n").collect::<String>().as_bytes());
    let three = |k: usize| comma(k) + &format!(",{:.2}", k as f64 / 100.0).replace('.', ",");
    swing(table("t,x,n", three).as_bytes());
    // With whole numbers without a fraction, separators and decimal commas are ambiguous.
    let trimmed = |k: usize| format!("{},{}", k as f64 * STEP_S, x(k)).replace('.', ",");
    let error =
        read_from(table("t,x", trimmed).as_bytes(), "swing.csv", &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("the two cannot be distinguished"), "{error}");
    // Rows of whole numbers only are read as such.
    let whole = table("t,x", |k| format!("{},{:.0},{},7", 20 * k, x(k), k % 5));
    assert_eq!(read_from(whole.as_bytes(), "swing.csv", &ReadOptions::default()).unwrap().record.len(), ROWS);
}

#[test]
fn axes_are_of_the_sensor_that_the_file_is_named_after() {
    let row = |k: usize| {
        let t = k as f64 * STEP_S;
        format!(
            "{:.1},0.{},0.{},{t:.9},{}",
            x(k),
            k % 7,
            k % 5,
            1_699_023_123_123_456_789_i64 + (t * 1e9) as i64
        )
    };
    let text = table("z,y,x,seconds_elapsed,time", row);
    for (name, kind) in [
        ("phone/Accelerometer.csv", SignalKind::Acceleration),
        ("Gyroscope.csv", SignalKind::Velocity),
        ("swing.csv", SignalKind::Displacement),
    ] {
        let reading = read_from(text.as_bytes(), name, &ReadOptions::default()).unwrap();
        assert_eq!(reading.record.kind(), kind, "{name}");
        assert_eq!(reading.report.dialect.as_ref().unwrap().convention, Some("Sensor Logger"));
    }
    let given = ReadOptions { kind: Some(SignalKind::Displacement), ..Default::default() };
    let reading = read_from(text.as_bytes(), "Accelerometer.csv", &given).unwrap();
    assert_eq!(reading.record.kind(), SignalKind::Displacement);
    // A unit takes precedence over the name of the file.
    let reading =
        read_from(plain("t (s);x (mm)").as_bytes(), "accelerometer.csv", &ReadOptions::default()).unwrap();
    assert_eq!(reading.record.kind(), SignalKind::Displacement);
}

#[test]
fn an_amplitude_goes_with_the_phase_of_its_own_channel() {
    let row = |k: usize| {
        let f = 900.0 + k as f64;
        let (re, im) = (1.0 - (f / 1000.0).powi(2), f / 1000.0 / 50.0);
        let level = -10.0 * (re * re + im * im).log10();
        format!("{f:.2},{:.5},{level:.5},{:.3}\n", 0.001 * (k as f64).sin(), -im.atan2(re).to_degrees())
    };
    let rows: String = (0..201).map(row).collect();
    let text = format!(
        "#Digilent WaveForms Network Analyzer\nFrequency (Hz),Channel 1 Magnitude (dB),Channel 2 Magnitude (dB),\
         Channel 2 Phase (deg)\n{rows}"
    );
    let reading = read_sweep_from(text.as_bytes(), "net.csv", &ReadOptions::default()).unwrap();
    assert_eq!(reading.report.column("amplitude").unwrap().column.number, 3);
    assert_eq!(reading.report.column("phase").unwrap().column.number, 4);
    let first = ReadOptions { amplitude: Some("2".into()), ..Default::default() };
    let reading = read_sweep_from(text.as_bytes(), "net.csv", &first).unwrap();
    assert_eq!(reading.report.column("phase"), None);
}

#[test]
fn remarks_about_the_samples_are_no_header() {
    let value = |k: usize| format!("{:.1}", x(k));
    let both = |k: usize| format!("{:.2} {:.1}", k as f64 * STEP_S, x(k));
    let force_curve = "# channel: vDeflection\n# units: V\n# sampling rate: 50.0 Hz";
    let named = format!("{force_curve}\n# columns: time deflection");
    let reading = swing(table(&named, both).as_bytes());
    assert_eq!(reading.report.column("signal").unwrap().column.header, "deflection");
    for text in [table(force_curve, value), table(force_curve, both)] {
        let reading = swing(text.as_bytes());
        assert_eq!(reading.report.column("signal").unwrap().column.header, "");
        assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Displacement, "V"));
    }
    let audacity = "swing   Sample Rate: 50 Hz. Sample values on linear scale.\n";
    let timed = |k: usize| format!("{:.2}\t{:.1}", k as f64 * STEP_S, x(k));
    for text in [table(audacity, value), table(audacity, timed)] {
        assert_eq!(swing(text.as_bytes()).report.column("signal").unwrap().column.header, "");
    }
}

#[test]
fn settings_beside_the_first_rows_leave_these_samples() {
    const SETTINGS: [&str; 18] = [
        "Record Length,3.000000e+02",
        "Sample Interval,2.000000e-02",
        "Trigger Point,1.500000000000e+02",
        ",",
        ",",
        ",",
        "Source,CH1",
        "Vertical Units,V",
        "Vertical Scale,5.000000e+02",
        "Vertical Offset,0.000000e+00",
        "Horizontal Units,s",
        "Horizontal Scale,2.500000e-01",
        "Pt Fmt,Y",
        "Yzero,0.000000e+00",
        "Probe Atten,1.000000e+01",
        "Model Number,TDS2024B",
        "Serial Number,\"C012345\"",
        "Firmware Version,FV:v22.01",
    ];
    let setting = |k: usize| SETTINGS.get(k).copied().unwrap_or(",");
    let row = |k: usize| format!("{},,{:019.12},{:10.5},\r\n", setting(k), k as f64 * STEP_S - 1.0, x(k));
    let reading = swing((0..ROWS).map(row).collect::<String>().as_bytes());
    assert_eq!((reading.record.unit(), time_unit(&reading), reading.report.rows_skipped()), ("V", "s", 0));
    assert!(notes(&reading).contains("next to the first 18 rows"), "{}", notes(&reading));
    assert!(reading.report.named_values.contains(&("Probe Atten".to_owned(), "1.000000e+01".to_owned())));
    // The same below a header, as entered in a sheet.
    let row =
        |k: usize| format!("{}\t\t{:.2}\t{:.1}\n", setting(k).replace(',', "\t"), k as f64 * STEP_S, x(k));
    let text = format!("setting\tvalue\t\tt (s)\tx (mm)\n{}", (0..ROWS).map(row).collect::<String>());
    assert_eq!(swing(text.as_bytes()).record.unit(), "mm");
    // A line of other values above the rows is not one of them.
    let row = |k: usize| format!(",,,{:.2},{:.1}\n", k as f64 * STEP_S, x(k));
    let above: String = (1..5).map(|k| format!("mass,kg,,{},{}\n", 10 * k, 7 * k)).collect();
    swing((above + &(0..ROWS).map(row).collect::<String>()).as_bytes());
}

#[test]
fn names_in_front_of_values_are_columns() {
    for (between, mark) in [(" ", ":"), (",", ":"), ("\t", ":"), (", ", ": "), (" ", "="), ("; ", " = ")] {
        let row = |k: usize| format!("t_ms{mark}{}{between}x{mark}{:.1}\r\n", 20 * k, x(k));
        let text = (0..ROWS).map(row).collect::<String>();
        let reading = swing(text.as_bytes());
        assert_eq!(
            (time_unit(&reading), reading.report.column("signal").unwrap().column.header.as_str()),
            ("ms", "x")
        );
        assert!(notes(&reading).contains("read as columns: t_ms, x"), "{}", notes(&reading));
    }
    // Words of the program, a name that occurs only sometimes, and a truncated line.
    let row = |k: usize| {
        let also = if k.is_multiple_of(10) { " battery:3.7" } else { "" };
        format!("x:{:.1} t_ms:{}{also}\n", x(k), 20 * k)
    };
    let text = format!("sensor ready\n{}x:51", (0..ROWS).map(row).collect::<String>());
    let reading = swing(text.as_bytes());
    assert_eq!(reading.report.rows_skipped(), 1, "{:?}", reading.report.skipped);
    let text = format!("{}t_ms:x\n", (0..ROWS).map(row).collect::<String>());
    assert_eq!(swing(text.as_bytes()).report.skipped[0].reason, "remark");
}
