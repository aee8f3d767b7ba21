//! Choice of columns, their units, and the kind of the signal.

use super::*;

#[test]
fn columns_are_taken_by_name_number_or_part_of_a_name() {
    let text = table_of("t (s);alpha (rad);beta angle (rad)\n", 40, |_, t, x| format!("{t};{};{x}", 2.0 * x));
    for wanted in ["3", "beta angle (rad)", "BETA ANGLE", "beta"] {
        let options = ReadOptions { signal: Some(wanted.into()), ..Default::default() };
        let reading = read_with(&text, &options).unwrap();
        assert_is_ring(&reading, 40);
        assert_eq!(signal(&reading).why, "column 3 `beta angle (rad)`: asked for");
    }
    let ask = |wanted: &str| error(&text, &ReadOptions { signal: Some(wanted.into()), ..Default::default() });
    assert_eq!(
        ask("gamma").0,
        "file.csv: signal = gamma: no such column; the columns are column 1 `t (s)`, column 2 `alpha (rad)`, column 3 `beta angle (rad)`"
    );
    assert_eq!(
        ask("rad").0,
        "file.csv: signal = rad: could be column 2 `alpha (rad)`, column 3 `beta angle (rad)`"
    );
    assert!(ask("4").0.contains("no such column"));
    assert!(ask("0").0.contains("no such column"));
    assert!(ask("").0.contains("no such column"));
}

#[test]
fn a_position_is_preferred_to_its_derivatives_and_to_spectra() {
    let header =
        "Frequenz f / Hz;FFT / rad;Zeit t / s;Geschwindigkeit v / rad/s;Beschleunigung / rad/s²;Weg / rad\n";
    let reading =
        read(table_of(header, 60, |i, t, x| format!("{i};{};{t};{};{};{x}", 9 * i, 9.0 * x, 99.0 * x)));
    assert_is_ring(&reading, 60);
    assert_eq!((time_column(&reading), signal(&reading).column.number), (3, 6));
    assert_eq!(reading.record.kind(), SignalKind::Displacement);
}

#[test]
fn kinds_follow_names_and_units() {
    for (header, kind, unit) in [
        ("t,v (m/s)\n", SignalKind::Velocity, "m/s"),
        ("t,ω (rad/s)\n", SignalKind::Velocity, "rad/s"),
        ("t,Acceleration y (m/s²)\n", SignalKind::Acceleration, "m/s²"),
        ("t,a (g)\n", SignalKind::Acceleration, "g"),
        ("t,Amplitude (mm)\n", SignalKind::Displacement, "mm"),
        ("t,Angle (deg)\n", SignalKind::Displacement, "deg"),
    ] {
        let reading = read(table_of(header, 40, |_, t, x| format!("{t},{x}")));
        assert_eq!((reading.record.kind(), reading.record.unit()), (kind, unit), "{header}");
    }
    let reading = read(table_of("t,R (V)\n", 40, |_, t, x| format!("{t},{}", x * x + 0.1)));
    assert_eq!(reading.record.kind(), SignalKind::Envelope);
    let options =
        ReadOptions { kind: Some(SignalKind::Velocity), unit: Some("mm/s".into()), ..Default::default() };
    let reading = read_with(table_of("t,x\n", 40, |_, t, x| format!("{t},{x}")), &options).unwrap();
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Velocity, "mm/s"));
}

#[test]
fn decibels_become_linear_amplitudes() {
    let text = table_of("time [s], power [dBm]\n", 40, |i, t, _| format!("{t}, {}", -20.0 - 0.5 * i as f64));
    let reading = read(&text);
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Envelope, "√mW"));
    // -20 dBm is 0.01 mW, whose root is 0.1.
    assert!((reading.record.signal()[0] - 0.1).abs() < 1e-15);
    let options = ReadOptions { unit: Some("dB".into()), ..Default::default() };
    let reading = read_with(text.replace("power [dBm]", "level"), &options).unwrap();
    assert!((reading.record.signal()[0] - 0.1).abs() < 1e-15);
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Envelope, ""));
}

