//! `slipfit map`: a trace in each pixel.

use crate::common::{root, slipfit, stdout};
use std::fs;
use std::path::{Path, PathBuf};

fn stack(name: &str) -> PathBuf {
    root().join("validation/reference/maps").join(name)
}

fn refusal(file: &Path, args: &str) -> String {
    let output = slipfit().arg("map").arg(file).args(args.split_whitespace()).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{args}");
    let said = String::from_utf8(output.stderr).unwrap();
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A column of a table by its name, one value per pixel.
fn column(csv: &str, name: &str) -> Vec<String> {
    let mut lines = csv.lines().filter(|l| !l.starts_with('#'));
    let at = lines.next().unwrap().split(',').position(|n| n == name).unwrap();
    lines.map(|l| l.split(',').nth(at).unwrap().to_owned()).collect()
}

fn numbers(csv: &str, name: &str) -> Vec<f64> {
    column(csv, name).iter().map(|v| v.parse().unwrap()).collect()
}

#[test]
fn pixels_have_the_losses_that_were_put_in() {
    for (file, args) in [("stack.npy", "--unit nm"), ("stack.h5", "--axis 0")] {
        let args = format!("--dt 0.02 --frequency-hz 75000 --table - -q {args}");
        let csv = stdout(slipfit().arg("map").arg(stack(file)).args(args.split_whitespace()));
        assert_eq!(numbers(&csv, "y"), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        assert_eq!(numbers(&csv, "x"), [0.0, 1.0, 2.0, 0.0, 1.0, 2.0]);
        let (rate, error) = (numbers(&csv, "sliding_rate"), numbers(&csv, "sliding_rate_std_error"));
        let (decay, decay_error) =
            (numbers(&csv, "decay_rate_per_s"), numbers(&csv, "decay_rate_std_error_per_s"));
        for (i, x) in numbers(&csv, "x").iter().enumerate() {
            let (y, left) = ((i / 3) as f64, |value: f64, error: f64| (value / error).abs());
            // Random deviations exceed four standard errors once in ten thousand.
            assert!(left(rate[i] - 0.05 * x, error[i]) < 4.0, "{file} {i}: {rate:?}");
            assert!(left(decay[i] - 0.5 * (1.0 + y), decay_error[i]) < 4.0, "{file} {i}: {decay:?}");
        }
        // x_F = a0/(4 f) at a high quality factor.
        let x_f = numbers(&csv, "friction_displacement");
        assert!((x_f[5] * 4.0 * 75_000.0 / rate[5] - 1.0).abs() < 1e-6);
    }
}

#[test]
fn all_files_give_the_same_table() {
    let csv = |file: &str, args: &str| {
        let args = format!("--dt 0.02 --table - -q {args}");
        stdout(slipfit().arg("map").arg(stack(file)).args(args.split_whitespace()))
    };
    let table = csv("stack.npy", "");
    for (file, args) in [
        ("stack.h5", "--axis 0 --data scan/amplitude"),
        ("stack.zarr", ""),
        ("blosc.zarr", "--axis 0 --data scan/amplitude"),
        ("blosc.zarr", "--axis 0"),
        ("fortran.zarr", ""),
    ] {
        assert_eq!(csv(file, args), table, "{file}");
    }
}

#[test]
fn a_map_is_an_image_for_each_name() {
    let folder = tempfile::tempdir().unwrap();
    let (npy, arrow) = (folder.path().join("map.npy"), folder.path().join("map.arrow"));
    for path in [&npy, &arrow] {
        stdout(
            slipfit().arg("map").arg(stack("stack.npy")).args(["--dt", "0.02", "-q", "--table"]).arg(path),
        );
    }
    let bytes = fs::read(npy).unwrap();
    let npy = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(npy.shape(), [2, 3]);
    let names = npy.dtype().descr();
    assert!(
        names.contains("('friction_displacement', '<f8')") && names.contains("('sliding_detected', '|b1')")
    );
    // The header is padded to a multiple of 64 bytes, a cache line.
    let header = 12 + u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
    assert_eq!(header % 64, 0);
    assert_eq!((bytes.len() - header) % 6, 0);
    assert!(fs::read(arrow).unwrap().starts_with(b"ARROW1"));
}

#[test]
fn the_screen_counts_and_the_picture_names_traces() {
    let folder = tempfile::tempdir().unwrap();
    let plot = folder.path().join("map.svg");
    let mut command = slipfit();
    command.arg("map").arg(stack("stack.h5")).args(["--dt", "0.02", "--axis", "0", "--plot"]).arg(&plot);
    let said = stdout(&mut command);
    assert!(said.contains("2 × 3 pixels of 128 samples"), "{said}");
    assert!(said.contains("6 done"), "{said}");
    assert!(said.contains("sliding friction detected in 4"), "{said}");
    let svg = fs::read_to_string(plot).unwrap();
    for pixel in ["[:, 0, 0]", "[:, 1, 2]"] {
        assert!(svg.contains(pixel), "{pixel}");
    }
    let png = folder.path().join("map.png");
    command.arg("--force").args(["--quiet"]);
    stdout(slipfit().arg("map").arg(stack("stack.npy")).args(["--dt", "0.02", "-q", "--plot"]).arg(&png));
    assert!(fs::read(png).unwrap().starts_with(b"\x89PNG"));
}

/// A kept block is reused, but only with the same numbers and options.
#[test]
fn finished_blocks_are_taken_up() {
    let folder = tempfile::tempdir().unwrap();
    let (blocks, copy) = (folder.path().join("blocks"), folder.path().join("stack.npy"));
    fs::copy(stack("stack.npy"), &copy).unwrap();
    let map = |more: &[&str]| {
        let mut command = slipfit();
        command.arg("map").arg(&copy).args(["--dt", "0.02", "-q", "--table", "-", "--resume"]).arg(&blocks);
        stdout(command.args(more))
    };
    let first = map(&[]);
    let kept = blocks.join("rows-0-2.arrow");
    let made = fs::metadata(&kept).unwrap().modified().unwrap();
    assert_eq!(map(&[]), first);
    assert_eq!(fs::metadata(&kept).unwrap().modified().unwrap(), made);
    // With another option, the block is computed again.
    assert!(map(&["--min-amplitude", "0.5"]) != first);
    assert_eq!(map(&[]), first);
    // A truncated block is not used.
    fs::write(&kept, &fs::read(&kept).unwrap()[..100]).unwrap();
    assert_eq!(map(&[]), first);
    // A block of other numbers is not used either.
    let mut bytes = fs::read(&copy).unwrap();
    let last = bytes.len() - 3;
    bytes[last] ^= 1;
    fs::write(&copy, bytes).unwrap();
    assert!(map(&[]) != first);
}

/// A file of a stack of doubles.
fn npy(shape: &str, numbers: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// Levels were fitted as amplitudes.
#[test]
fn levels_in_decibels_are_those_of_amplitudes() {
    let folder = tempfile::tempdir().unwrap();
    let traces = |of: fn(f64) -> f64| -> Vec<f64> {
        let fall = |pixel: u32, i: u32| {
            let left = (-0.01 * f64::from(i)).exp();
            left - 0.1 * f64::from(pixel + 1) * (1.0 - left)
        };
        (0..4).flat_map(|pixel| (0..100).map(move |i| of(fall(pixel, i)))).collect()
    };
    let (linear, levels) = (folder.path().join("linear.npy"), folder.path().join("levels.npy"));
    fs::write(&linear, npy("(2, 2, 100)", &traces(|a| a))).unwrap();
    fs::write(&levels, npy("(2, 2, 100)", &traces(|a| 20.0 * a.log10()))).unwrap();
    let csv = |file: &Path, args: &str| {
        let args = format!("--dt 0.01 --frequency-hz 50 --min-amplitude 0.5 --table - -q {args}");
        stdout(slipfit().arg("map").arg(file).args(args.split_whitespace()))
    };
    let wanted = csv(&linear, "--unit V");
    for unit in ["dB", "dBV", "dBm"] {
        let found = csv(&levels, &format!("--unit {unit}"));
        for name in ["sliding_rate", "decay_rate_per_s", "friction_displacement", "initial_amplitude"] {
            for (one, other) in numbers(&found, name).iter().zip(numbers(&wanted, name)) {
                assert!((one / other - 1.0).abs() < 1e-6, "{unit} {name}: {one} {other}");
            }
        }
        assert_eq!(column(&found, "samples"), column(&wanted, "samples"), "{unit}");
    }
    let said = stdout(slipfit().arg("map").arg(&levels).args(["--dt", "0.01", "--unit", "dBV"]));
    assert!(said.contains("V/s") && !said.contains("dB"), "{said}");
    let args = "--dt 0.01 --unit dB --kind displacement --method analyse";
    assert!(refusal(&levels, args).contains("--unit: levels in dB are those of amplitudes"));
}

/// The displacement of a velocity was given in the unit of the velocity.
#[test]
fn a_map_of_velocities_has_displacements() {
    let folder = tempfile::tempdir().unwrap();
    let (file, map) = (folder.path().join("velocity.npy"), folder.path().join("map.zarr"));
    let swing = |i: u32| {
        let t = 1e-3 * f64::from(i);
        (1.05 * (-t).exp() - 0.05) * (300.0 * t).sin()
    };
    let trace: Vec<f64> = (0..2000).map(swing).collect();
    fs::write(&file, npy("(1, 1, 2000)", &trace)).unwrap();
    let args = ["--dt", "1e-3", "--kind", "velocity", "--method", "analyse", "--unit", "mm/s", "--table"];
    let said = stdout(slipfit().arg("map").arg(&file).args(args).arg(&map));
    assert!(said.contains("friction displacement: median") && !said.contains("m/s,"), "{said}");
    let attributes = |name: &str| fs::read_to_string(map.join(name).join(".zattrs")).unwrap();
    for (name, unit) in [("friction_displacement", "mm"), ("decay_rate_per_s", "1/s"), ("start_s", "s")] {
        let told = attributes(name).split_whitespace().collect::<String>();
        assert!(told.contains(&format!("\"units\":\"{unit}\"")), "{name}: {told}");
    }
}

#[test]
fn what_is_no_stack_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let npy = |shape: &str, order: &str, kind: &str, numbers: usize| {
        let header = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.resize(bytes.len() + 8 * numbers, 0);
        bytes
    };
    let good = stack("stack.npy");
    assert!(refusal(&good, "").contains("--dt"));
    assert!(refusal(&good, "--dt 0.02 --axis 3").contains("0..=2"));
    assert!(refusal(&good, "--dt 0").contains("--dt"));
    assert!(refusal(&good, "--dt 0.02 --kind displacement").contains("--method"));
    assert!(refusal(&good, "--dt 0.02 --table map.txt").contains(".csv, .npy or .arrow"));
    assert!(refusal(&good, "--dt 0.02 --plot map.jpg").contains(".svg or .png"));
    assert!(refusal(&stack("stack.h5"), "--dt 0.02 --data scan/topography").contains("three axes"));
    assert!(refusal(&stack("stack.h5"), "--dt 0.02 --data nothing").contains("nothing"));
    let flat = write("flat.npy", &npy("(4, 3)", "False", "<f8", 12));
    assert!(refusal(&flat, "--dt 0.02").contains("three axes are needed"));
    let turned = write("turned.npy", &npy("(2, 3, 4)", "True", "<f8", 24));
    assert!(refusal(&turned, "--dt 0.02").contains("Fortran order"));
    let short = write("short.npy", &npy("(2, 3, 400)", "False", "<f8", 24));
    assert!(refusal(&short, "--dt 0.02").contains("ends before"));
    let huge = write("huge.npy", &npy("(4294967296, 4294967296, 4)", "False", "<f8", 24));
    assert!(refusal(&huge, "--dt 0.02").contains("ends before"));
    let none = write("none.npy", &npy("(0, 3, 4)", "False", "<f8", 0));
    assert!(refusal(&none, "--dt 0.02").contains("no pixels"));
    let complex = write("complex.npy", &npy("(1, 1, 4)", "False", "<c16", 8));
    assert!(refusal(&complex, "--dt 0.02").contains("numbers"));
    assert!(refusal(&write("table.csv", b"t,x\n1,2\n"), "--dt 1").contains("neither"));
    assert!(refusal(&write("empty.npy", b""), "--dt 1").contains("empty"));
    assert!(refusal(&folder.path().join("missing.npy"), "--dt 1").contains("missing.npy"));
}

/// A copy of a store in which `change` modifies a file.
fn changed(store: &str, file: &str, change: impl Fn(&mut Vec<u8>)) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join(store);
    for path in files_in(&stack(store)) {
        let to = copy.join(path.strip_prefix(stack(store)).unwrap());
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(path, to).unwrap();
    }
    let mut bytes = fs::read(copy.join(file)).unwrap();
    change(&mut bytes);
    fs::write(copy.join(file), bytes).unwrap();
    (folder, copy)
}

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files_in(&path) } else { vec![path] }).collect()
}

