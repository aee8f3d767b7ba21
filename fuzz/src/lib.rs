//! Actions of the fuzz targets on their bytes: reading them in all possible ways, with memory limited to a multiple of
//! them; or an analysis of the numbers built from them.
//!
//! A checksum or a compressor keeps changed bytes from the reader behind it; for packed formats there is therefore a
//! variant in which the bytes are packed first.

use std::io::{Cursor, Write as _};
use std::panic;
use std::sync::Once;

/// Hostile numbers for the analyses, as used in the property tests of the core.
#[path = "../../crates/slipfit/tests/hostile/mod.rs"]
mod numbers;

use peak_alloc::PeakAlloc;
use slipfit_io::{ReadOptions, read_from, read_sweep_from, read_tables_from};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

#[global_allocator]
static PEAK: PeakAlloc = PeakAlloc;

/// Memory that may be requested in addition to a multiple of the input: windows of the readers.
const WINDOWS: usize = 24 << 20;
/// The multiple, and that for bytes which a compressor may have packed a thousandfold.
const TIMES: usize = 64;
const TIMES_PACKED: usize = 12_000;

/// The multiples for packed columns: Zstandard encodes 128 KiB by four bytes, deflate and LZF can be combined.
const TIMES_ARROW: usize = 1 << 15;
const TIMES_HDF5: usize = 4000;

/// Reads Arrow's packed columns.
pub fn arrow(bytes: &[u8]) {
    read(bytes, TIMES_ARROW);
}

/// Reads HDF5's packed chunks.
pub fn hdf5(bytes: &[u8]) {
    read(bytes, TIMES_HDF5);
}

/// Reads an OpenDocument spreadsheet; bytes that are not one become its cells.
pub fn ods(bytes: &[u8]) {
    if bytes.starts_with(b"PK") {
        return read(bytes, TIMES_PACKED);
    }
    let mimetype = b"application/vnd.oasis.opendocument.spreadsheet\0\0\0\0";
    members(&[&mimetype[..], bytes].concat(), &["mimetype", "content.xml"]);
}

/// Reads bytes as they are.
pub fn bytes(bytes: &[u8]) {
    read(bytes, TIMES);
}

/// Reads gzip; bytes that are not gzip are packed first.
pub fn gzip(bytes: &[u8]) {
    if bytes.starts_with(b"\x1f\x8b") {
        return read(bytes, TIMES_PACKED);
    }
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    if packer.write_all(bytes).is_ok()
        && let Ok(packed) = packer.finish()
    {
        read(&packed, TIMES_PACKED);
    }
}

/// Reads a NumPy archive; bytes that are not one become one or two of its arrays.
pub fn npz(bytes: &[u8]) {
    members(bytes, &["t.npy", "x.npy"]);
}

/// Reads a phyphox archive; bytes that are not one become its texts.
pub fn phyphox(bytes: &[u8]) {
    members(bytes, &["Raw Data.csv", "meta/time.csv", "meta/device.csv"]);
}

/// Reads an Excel workbook; bytes that are not one become its parts.
pub fn xlsx(bytes: &[u8]) {
    const PARTS: [&str; 5] = [
        "xl/worksheets/sheet1.xml",
        "xl/sharedStrings.xml",
        "xl/styles.xml",
        "xl/workbook.xml",
        "xl/_rels/workbook.xml.rels",
    ];
    members(bytes, &PARTS);
}

/// Analyses the ring-down built from these bytes.
pub fn ringdown(bytes: &[u8]) {
    numbers::ringdown(bytes);
}

/// Analyses the resonance curve built from these bytes.
pub fn resonance(bytes: &[u8]) {
    numbers::resonance(bytes);
}

/// Analyses the drive levels built from these bytes.
pub fn levels(bytes: &[u8]) {
    numbers::levels(bytes);
}

/// Analyses the series of measurements built from these bytes.
pub fn series(bytes: &[u8]) {
    numbers::series(bytes);
}

/// Splits the bytes at `\0\0\0\0` into the members of an archive.
fn members(bytes: &[u8], names: &[&str]) {
    if bytes.starts_with(b"PK") {
        return read(bytes, TIMES_PACKED);
    }
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut rest = Some(bytes);
    for name in names {
        let Some(part) = rest else { break };
        let cut = part.windows(4).position(|w| w == [0; 4]);
        let (this, after) = cut.map_or((part, None), |at| (&part[..at], Some(&part[at + 4..])));
        rest = after;
        if archive.start_file(*name, stored).and_then(|()| Ok(archive.write_all(this)?)).is_err() {
            return;
        }
    }
    if let Ok(packed) = archive.finish() {
        read(&packed.into_inner(), TIMES);
    }
}

/// A panic ends the run, except in a decoder whose panics are errors.
fn hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let ends = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !slipfit_io::panic_becomes_error() {
                ends(info);
            }
        }));
    });
}

fn read(bytes: &[u8], times: usize) {
    hook();
    PEAK.reset_peak_usage();
    let before = PEAK.current_usage();
    drop(read_from(bytes, "fuzzed", &ReadOptions::default()));
    drop(read_from(bytes, "fuzzed", &ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() }));
    drop(read_tables_from(bytes, "fuzzed", 10_000));
    drop(read_sweep_from(bytes, "fuzzed", &ReadOptions::default()));
    let peak = PEAK.peak_usage().saturating_sub(before);
    assert!(peak <= times * bytes.len() + WINDOWS, "{peak} bytes of memory for {} of a file", bytes.len());
}
