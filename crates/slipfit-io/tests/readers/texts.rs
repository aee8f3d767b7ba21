//! Texts as people's machines write them: encodings, thousands, stamps, headers in their languages.
//! Each holds the same swing, and what was assumed stands in the report.

use slipfit::{SignalKind, answer::hint::HintValue};
use slipfit_io::{Format, ReadOptions, Reading, TimeSource, read_from, read_sweep_from};

const ROWS: usize = 300;
const STEP_S: f64 = 0.02;

/// The swing, in a unit in which it begins at 1500.
fn x(k: usize) -> f64 {
    let t = k as f64 * STEP_S;
    (15000.0 * (-0.1 * t).exp() * (9.0 * t).cos()).round() / 10.0
}

/// A table of the swing: a header, and rows of a time and a value as they are written.
fn table(header: &str, row: impl Fn(usize) -> String) -> String {
    format!("{header}\n") + &(0..ROWS).map(|k| row(k) + "\n").collect::<String>()
}

fn plain(header: &str) -> String {
    table(header, |k| format!("{:.2};{:.1}", k as f64 * STEP_S, x(k)))
}

/// Reads the swing and compares every number.
fn swing(bytes: &[u8]) -> Reading {
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

fn notes(reading: &Reading) -> String {
    reading.report.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn time_unit(reading: &Reading) -> &str {
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

/// A number with a mark between its thousands and one before its fraction.
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
    // English spreadsheets quote what holds their separator.
    let row = |k: usize| format!("{:.2},\"{}\"", k as f64 * STEP_S, grouped(x(k), ",", '.'));
    swing(table("Time (s),x (mm)", row).as_bytes());
}

/// Hours, minutes and seconds with milliseconds of a row that begins at 23:59:57 where `late`, else
/// at 09:59:58.
fn clock(k: usize, late: bool) -> (u64, u64, u64, u64) {
    let begin = if late { 86_397_000 } else { 35_998_000 };
    let ms = (begin + 20 * k as u64) % 86_400_000;
    (ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000)
}

#[test]
fn dates_and_times_of_day_are_read_as_seconds() {
    type Stamp = fn(usize) -> String;
    let stamps: [(&str, Stamp); 6] = [
        ("2024-05-01T09:59:58.000Z", |k| {
            let (h, m, s, ms) = clock(k, false);
            format!("2024-05-01T{h:02}:{m:02}:{s:02}.{ms:03}Z")
        }),
        ("2024-05-01T09:59:58.000+02:00", |k| {
            let (h, m, s, ms) = clock(k, false);
            format!("2024-05-01T{h:02}:{m:02}:{s:02}.{ms:03}+02:00")
        }),
        ("2024-05-01 09:59:58,000", |k| {
            let (h, m, s, ms) = clock(k, false);
            format!("2024-05-01 {h:02}:{m:02}:{s:02},{ms:03}")
        }),
        ("01.05.2024 09:59:58.000", |k| {
            let (h, m, s, ms) = clock(k, false);
            format!("01.05.2024 {h:02}:{m:02}:{s:02}.{ms:03}")
        }),
        ("5/1/2024 9:59:58.000 AM", |k| {
            let (h, m, s, ms) = clock(k, false);
            format!("5/1/2024 {h}:{m:02}:{s:02}.{ms:03} AM")
        }),
        ("09:59:58.000", |k| {
            let (h, m, s, ms) = clock(k, false);
            format!("{h:02}:{m:02}:{s:02}.{ms:03}")
        }),
    ];
    for (first, stamp) in &stamps {
        for header in ["Zeitstempel;x (mm)", "Timestamp;x (mm)", "a;b", "Time (ms);x (mm)"] {
            let text = table(header, |k| format!("{};{:.1}", stamp(k), x(k)));
            let reading = swing(text.as_bytes());
            let said = notes(&reading);
            assert!(said.contains(&format!("such as `{first}`: read as seconds since")), "{header}: {said}");
            assert_eq!(time_unit(&reading), "s", "{header}");
            // Milliseconds of a date are those of its clock, to the last digit.
            assert!(reading.record.clock().is_uniform(), "{first}");
        }
    }
    // Minutes and seconds alone.
    let text = table("Time;x (mm)", |k| format!("{:02}:{:05.2};{:.1}", k / 3000, k as f64 * STEP_S, x(k)));
    swing(text.as_bytes());
}

#[test]
fn a_clock_that_passes_midnight_goes_on() {
    let text = table("time,x (mm)", |k| {
        let (h, m, s, ms) = clock(k, true);
        format!("{h:02}:{m:02}:{s:02}.{ms:03},{:.1}", x(k))
    });
    let reading = swing(text.as_bytes());
    assert!(notes(&reading).contains("begin again at midnight"), "{}", notes(&reading));
}

#[test]
fn a_date_beside_the_clock_and_one_above_the_header_do_no_harm() {
    let row = |k: usize| {
        let (h, m, s, ms) = clock(k, false);
        format!("2024-05-01,{h:02}:{m:02}:{s:02}.{ms:03},{:.1}", x(k))
    };
    swing(table("Date,Time,x (mm)", row).as_bytes());
    // As many cells as the rows, all of them numbers in the eyes of a reader of dates.
    let text = format!("2024-05-01,09:59:58\n{}", plain("Time (s);x (mm)").replace(';', ","));
    let reading = swing(text.as_bytes());
    assert_eq!(reading.report.dialect.as_ref().unwrap().header_row, Some(2));
}

#[test]
fn seconds_since_1970_are_told_by_their_size() {
    for (per_second, unit) in [(1e0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")] {
        let text = table("timestamp,x (mm)", |k| {
            let seconds = 1_714_557_598_u64;
            let rest = (k as f64 * STEP_S * per_second).round();
            let whole = if per_second == 1.0 {
                format!("{:.2}", seconds as f64 + k as f64 * STEP_S)
            } else {
                format!("{}", seconds as u128 * per_second as u128 + rest as u128)
            };
            format!("{whole},{:.1}", x(k))
        });
        let reading = swing(text.as_bytes());
        assert_eq!(time_unit(&reading), unit);
        let said = notes(&reading);
        assert!(said.contains(&format!("counts from 1970: its times were taken as {unit}")), "{said}");
    }
}

#[test]
fn a_time_in_a_unit_of_something_else_is_told() {
    for unit in ["mV", "rad"] {
        let reading = swing(plain(&format!("time ({unit});x (mm)")).as_bytes());
        let told = notes(&reading);
        assert!(told.contains(&format!("{unit} is no unit of time: seconds were taken")), "{told}");
    }
    let reading = swing(plain("time (s);x (mm)").as_bytes());
    assert!(!notes(&reading).contains("no unit of time"));
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
            // The times stand last and a counter first: only names tell them apart.
            let text =
                table(&format!("{signal};{time}"), |k| format!("{:.1};{:.2}", x(k), k as f64 * STEP_S));
            let reading = swing(text.as_bytes());
            assert_eq!(reading.report.kind, kind, "{language}: {signal}");
            let taken = reading.report.column("signal").unwrap();
            assert!(taken.why.contains("named like"), "{language}: {}", taken.why);
            let Some(TimeSource::Column(time)) = &reading.report.time else { panic!("{language}: no times") };
            assert!(time.why.contains("named like a time"), "{language}: {}", time.why);
            // No unit is named: what was assumed is said.
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
    // A track: the angle was never filled in, or is no angle of x + i y.
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
    // The usual order stays the usual order.
    let swap = |line: &str| {
        let cells: Vec<&str> = line.split('\t').collect();
        format!("{}\t{}\t{}\n", cells[0], cells[3], cells[1])
    };
    let text: String = text.lines().map(swap).collect();
    let reading = read_sweep_from(text.as_bytes(), "reed", &ReadOptions::default()).unwrap();
    let number = |what: &str| reading.report.column(what).map(|taken| taken.column.number);
    assert_eq!((number("amplitude"), number("phase")), (Some(2), Some(3)), "{:?}", reading.report.taken);
}

/// The rows of the swing without their times.
fn values(header: &str, row: impl Fn(usize) -> String) -> String {
    table(header, row)
}

#[test]
fn steps_that_instruments_state_stand_for_times() {
    let value = |k: usize| format!("{:.1}", x(k));
    let tabbed = |k: usize| format!("\t{:.1}\t0", x(k));
    for (what, text) in [
        (
            "Rigol",
            values("X,CH1,Start,Increment,\nSequence,Volt,-1.0e-01,2.0e-02", |k| {
                format!("{k},{:.4e},", x(k))
            }),
        ),
        (
            "Rigol, two channels",
            values("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.0e-01,2.0e-02", |k| {
                format!("{k},{:.4e},{:.1e},", x(k), 1e-3 * (k as f64).sin())
            }),
        ),
        ("Rigol MSO5000", values("Time(s),CH1(V),t0 = -0.1s, tInc = 0.02s,", |k| format!(",{:.4e},", x(k)))),
        (
            "LabVIEW",
            values(
                "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nChannels\t1\t\t\nY_Unit_Label\tVolts\t\t\n\
                 X_Dimension\tTime\t\t\nDelta_X\t0.02\t\t\n***End_of_Header***\t\t\t\nX_Value\tVoltage_0\tComment",
                tabbed,
            ),
        ),
        (
            "Keyence",
            values("[Header]\nUnit=mm\nSamplingCycle(us)=20000\n[Data]", |k| format!("{k},{:.1}", x(k))),
        ),
        (
            "interval",
            values("Sampling interval,2.0E-02\nTrigger position,100\nNo.,OUT1", |k| {
                format!("{k},{:.1}", x(k))
            }),
        ),
        ("Hioki", values("\"Sampling interval\",\"20ms\"\n\"CH1\"\n\"V\"", value)),
        ("Yokogawa", values("\"TraceName\",\"CH1\"\n\"HResolution\",\"2.0E-02\"\n\"HUnit\",\"s\"", value)),
        ("Siglent", values("Sample Interval,Analog:2.0e-02\nVertical Units,CH1:V\nCH1 (Volt)", value)),
        ("Hantek", values("#CHANNEL:CH1\n#CLOCK=20.0ms\n#SIZE=300\n#UNITS:mV\n", value)),
        ("a camera", values("# fps: 50\nFrame,X,Y", |k| format!("{k},{:.1},{}", x(k), 300 + k % 3))),
        (
            "Qualisys",
            values(
                "NO_OF_FRAMES\t300\nFREQUENCY\t50\nTIME_STAMP\t2024-03-12, 10:22:33\nMARKER_NAMES\tm1",
                |k| format!("{:.1}\t{}.0\t120.{}", x(k), 800 + k % 2, k % 3),
            ),
        ),
        (
            "Igor",
            values("IGOR\nWAVES/D/N=(300)\tdeflection\nBEGIN", |k| format!("\t{:.1}", x(k)))
                + "END\nX SetScale/P x -0.1,20,\"ms\", deflection; SetScale y 0,0,\"V\", deflection\n",
        ),
        ("Infiniium", values("Points:,300\nXInc:,0.02\nXOrg:,-0.1\nYUnits:,Volt\nData", value)),
    ] {
        let reading = swing(text.as_bytes());
        assert!(matches!(reading.report.time, Some(TimeSource::Rate(_))), "{what}");
        assert!(notes(&reading).contains("50 Hz"), "{what}: {}", notes(&reading));
    }
    // A curve over frequency is none over time, whatever rate stands above it.
    let text = values("# Sample rate: 1000 Hz\nFrequency (Hz),Amplitude (V)", |k| {
        format!("{k}.5,{:.1}", x(k).abs())
    });
    assert!(read_from(text.as_bytes(), "curve.csv", &ReadOptions::default()).is_err());
}

#[test]
fn counts_of_an_unnamed_unit_are_those_of_the_rate_that_the_file_names() {
    for (above, count, unit, note) in [
        // Ten counts a millisecond, as the sensors of Movella count.
        ("// Update Rate: 50.0Hz\n", 200, "1/10000 s", "by the rate that the file names, 50 Hz"),
        ("// Update Rate: 50.0Hz\n", 20, "ms", "were taken as milliseconds"),
        ("// Update Rate: 70.0Hz\n", 20, "ms", "were taken as milliseconds"),
        ("", 20, "ms", "were taken as milliseconds"),
    ] {
        let row = |k: usize| format!("{}\t{:.1}", 123_450_000 + count * k, x(k));
        let reading = swing(table(&format!("{above}SampleTimeFine\tx (mm)"), row).as_bytes());
        assert_eq!(time_unit(&reading), unit, "{above}");
        assert!(notes(&reading).contains(note), "{}", notes(&reading));
    }
}

#[test]
fn a_time_of_day_and_the_part_of_a_second_beside_it_are_one_clock() {
    let clock = |k: usize| {
        let ms = 33_500 + 20 * k;
        (format!("10:22:{:02}", ms / 1000), ms % 1000)
    };
    let past_midnight = |k: usize| {
        let ms = (86_397_500 + 20 * k) % 86_400_000;
        let (h, m, s) = (ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60);
        format!("03/12/2024,{h:02}:{m:02}:{s:02},{},{:.1}", ms % 1000, x(k))
    };
    for text in [
        table("No,Date&Time,ms,x (mm)", |k| {
            let (time, ms) = clock(k);
            format!("{k},2024/03/12 {time},{ms},{:.1}", x(k))
        }),
        table("x (mm),Date,Time,Fractional Seconds", |k| {
            let (time, ms) = clock(k);
            format!("{:.1},03/12/2024,{time},{:.9}", x(k), ms as f64 / 1000.0)
        }),
        table("Time,Microseconds,x (mm)", |k| {
            let (time, ms) = clock(k);
            format!("{time},{},{:.1}", 1000 * ms, x(k))
        }),
        table("Date,Time,ms,x (mm)", past_midnight),
    ] {
        let reading = swing(text.as_bytes());
        let notes = notes(&reading);
        assert!(notes.contains("the times are the sum of column"), "{text:.90}: {notes}");
        assert_eq!(reading.report.runs, 1, "{notes}");
    }
    // Milliseconds that go up by themselves are a clock of their own.
    let own = table("Time,ms,x (mm)", |k| format!("{},{},{:.1}", clock(k).0, 20 * k, x(k)));
    let own = read_from(own.as_bytes(), "swing.csv", &ReadOptions::default()).unwrap();
    assert!(!notes(&own).contains("the sum of"), "{}", notes(&own));
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
    // Of a header that names no last column the names stay where they are.
    let text = table("t,x", |k| format!("{:.2},{:.1},{}", k as f64 * STEP_S, x(k), k % 3));
    assert_eq!(swing(text.as_bytes()).report.column("signal").unwrap().column.header, "x");
}

#[test]
fn stamps_of_a_serial_monitor_stand_before_an_arrow() {
    let clock = |k: usize| format!("12:34:{:06.3}", 5.0 + k as f64 * STEP_S);
    let alone = (0..ROWS).map(|k| format!("{} -> {:.1}\n", clock(k), x(k))).collect::<String>();
    let reading = swing(alone.as_bytes());
    assert_eq!(time_unit(&reading), "s");
    for (separator, header) in
        [(',', ""), ('\t', ""), (' ', ""), (',', "12:34:04.990 -> t,x\n"), ('\t', "12:34:04.990 -> t\tx\n")]
    {
        // Lines arrive late by a little.
        let late = |k: usize| format!("12:34:{:06.3}", 5.0 + k as f64 * STEP_S + 0.003 * (k % 3) as f64);
        let row = |k: usize| format!("{} -> {}{separator}{:.1}\n", late(k), 20 * k, x(k));
        let text = header.to_owned() + &(0..ROWS).map(row).collect::<String>();
        assert_eq!(time_unit(&swing(text.as_bytes())), "ms", "{text:.60}");
    }
}

#[test]
fn decimal_commas_between_commas_are_read_or_refused() {
    let comma = |k: usize| format!("{:.2},{:.1}", k as f64 * STEP_S, x(k)).replace('.', ",");
    let text = table("t,x", comma);
    let reading = swing(text.as_bytes());
    assert!(notes(&reading).contains("decimal marks too"), "{}", notes(&reading));
    swing((0..ROWS).map(|k| comma(k) + "\n").collect::<String>().as_bytes());
    let three = |k: usize| comma(k) + &format!(",{:.2}", k as f64 / 100.0).replace('.', ",");
    swing(table("t,x,n", three).as_bytes());
    // Whole numbers without a fraction leave open which comma is which.
    let trimmed = |k: usize| format!("{},{}", k as f64 * STEP_S, x(k)).replace('.', ",");
    let error =
        read_from(table("t,x", trimmed).as_bytes(), "swing.csv", &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("which comma is which"), "{error}");
    // Whole numbers alone are just that.
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
    // A unit says more than the name of the file.
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
fn ticks_are_those_of_the_clock_that_a_remark_names() {
    let row = |k: usize| format!("{};{:.1};0.5;1000", 6_000_000_000_u64 + 1_200_000 * k as u64, x(k));
    let text = table("% clockbase = 60000000\n% timestamp; x; y; freq", row);
    let reading = read_from(text.as_bytes(), "demod.csv", &ReadOptions::default()).unwrap();
    assert!((reading.record.duration_s() - 299.0 * STEP_S).abs() < 1e-9, "{}", reading.record.duration_s());
    assert_eq!(reading.record.kind(), SignalKind::LockIn);
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
    assert!(notes(&reading).contains("beside the first 18 rows"), "{}", notes(&reading));
    assert!(reading.report.named_values.contains(&("Probe Atten".to_owned(), "1.000000e+01".to_owned())));
    // The same below a header, as people write it into a sheet.
    let row =
        |k: usize| format!("{}\t\t{:.2}\t{:.1}\n", setting(k).replace(',', "\t"), k as f64 * STEP_S, x(k));
    let text = format!("setting\tvalue\t\tt (s)\tx (mm)\n{}", (0..ROWS).map(row).collect::<String>());
    assert_eq!(swing(text.as_bytes()).record.unit(), "mm");
    // A line of other values above the rows is none of them.
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
    // Words of the program, a name that comes and goes, and a line that was cut.
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

#[test]
fn json_of_any_arrangement_is_the_same_record() {
    let t = |k: usize| k as f64 * STEP_S;
    let joined = |row: &dyn Fn(usize) -> String, by: &str| (0..ROWS).map(row).collect::<Vec<_>>().join(by);
    let rows = joined(&|k| format!("[{:?}, {:?}]", t(k), x(k)), ",\n  ");
    let objects = |by| joined(&|k| format!("{{\"t (s)\": {:?}, \"x (mm)\": {:?}}}", t(k), x(k)), by);
    let times = joined(&|k| format!("{:?}", t(k)), ", ");
    let values = joined(&|k| format!("{:?}", x(k)), ", ");
    let by_index = |value: fn(f64) -> f64| joined(&|k| format!("\"{k}\": {:?}", value(k as f64)), ", ");
    let (index_t, index_x) = (by_index(|k| k * STEP_S), by_index(|k| x(k as usize)));
    for (text, unit) in [
        (format!("[\n  {rows}\n]\n"), ""),
        (format!("[[\"t (s)\", \"x (mm)\"], {rows}]"), "mm"),
        (format!("[[{times}], [{values}]]"), ""),
        (format!("[{}]", objects(", ")), "mm"),
        (objects("\n"), "mm"),
        (format!("{{\"t (s)\": [{times}], \"x (mm)\": [{values}]}}"), "mm"),
        (format!("{{\"data\": [{rows}]}}"), ""),
        (
            format!(
                "{{\"device\": {{\"id\": 7}}, \"run\": {{\"t (s)\": [{times}], \"x (mm)\": [{values}]}}}}"
            ),
            "mm",
        ),
        (format!("{{\"t (s)\": {{{index_t}}}, \"x (mm)\": {{{index_x}}}}}"), "mm"),
        (format!("{{\"columns\": [\"t (s)\", \"x (mm)\"], \"index\": [0, 1], \"data\": [{rows}]}}"), "mm"),
        (format!("{{\"fs\": 50, \"x (mm)\": [{values}]}}"), "mm"),
        (
            format!(
                "{{\"results\": [{{\"series\": [{{\"name\": \"swing\", \"columns\": [\"t (s)\", \"x (mm)\"], \"values\": [{rows}]}}]}}]}}"
            ),
            "mm",
        ),
        (joined(&|k| format!("{{\"ms\": {}, \"acc\": {{\"x (mm)\": {:?}}}}}", 20 * k, x(k)), "\n"), "mm"),
        (
            joined(&|k| format!("{{\"at\": \"12:34:{:06.3}\", \"x (mm)\": \"{}\"}}", 5.0 + t(k), x(k)), "\n"),
            "mm",
        ),
    ] {
        let reading = swing(text.as_bytes());
        assert_eq!(reading.record.unit(), unit, "{text:.80}");
        assert_eq!(reading.report.format, Format::Json, "{text:.80}");
    }
}

#[test]
fn channels_of_json_have_a_name_a_unit_and_a_rate_each() {
    let channel = |name: &str, rate: u32| {
        let values: Vec<String> = (0..ROWS).map(|k| format!("{:?}", x(k))).collect();
        let values = values.join(", ");
        format!(
            "{{\"name\": \"{name}\", \"unit\": \"rad\", \"sampleRate\": {rate}, \"samples\": [{values}]}}"
        )
    };
    let alone = swing(format!("{{\"channels\": [{}]}}", channel("Angle", 50)).as_bytes());
    assert_eq!((alone.record.unit(), &*alone.report.columns[0].header), ("rad", "Angle (rad)"));
    let text = format!("{{\"channels\": [{}, {}]}}", channel("Base", 10), channel("Angle", 50));
    for (sheet, rate_hz) in [("channels.1", 10.0), ("channels.2", 50.0)] {
        let options = ReadOptions { sheet: Some(sheet.to_owned()), ..Default::default() };
        let reading = read_from(text.as_bytes(), "swing.json", &options).unwrap();
        assert_eq!(reading.report.time, Some(TimeSource::Rate(rate_hz)), "{sheet}");
    }
}

#[test]
fn rows_of_several_sensors_are_tables_named_after_them() {
    let row = |sensor: &str, k: usize, gain: f64| {
        let t = k as f64 * STEP_S;
        format!("{{\"sensor\": \"{sensor}\", \"seconds_elapsed\": \"{t:?}\", \"z\": \"{:?}\"}}", gain * x(k))
    };
    let read = |text: &str, sheet: Option<&str>| {
        let options = ReadOptions { sheet: sheet.map(str::to_owned), ..Default::default() };
        read_from(text.as_bytes(), "swing.json", &options)
    };
    for (sensor, kind) in [
        ("Accelerometer", SignalKind::Acceleration),
        ("Gyroscope", SignalKind::Velocity),
        ("Pendulum", SignalKind::Displacement),
    ] {
        let rows: Vec<String> = (0..ROWS).map(|k| row(sensor, k, 1.0)).collect();
        let reading = swing(format!("[{}]", rows.join(", ")).as_bytes());
        assert_eq!((reading.record.kind(), &*reading.report.sheet), (kind, sensor));
    }
    let both = |k| [row("Accelerometer", k, 1.0), row("Gravity", k, 2.0)].join(", ");
    let rows: Vec<String> = (0..ROWS).map(both).collect();
    let text = format!("[{{\"version\": 3, \"sensor\": \"Metadata\"}}, {}]", rows.join(", "));
    let reading = read(&text, Some("accelerometer")).unwrap();
    assert_eq!(reading.record.kind(), SignalKind::Acceleration);
    assert_eq!(reading.record.signal(), (0..ROWS).map(x).collect::<Vec<_>>());
    assert!(reading.report.named_values.contains(&("version".to_owned(), "3".to_owned())));
    let reading = read(&text, Some("gravity")).unwrap();
    assert_eq!(reading.record.signal(), (0..ROWS).map(|k| 2.0 * x(k)).collect::<Vec<_>>());
    let refused = read(&text, None).unwrap_err();
    assert!(refused.to_string().contains("`Accelerometer` (seconds_elapsed, z); `Gravity`"), "{refused}");
    assert!(refused.hints().iter().any(|hint| hint.option == Some("sheet")), "{refused}");
}

#[test]
fn what_json_lacks_is_counted_and_what_is_broken_is_told() {
    let object = |k: usize| {
        let value = if k % 50 == 7 {
            ["null", "NaN", "\"overflow\""][k / 50 % 3].to_owned()
        } else {
            x(k).to_string()
        };
        format!("{{\"t\": {:?}, \"x\": {value}}}", k as f64 * STEP_S)
    };
    let text = (0..ROWS).map(object).collect::<Vec<_>>().join("\n");
    let reading = read_from(text.as_bytes(), "swing.json", &ReadOptions::default()).unwrap();
    assert_eq!((reading.record.len(), reading.report.rows_skipped()), (ROWS - 6, 6));
    assert_eq!(reading.report.skipped[0].first_row, 8, "{:?}", reading.report.skipped);
    let said = |text: &str| {
        read_from(text.as_bytes(), "swing.json", &ReadOptions::default()).unwrap_err().to_string()
    };
    for (text, problem) in [
        (&text[..text.len() - 5], "line 300"),
        (&text[..text.len() - 5], "breaks its rules"),
        ("{\"name\": \"pendulum\"}", "without a table that can be read: it holds no list of numbers"),
        ("[[[[1, 2], [\"a\"]]]]", "no table of numbers"),
    ] {
        assert!(said(text).contains(problem), "{}", said(text));
    }
    // Names that no two rows share would take a table of a million cells.
    let scattered: Vec<String> = (0..3000).map(|k| format!("{{\"a{k}\": {k}}}")).collect();
    assert!(said(&format!("[{}]", scattered.join(","))).contains("scattered over 3000 rows"));
    let several = format!("{{\"a\": [{text}], \"b\": [{text}]}}", text = text.replace('\n', ","));
    assert!(said(&several).contains("`a` (t, x); `b` (t, x)"), "{}", said(&several));
}

#[test]
fn times_in_samples_need_a_rate_and_an_unknown_unit_is_told() {
    let by_number = |header: &str| table(header, |k| format!("{k},{:.1}", x(k)));
    let read = |text: &str| read_from(text.as_bytes(), "swing.csv", &ReadOptions::default());
    let refused = read(&by_number("Time (samples),x")).unwrap_err().to_string();
    assert!(refused.contains("counts ticks or samples"), "{refused}");
    let named = format!("# fs = {} Hz\n{}", 1.0 / STEP_S, by_number("Time (samples),x"));
    assert_eq!(time_unit(&swing(named.as_bytes())), "samples");
    let told = notes(&read(&by_number("Time (lustrum),x")).unwrap());
    assert!(told.contains("lustrum is no unit that is known"), "{told}");
    for (unit, per_second) in
        [("msec.", 1e3), ("ミリ秒", 1e3), ("Sec/100", 100.0), (r"\si{\ms}", 1e3), (r"$\mu$s", 1e6)]
    {
        let text =
            table(&format!("t [{unit}],x"), |k| format!("{:.3},{:.1}", k as f64 * STEP_S * per_second, x(k)));
        assert_eq!(time_unit(&swing(text.as_bytes())), unit);
    }
}