#[test]
fn lock_in_outputs_are_read_as_a_pair() {
    let row = |_, t, x: f64| format!("{t},{x},{},{},30", 2.0 * x, 3.0 * x.abs());
    for (header, options) in [
        ("t (s),X (V),Y (V),R (V),Theta (deg)\n", ReadOptions::default()),
        ("t,In-Phase,Quadrature,c,d\n", ReadOptions::default()),
        (
            "t,a,b,c,d\n",
            ReadOptions { signal: Some("2".into()), quadrature: Some("3".into()), ..Default::default() },
        ),
    ] {
        let reading = read_with(table_of(header, 40, row), &options).unwrap();
        assert_eq!(reading.record.kind(), SignalKind::LockIn, "{header}");
        let quadrature = reading.record.quadrature().unwrap();
        assert!(quadrature.iter().zip(reading.record.signal()).all(|(q, x)| *q == 2.0 * x), "{header}");
    }
    let lock_in = ReadOptions { kind: Some(SignalKind::LockIn), ..Default::default() };
    let (said, hint) = error(table_of("t (s),x (V)\n", 40, |_, t, x| format!("{t},{x}")), &lock_in);
    assert!(said.contains("no column could be the Y output of the lock-in; the file has column 1"), "{said}");
    assert!(hint.contains("quadrature names the Y output"), "{hint}");
    let reading =
        read(table_of("t (s),R (V),Theta (deg)\n", 40, |i, t, x| format!("{t},{},{i}", x.abs() + 0.1)));
    assert_eq!((reading.record.kind(), signal(&reading).column.number), (SignalKind::Envelope, 2));
}

#[test]
fn positions_in_two_directions_are_no_lock_in() {
    let reading = read(table_of("t\tx\ty\n", 200, |_, t, x| format!("{t}\t{}\t{x}", 0.1 * x * x)));
    assert_eq!(reading.record.kind(), SignalKind::Displacement);
    assert_eq!(signal(&reading).column.number, 3);
}

#[test]
fn time_units_come_from_headers_and_may_be_overridden() {
    for (header, factor) in [
        ("Δt (ms),x\n", 1e3),
        ("time_us,x\n", 1e6),
        ("t [ns],x\n", 1e9),
        ("Zeit / s,x\n", 1.0),
        ("t (µs),x\n", 1e6),
        ("us,x\n", 1e6),
        ("µs,x\n", 1e6),
        ("usec,x\n", 1e6),
        ("TimeUS,x\n", 1e6),
        ("timestampNs,x\n", 1e9),
        ("timestamp_ms,x\n", 1e3),
        ("Время (мс),x\n", 1e3),
        ("t [1/100 s],x\n", 1e2),
        ("time(10ms),x\n", 1e2),
        ("Time [x 10ms],x\n", 1e2),
        ("Time (10^-3 s),x\n", 1e3),
    ] {
        assert_is_ring(&read(table_of(header, 40, |_, t, x| format!("{},{x}", t * factor))), 40);
    }
    assert_is_ring(&read(table_of("Time (min),x\n", 40, |_, t, x| format!("{},{x}", t / 60.0))), 40);
    let text = table_of("t (s),x\n", 40, |_, t, x| format!("{},{x}", t * 1e3));
    let unit = |unit: &str| ReadOptions { time_unit: Some(unit.into()), ..Default::default() };
    assert_is_ring(&read_with(&text, &unit("ms")).unwrap(), 40);
    let (message, hint) = error(&text, &unit("fortnight"));
    assert_eq!(message, "file.csv: time_unit = fortnight: not a known unit");
    assert!(hint.starts_with("time_unit takes"));
}

#[test]
fn steps_since_the_row_before_are_summed() {
    let text = table_of("", 60, |i, _, x| format!("{x} 0.1 {}", if i == 0 { 0.0 } else { 62.5 }));
    let reading = read(text);
    assert!(matches!(reading.report.time, Some(TimeSource::Intervals(_))));
    assert_is_ring(&reading, 60);
}

