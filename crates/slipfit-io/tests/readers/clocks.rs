//! Times from clocks, stamps, counters and stated rates.

use slipfit::SignalKind;
use slipfit_io::{ReadOptions, TimeSource, read_from};

use crate::texts::{ROWS, STEP_S, notes, plain, swing, table, time_unit, x};

/// Hours, minutes, seconds and milliseconds of a row; the record begins at 23:59:57 if `late`, else at 09:59:58.
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
            // Milliseconds of a date are exact to the last digit.
            assert!(reading.record.clock().is_uniform(), "{first}");
        }
    }
    // Only minutes and seconds.
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
    assert!(notes(&reading).contains("restart at midnight"), "{}", notes(&reading));
}

#[test]
fn a_date_beside_the_clock_and_one_above_the_header_do_no_harm() {
    let row = |k: usize| {
        let (h, m, s, ms) = clock(k, false);
        format!("2024-05-01,{h:02}:{m:02}:{s:02}.{ms:03},{:.1}", x(k))
    };
    swing(table("Date,Time,x (mm)", row).as_bytes());
    // A line with as many cells as the rows, all of which read as numbers because dates do.
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
fn a_time_in_a_unit_of_another_quantity_gives_a_note() {
    for unit in ["mV", "rad"] {
        let reading = swing(plain(&format!("time ({unit});x (mm)")).as_bytes());
        let told = notes(&reading);
        assert!(told.contains(&format!("{unit} is not a unit of time: seconds were taken")), "{told}");
    }
    let reading = swing(plain("time (s);x (mm)").as_bytes());
    assert!(!notes(&reading).contains("not a unit of time"));
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
    // A curve over frequency is not a record over time, whatever rate is stated above it.
    let text = values("# Sample rate: 1000 Hz\nFrequency (Hz),Amplitude (V)", |k| {
        format!("{k}.5,{:.1}", x(k).abs())
    });
    assert!(read_from(text.as_bytes(), "curve.csv", &ReadOptions::default()).is_err());
}

#[test]
fn counts_of_an_unnamed_unit_are_those_of_the_rate_that_the_file_names() {
    for (above, count, unit, note) in [
        // Ten counts per millisecond, as in sensors of Movella.
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
    // Milliseconds that increase by themselves are a separate clock.
    let own = table("Time,ms,x (mm)", |k| format!("{},{},{:.1}", clock(k).0, 20 * k, x(k)));
    let own = read_from(own.as_bytes(), "swing.csv", &ReadOptions::default()).unwrap();
    assert!(!notes(&own).contains("the sum of"), "{}", notes(&own));
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
        // Lines arrive with a small delay.
        let late = |k: usize| format!("12:34:{:06.3}", 5.0 + k as f64 * STEP_S + 0.003 * (k % 3) as f64);
        let row = |k: usize| format!("{} -> {}{separator}{:.1}\n", late(k), 20 * k, x(k));
        let text = header.to_owned() + &(0..ROWS).map(row).collect::<String>();
        assert_eq!(time_unit(&swing(text.as_bytes())), "ms", "{text:.60}");
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
fn times_in_samples_need_a_rate_and_an_unknown_unit_gives_a_note() {
    let by_number = |header: &str| table(header, |k| format!("{k},{:.1}", x(k)));
    let read = |text: &str| read_from(text.as_bytes(), "swing.csv", &ReadOptions::default());
    let refused = read(&by_number("Time (samples),x")).unwrap_err().to_string();
    assert!(refused.contains("counts ticks or samples"), "{refused}");
    let named = format!("# fs = {} Hz\n{}", 1.0 / STEP_S, by_number("Time (samples),x"));
    assert_eq!(time_unit(&swing(named.as_bytes())), "samples");
    let told = notes(&read(&by_number("Time (lustrum),x")).unwrap());
    assert!(told.contains("lustrum is not a known unit"), "{told}");
    for (unit, per_second) in
        [("msec.", 1e3), ("ミリ秒", 1e3), ("Sec/100", 100.0), (r"\si{\ms}", 1e3), (r"$\mu$s", 1e6)]
    {
        let text =
            table(&format!("t [{unit}],x"), |k| format!("{:.3},{:.1}", k as f64 * STEP_S * per_second, x(k)));
        assert_eq!(time_unit(&swing(text.as_bytes())), unit);
    }
}