#[test]
fn broken_stores_are_refused_and_missing_chunks_are_what_they_stand_for() {
    let said = |store: &str, file: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let (_folder, copy) = changed(store, file, change);
        refusal(&copy, if store == "blosc.zarr" { "--dt 0.02 --axis 0" } else { "--dt 0.02" })
    };
    let replaced = |from: &'static str, to: &'static str| {
        move |bytes: &mut Vec<u8>| {
            let text = String::from_utf8(bytes.clone()).unwrap();
            assert!(text.contains(from), "{text}");
            *bytes = text.replace(from, to).into_bytes();
        }
    };
    let described = |from, to| said("stack.zarr", "zarr.json", &replaced(from, to));
    assert!(described("\"zstd\"", "\"sharding_indexed\"").contains("sharding_indexed"));
    assert!(described("float32", "complex64").contains("complex64"));
    assert!(described("50\n", "5000000000\n").contains("chunks"));
    assert!(described("50\n", "0\n").contains("chunks"));
    assert!(described("128", "99999999999999999").contains("more than a list holds"));
    assert!(described("zarr_format", "zarr_format\" \"").contains("broken"));
    let second = |from, to| said("fortran.zarr", ".zarray", &replaced(from, to));
    assert!(second("zlib", "lzma").contains("lzma"));
    assert!(second("\"filters\": null", "\"filters\": [{\"id\": \"delta\"}]").contains("delta"));
    let cut = |bytes: &mut Vec<u8>| bytes.truncate(bytes.len() / 2);
    for (store, chunk) in
        [("stack.zarr", "c/0/0/1"), ("fortran.zarr", "0.0.1"), ("blosc.zarr", "scan/amplitude/0.0.0")]
    {
        assert!(said(store, chunk, &cut).contains("chunk"), "{store}");
    }
    for at in 0..40 {
        // Any damaged byte gives numbers or a refusal.
        let damage = |bytes: &mut Vec<u8>| bytes[at] ^= 0x55;
        let (_folder, copy) = changed("blosc.zarr", "scan/amplitude/0.0.0", damage);
        let output =
            slipfit().arg("map").arg(&copy).args(["--dt", "0.02", "--axis", "0", "-q"]).output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 2)), "{at}: {output:?}");
    }
    assert!(refusal(&stack("blosc.zarr"), "--dt 0.02 --data ../stack.zarr").contains("not a path"));
    assert!(refusal(&stack("blosc.zarr"), "--dt 0.02 --data scan/nothing").contains("no array"));
    assert!(refusal(&stack(""), "--dt 0.02").contains("zarr"));
    let (_folder, copy) =
        changed("stack.zarr", "zarr.json", replaced("\"fill_value\": 0.0", "\"fill_value\": \"NaN\""));
    fs::remove_file(copy.join("c/0/1/2")).unwrap();
    let csv = stdout(slipfit().arg("map").arg(&copy).args(["--dt", "0.02", "--table", "-", "-q"]));
    assert_eq!(column(&csv, "samples"), ["128", "128", "100", "128", "128", "100"]);
}