#[test]
fn tables_side_by_side_and_runs_in_groups_are_chosen() {
    let text = table_of("Time (s),x (mm),,Time (s),x (mm)\n", 40, |i, t, x| {
        if i < 30 { format!("{},{},,{t},{x}", t + 1.0, 2.0 * x) } else { format!(",,,{t},{x}") }
    });
    let first = read(&text);
    assert_eq!((first.report.parts, first.report.part, first.record.len()), (2, 1, 30));
    assert!(first.report.notes.iter().any(|n| n.hints[0].option == Some("part")));
    let table = |n| ReadOptions { part: Some(n), ..Default::default() };
    assert_is_ring(&read_with(&text, &table(2)).unwrap(), 40);
    assert_eq!(error(&text, &table(3)).0, "file.csv: part = 3: the file has only 2");
    for header in [
        "t1,theta1,omega1,t2,theta2,omega2\n",
        "Time (s) Run #1,Angle (rad) Run #1,v (rad/s) Run #1,Time (s) Run #2,Angle (rad) Run #2,v (rad/s) Run #2\n",
        "Latest: Time (s),Latest: Angle (rad),Latest: v (rad/s),Run 1: Time (s),Run 1: Angle (rad),Run 1: v (rad/s)\n",
    ] {
        let text = table_of(header, 40, |_, t, x| format!("{},{},{x},{t},{x},{}", t + 1.0, 2.0 * x, 5.0 * x));
        assert_eq!(read(&text).record.signal()[0], 2.0, "{header}");
        let second = read_with(&text, &ReadOptions { run: Some(2), ..Default::default() }).unwrap();
        assert_is_ring(&second, 40);
        assert_eq!((second.report.runs, second.report.run), (2, 2));
        let by_column =
            read_with(&text, &ReadOptions { signal: Some("5".into()), ..Default::default() }).unwrap();
        assert_is_ring(&by_column, 40);
    }
    let shared =
        table_of("Time (s),Angle (rad) Run #1,Angle (rad) Run #2\n", 40, |_, t, x| format!("{t},9,{x}"));
    assert_is_ring(&read_with(&shared, &ReadOptions { run: Some(2), ..Default::default() }).unwrap(), 40);
}

#[test]
fn a_rate_stands_for_a_time_column_and_a_missing_one_is_asked_for() {
    let text = table_of("Position (mm) Run #1\n", 60, |i, _, x| {
        if i == 30 { "--".into() } else { format!("{x:.3}").replace('.', ",") }
    });
    let (message, hint) = error(&text, &ReadOptions::default());
    assert_eq!(message, "file.csv: no column of times; the file has column 1 `Position (mm) Run #1`");
    assert!(hint.starts_with("rate_hz"), "{hint}");
    let rated = ReadOptions { rate_hz: Some(16.0), ..Default::default() };
    let reading = read_with(&text, &rated).unwrap();
    assert_eq!((reading.record.len(), reading.record.unit()), (59, "mm"));
    assert!((reading.record.time_s(30) - 31.0 / 16.0).abs() < 1e-12);
    let hinted = format!("angle_deg, sample_rate\n45, 1000\n{}", table_of("", 40, |_, _, x| x.to_string()));
    assert!(error(&hinted, &ReadOptions::default()).1.starts_with("rate_hz takes"));
    let both = ReadOptions { time: Some("1".into()), ..rated };
    assert_eq!(error(&text, &both).0, "file.csv: time = 1: cannot be combined with a sampling rate");
    for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-310] {
        let (_, hint) = error(&text, &ReadOptions { rate_hz: Some(rate_hz), ..Default::default() });
        assert!(hint.contains("rate_hz"));
    }
}

#[test]
fn names_that_do_not_fit_the_columns_give_way_to_the_numbers() {
    let reading = read(table_of("x y dx dy\n", 60, |_, t, x| format!("{x}\t{t}")));
    assert_is_ring(&reading, 60);
    assert_eq!(
        note(&reading, 0),
        "line 1 names 4 columns (`x y dx dy`) but the rows hold 2: its names were not used"
    );
    let reading = read(table_of("time,angle\n", 60, |_, t, x| format!("{x},{t}")));
    assert_eq!(time_column(&reading), 2);
    let note = "column 1 `time` is named like a time but does not increase; column 2 `angle` does";
    assert_eq!(self::note(&reading, 0), note);
}

#[test]
fn a_ring_down_is_told_from_its_drive_by_its_numbers() {
    let text = table_of("", 2000, |i, t, x| {
        let drive = if i < 900 { 30.0 * (2.0 * t).sin() } else { 0.0 };
        format!("{t}\t{drive}\t{x}")
    });
    let reading = read(text);
    assert_is_ring(&reading, 2000);
    assert_eq!(
        signal(&reading).why,
        "column 3: has the strongest decaying oscillation among column 2, column 3"
    );
    assert!(matches!(reading.record.clock(), Clock::Uniform { .. }));
}

/// White noise of rms 1, the same on every machine.
fn noise(i: usize) -> f64 {
    let scrambled = (i as f64 * 12.9898).sin() * 43758.5453;
    12_f64.sqrt() * (scrambled - scrambled.floor() - 0.5)
}

/// The acceleration of a phone whose swing is stopped by a constant force within `stop_s`.
fn swing(t: f64, stop_s: f64) -> f64 {
    (1.0 - t / stop_s).max(0.0) * (9.0 * t).cos()
}

#[test]
fn of_three_axes_the_one_that_swings_is_taken_whatever_noise_its_rest_leaves_on_the_others() {
    for (rows, stop_s) in [(6000, 9.0), (60_000, 12.0)] {
        for strong in 0..3 {
            let text = table_of("t (s),ax (m/s^2),ay (m/s^2),az (m/s^2)\n", rows, |i, _, _| {
                let t = 0.01 * i as f64;
                let axis = |k: usize| {
                    let part = if k == strong { 3.0 } else { 0.06 };
                    let bias = [0.1, -0.05, 9.81][k];
                    format!("{:.5}", bias + part * swing(t, stop_s) + 0.01 * noise(3 * i + k))
                };
                format!("{t:.2},{},{},{}", axis(0), axis(1), axis(2))
            });
            let reading = read(text);
            assert_eq!(signal(&reading).column.number, strong + 2, "{rows} rows: {}", signal(&reading).why);
        }
    }
}

#[test]
fn of_an_ellipse_the_long_axis_is_taken_in_either_sense_of_rotation() {
    for sense in [1.0, -1.0] {
        let text = table_of("t (s),ax (m/s^2),ay (m/s^2)\n", 2000, |i, _, _| {
            let t = 0.01 * i as f64;
            let decay = (-0.1 * t).exp();
            let (x, y) = (0.2 * decay * (9.0 * t).cos(), sense * decay * (9.0 * t).sin());
            format!("{t:.2},{x:.5},{y:.5}")
        });
        assert_eq!(signal(&read(text)).column.number, 3, "{sense}");
    }
}

#[test]
fn a_counter_of_rows_is_no_time_unless_named_or_asked_for() {
    let text = table_of("", 60, |i, _, x| format!("{i},{x}"));
    assert!(error(&text, &ReadOptions::default()).1.contains("time "));
    let asked = ReadOptions { time: Some("1".into()), ..Default::default() };
    assert_eq!(read_with(&text, &asked).unwrap().record.time_s(59), 59.0);
    assert_eq!(read(format!("time (s),x\n{text}")).record.time_s(59), 59.0);
    let rated = ReadOptions { rate_hz: Some(16.0), ..Default::default() };
    assert_is_ring(&read_with(&text, &rated).unwrap(), 60);
}