#[test]
fn a_map_is_a_store_that_replaces_its_own_kind() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.zarr");
    let args = format!("--dt 0.02 -q --unit nm --table {}", map.display());
    let made = || stdout(slipfit().arg("map").arg(stack("stack.npy")).args(args.split_whitespace()));
    made();
    fs::write(map.join("of the last run"), "").unwrap();
    made();
    assert!(!map.join("of the last run").exists(), "replaced as a whole");
    let described = fs::read_to_string(map.join("sliding_rate/.zattrs")).unwrap();
    assert!(described.contains("\"nm/s\"") && described.contains("\"y\""), "{described}");
    assert_eq!(fs::read(map.join("sliding_rate/0.0")).unwrap().len(), 6 * 8);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
    // Files written by other programs stay.
    fs::write(map.join(".zattrs"), "{}").unwrap();
    assert!(refusal(&stack("stack.npy"), &args).contains("was not written by slipfit"));
    stdout(slipfit().arg("map").arg(stack("stack.npy")).args(args.split_whitespace()).arg("--force"));
    fs::remove_file(map.join(".zgroup")).unwrap();
    fs::remove_file(map.join(".zattrs")).unwrap();
    assert!(refusal(&stack("stack.npy"), &format!("{args} --force")).contains("was not written by slipfit"));
    let (_folder, copy) = changed("stack.zarr", "zarr.json", |_| {});
    let onto = format!("--dt 0.02 --force --table {}", copy.display());
    assert!(refusal(&copy, &onto).contains("the input"));
}