#[test]
fn whole_numbers_some_apart_are_milliseconds_and_said_to_be() {
    let reading = read(table_of("", 64, |i, _, x| format!("{} {x}", i * 50)));
    assert_eq!(reading.record.duration_s(), 3.15);
    assert!(note(&reading, 0).contains("50.0 apart: they were taken as milliseconds"));
}

#[test]
fn equal_steps_under_the_name_of_a_step_are_summed() {
    assert_is_ring(&read(table_of("dt (ms),x (mm)\n", 40, |_, _, x| format!("62.5,{x}"))), 40);
}

#[test]
fn clocks_since_1970_are_in_their_unit_and_give_way_to_seconds_since_the_start() {
    let stamp = |t: f64| 1_662_729_295_900_810_000_u64 + (t * 1e9) as u64;
    let both = table_of("time,seconds_elapsed,x\n", 99, |_, t, x| format!("{},{t},{x}", stamp(t)));
    let reading = read(both);
    assert_eq!(time_column(&reading), 2);
    assert_is_ring(&reading, 99);
    for (unit, divisor) in [("ns", 1), ("us", 1_000), ("ms", 1_000_000)] {
        let one = table_of("time,x\n", 99, |_, t, x| format!("{},{x}", stamp(t) / divisor));
        let reading = read(one);
        assert!((reading.record.clock_report().median_step_s - 0.0625).abs() < 1e-3, "{unit}");
        assert!((reading.record.duration_s() - 6.125).abs() < 2e-3, "{unit}");
        assert!(note(&reading, 0).contains(&format!("were taken as {unit}")), "{}", note(&reading, 0));
    }
}

#[test]
fn each_sensor_has_its_own_times() {
    let header = "#Time A\tPos A\tTime B\tPos B\n#[s]\t[au]\t[s]\t[au]\n";
    let still = |i: usize| 500.0 + 0.01 * ((i * 7919) % 3) as f64;
    let row = |i: usize, t: f64, x: f64| format!("{}\t{}\t{t}\t{x}", t + 0.025, still(i));
    let reading = read(table_of(header, 99, row));
    assert_eq!((time_column(&reading), signal(&reading).column.number), (3, 4));
    assert_is_ring(&reading, 99);
}

/// A phone on a pendulum that measures gravity, and another one on a spring.
#[test]
fn the_axis_across_a_pendulum_goes_before_that_along_it() {
    let phone = |across: fn(f64) -> f64, along: fn(f64, f64) -> f64| {
        let rows = (0..900).map(|i| {
            let t = f64::from(i) / 50.0;
            let (amplitude, noise) = (0.4 * (-0.04 * t).exp(), 0.01 * (1e5 * t).sin());
            let (angle, velocity) = (amplitude * (4.4 * t).cos(), -amplitude * (4.4 * t).sin());
            format!("{t},{},{},{noise}\n", across(angle) + noise, along(angle, velocity) - noise)
        });
        let header = "t (s),Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z (m/s^2)\n";
        let reading = read(header.to_owned() + &rows.collect::<String>());
        (signal(&reading).column.number, reading.record.has_turning_gravity())
    };
    let along = |angle: f64, velocity: f64| 9.81 * (angle.cos() + 0.8 * velocity * velocity);
    assert_eq!(phone(|angle| 1.96 * angle, along), (2, true));
    assert_eq!(phone(|_| 0.1, along), (3, false));
    assert_eq!(phone(|angle| -4.0 * angle, |_, _| 9.81), (2, false));
    assert_eq!(phone(|angle| 0.1 * angle, |angle, _| 9.81 - 4.0 * angle), (3, false));
    // The linear acceleration is that of the swing only.
    assert_eq!(phone(|angle| 7.8 * angle, |_, velocity| 7.8 * velocity * velocity), (2, false));
}

#[test]
fn whole_numbers_far_apart_are_microseconds_or_nanoseconds_and_said_to_be() {
    for (header, per_second, of_what) in
        [("", 1e6, "microseconds"), ("timestamp,x\n", 1e6, "microseconds"), ("t,x\n", 1e9, "nanoseconds")]
    {
        let reading = read(table_of(header, 40, |_, t, x| format!("{},{x}", t * per_second)));
        assert_is_ring(&reading, 40);
        let said = reading.report.notes.iter().find(|n| n.text.contains(of_what)).unwrap();
        assert_eq!(said.hints[0].option, Some("time_unit"), "{header}");
    }
    let tide = read(table_of("seconds,x\n", 40, |_, t, x| format!("{},{x}", t * 57_600.0)));
    assert_eq!(tide.record.time_s(1), 3600.0);
}

#[test]
fn seconds_and_nanoseconds_in_two_columns_are_added() {
    let row = |_: usize, t: f64, x: f64| {
        let t = 1_699_023_120.0 + t;
        format!("{},{},{x}", t.floor(), (t - t.floor()) * 1e9)
    };
    for header in [
        "secs,nsecs,position\n",
        ".header.stamp.secs,.header.stamp.nsecs,.joint_states.position\n",
        "sec,nanosec,x\n",
    ] {
        let reading = read(table_of(header, 200, row));
        assert_eq!(
            (reading.record.len(), time_column(&reading), signal(&reading).column.number),
            (200, 1, 3),
            "{header}"
        );
        for i in [1, 17, 199] {
            assert!((reading.record.time_s(i) - 1_699_023_120.0 - ring(i).0).abs() < 1e-6, "{header}");
        }
        assert!(
            reading.report.notes.iter().any(|n| n.hints.first().is_some_and(|h| h.option == Some("time")))
        );
    }
    // Next to the outputs of a lock-in.
    let text =
        table_of("secs,nsecs,In-Phase,Quadrature\n", 60, |i, t, x| format!("{},{}", row(i, t, x), 2.0 * x));
    let reading = read(text);
    let quadrature = reading.record.quadrature().unwrap();
    assert!(quadrature.iter().zip(reading.record.signal()).all(|(q, x)| *q == 2.0 * x));
    // If requested, one of them is the time.
    let options = ReadOptions { time: Some("nsecs".into()), ..Default::default() };
    let reading =
        read_with(table_of("secs,nsecs,x\n", 16, |i, _, x| format!("7,{},{x}", i * 62_500_000)), &options);
    assert_is_ring(&reading.unwrap(), 16);
}

#[test]
fn a_unit_goes_before_a_letter_and_gyroscopes_are_told_by_what_stands_beside_them() {
    for (header, kind, unit) in [
        ("t,V (V)\n", SignalKind::Displacement, "V"),
        ("t,v [V]\n", SignalKind::Displacement, "V"),
        ("t,V1 (V)\n", SignalKind::Displacement, "V"),
        ("time,V(out)\n", SignalKind::Displacement, "V"),
        ("t,ax (V)\n", SignalKind::Displacement, "V"),
        ("t,A0\n", SignalKind::Displacement, ""),
        ("t,gz (deg/s)\n", SignalKind::Velocity, "deg/s"),
        ("t,gz_dps\n", SignalKind::Velocity, "dps"),
        ("t,acc_g\n", SignalKind::Acceleration, "g"),
        ("t / s,v / ms⁻¹\n", SignalKind::Velocity, "ms⁻¹"),
        ("t,a (m/s/s)\n", SignalKind::Acceleration, "m/s/s"),
        ("t,a (meter / second ** 2)\n", SignalKind::Acceleration, "meter / second ** 2"),
        ("t,dx/dt\n", SignalKind::Velocity, ""),
        ("t,AccX\n", SignalKind::Acceleration, ""),
        ("time,gFx\n", SignalKind::Acceleration, "g"),
    ] {
        let reading = read(table_of(header, 40, |_, t, x| format!("{t},{x}")));
        assert_eq!((reading.record.kind(), reading.record.unit()), (kind, unit), "{header}");
    }
    let row = |_: usize, t: f64, x: f64| format!("{t},0.01,0.02,1,0.1,0.2,{x}");
    let reading = read(table_of("t,ax,ay,az,gx,gy,gz\n", 80, row));
    assert_eq!((reading.record.kind(), signal(&reading).column.number), (SignalKind::Velocity, 7));
    // The noise of a gyroscope does not take precedence over an oscillating acceleration.
    for header in ["t,ax,ay,gx,gy\n", "t,AccX,AccY,GyrX,GyrY\n"] {
        let row = |i: usize, t: f64, _: f64| {
            let x = 9.0 * (-0.05 * t).exp() * (2.0 * t).cos();
            format!("{t},{x},0.01,{},{}", noise(i), noise(i + 999))
        };
        let reading = read(table_of(header, 400, row));
        assert_eq!(
            (reading.record.kind(), signal(&reading).column.number),
            (SignalKind::Acceleration, 2),
            "{header}"
        );
    }
    let units = "t\tShimmer_Accel_X_CAL\nms\tm/(s^2)\n";
    let reading = read(table_of(units, 40, |_, t, x| format!("{}\t{x}", t * 1e3)));
    assert_is_ring(&reading, 40);
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Acceleration, "m/(s^2)"));
}