/// A pixel without an answer is reported with its reason.
#[test]
fn a_dead_pixel_does_not_end_a_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dead.npy");
    let mut bytes = fs::read(stack("stack.npy")).unwrap();
    let begin = bytes.len() - 6 * 128 * 4;
    for sample in bytes[begin..begin + 128 * 4].chunks_exact_mut(4) {
        sample.copy_from_slice(&f32::NAN.to_le_bytes());
    }
    fs::write(&path, bytes).unwrap();
    let csv = stdout(slipfit().arg("map").arg(&path).args(["--dt", "0.02", "--table", "-", "-q"]));
    assert_eq!(column(&csv, "status"), ["failed", "done", "done", "done", "done", "done"]);
    assert!(!column(&csv, "reason")[0].is_empty());
    assert_eq!(column(&csv, "decay_rate_per_s")[0], "");
    let said = stdout(slipfit().arg("map").arg(&path).args(["--dt", "0.02"]));
    assert!(said.contains("5 done, 1 failed"), "{said}");
}

/// Pixels whose trace does not determine the loss are neither drawn nor included in the median, whose number of
/// pixels is stated.
#[test]
fn pixels_with_warnings_do_not_speak_for_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.npy");
    let mut bytes = fs::read(stack("stack.npy")).unwrap();
    let begin = bytes.len() - 6 * 128 * 4;
    let noise = |i: usize| ((i * i * 7919 + i * 104_729) % 1009) as f32 / 1009.0 - 0.5;
    let stops = |i: usize| (1.0 - i as f32 / 32.0).max(0.0) + 0.01 * noise(i);
    for (pixel, value) in [&stops as &dyn Fn(usize) -> f32, &noise].into_iter().enumerate() {
        for i in 0..128 {
            let at = begin + (128 * pixel + i) * 4;
            bytes[at..at + 4].copy_from_slice(&value(i).to_le_bytes());
        }
    }
    fs::write(&path, bytes).unwrap();
    let plot = folder.path().join("odd.svg");
    let mut command = slipfit();
    command.arg("map").arg(&path).args(["--dt", "0.02", "--plot"]).arg(&plot);
    let said = stdout(&mut command);
    assert!(said.contains("4 done, 2 warned"), "{said}");
    assert!(said.contains("in the 4 pixels without a warning:"), "{said}");
    assert!(said.contains("misfit"), "{said}");
    let svg = fs::read_to_string(plot).unwrap();
    // The noise pixel, in the images of both losses.
    assert_eq!(svg.matches("no value").count(), 2, "{said}");
    assert!(svg.contains("1 of the coloured pixels has a warning"), "{said}");
}