#[test]
fn a_name_of_a_date_is_no_hindrance_to_times() {
    let clock = |t: f64| format!("{:02}:{:07.4}", (t / 60.0).floor(), t % 60.0);
    for header in
        ["Date/Time", "Date Time", "Datum", "Datum/Zeit", "Fecha y hora", "\"Date Time, GMT+01:00\""]
    {
        let text =
            table_of(&format!("{header},x (mm)\n"), 40, |_, t, x| format!("2023-11-03 00:{},{x}", clock(t)));
        let reading = read(text);
        assert_eq!(time_column(&reading), 1, "{header}");
        assert_is_ring(&reading, 40);
    }
    // As stored in a spreadsheet.
    let text = table_of("Datum;x (mm)\n", 40, |_, t, x| format!("{};{x}", 3_908_001_123.0 + t));
    assert_eq!(time_column(&read(text)), 1);
    let hobo = "\"#\",\"Date Time, GMT+01:00\",\"Accel, g (LGR S/N: 2345)\"\n";
    let reading = read(table_of(hobo, 40, |i, t, x| format!("{},11/03/23 12:{} AM,{x}", i + 1, clock(t))));
    assert_is_ring(&reading, 40);
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Acceleration, "g"));
    // A date next to the time of day is not used.
    let text = table_of("Date,Time (s),x\n", 40, |_, t, x| format!("2023-11-03,{t},{x}"));
    assert_eq!(time_column(&read(text)), 2);
}

#[test]
fn a_force_or_a_sample_alone_beside_the_times_is_the_signal() {
    for (header, unit) in [
        ("Force (N)", "N"),
        ("Kraft (N)", "N"),
        ("Sound Pressure (Pa)", "Pa"),
        ("Sample R (V)", "V"),
        ("Force", ""),
    ] {
        let text = table_of(&format!("t (s),{header}\n"), 40, |_, t, x| format!("{t},{x}"));
        let reading = read(text);
        assert_is_ring(&reading, 40);
        assert_eq!(
            (reading.record.kind(), reading.record.unit()),
            (SignalKind::Displacement, unit),
            "{header}"
        );
        assert!(reading.report.notes.iter().any(|n| n.text.contains("only column apart from the times")));
    }
    for header in ["Frequency (Hz)", "sigma", "Temperature"] {
        let text = table_of(&format!("t (s),{header}\n"), 40, |_, t, x| format!("{t},{x}"));
        assert!(read_with(text, &ReadOptions::default()).is_err(), "{header}");
    }
    let reading = read(table_of("t (s),Force (N),x (mm)\n", 40, |i, t, x| format!("{t},{},{x}", i % 7)));
    assert_eq!(signal(&reading).column.number, 3);
}
