//! Detection of the file format from the first bytes.

use std::str::FromStr;

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Delimited text.
    Text,
    /// RIFF WAVE sound.
    Wav,
    /// MATLAB level 5 file.
    Mat5,
    /// HDF5, also MATLAB 7.3.
    Hdf5,
    /// Old Excel (OLE compound document).
    Xls,
    /// Excel workbook (.xlsx).
    Xlsx,
    /// OpenDocument spreadsheet (.ods).
    Ods,
    /// ZIP archive of texts, as phyphox exports them.
    Zip,
    /// NumPy arrays in an archive (.npz).
    Npz,
    /// Arrow IPC file (Feather) or stream.
    Arrow,
    /// Touchstone network data (.s1p, .s2p).
    Touchstone,
    /// Project of the video analysis program Tracker (.trk).
    Tracker,
    /// NanoSurf (.nid).
    NanoSurf,
    /// gzip.
    Gzip,
    /// xz.
    Xz,
    /// bzip2.
    Bzip2,
    /// Zstandard.
    Zstd,
    /// NumPy array.
    Npy,
    /// Parquet.
    Parquet,
    /// LabVIEW TDMS.
    Tdms,
    /// ASAM MDF (.mf4, .mdf).
    Mdf,
    /// Universal file of modal analysis (.unv, .uff).
    Universal,
    /// Pickled Python objects.
    Pickle,
    /// PDF.
    Pdf,
    /// PNG.
    Png,
    /// SQLite database.
    Sqlite,
    /// FLAC sound.
    Flac,
    /// MP3 sound.
    Mp3,
    /// MPEG-4 (.m4a, .mp4, .3gp), its sound track.
    Mp4,
    /// Ogg (.ogg), its sound track.
    Ogg,
    /// AAC sound without a container (.aac).
    Aac,
    /// Feather of the first version.
    FeatherV1,
    /// JSON, also with one object per line.
    Json,
    /// XML, as Logger Pro writes it (.cmbl).
    Xml,
    /// A web page.
    Html,
    /// Igor Pro binary wave (.ibw).
    Igor,
    /// LeCroy trace (.trc).
    LeCroy,
    /// Tektronix waveform (.isf, .wfm).
    Tektronix,
    /// Keysight oscilloscope waveform (.bin).
    Keysight,
    /// sigrok session (.sr).
    Sigrok,
    /// ROS bag (.bag).
    RosBag,
    /// MCAP, as ROS 2 writes it.
    Mcap,
    /// Bruker NanoScope image or force curve (.spm).
    NanoScope,
    /// NT-MDT (.mdt).
    NtMdt,
    /// JPK force curves (.jpk-force).
    Jpk,
    /// Gwyddion (.gwy).
    Gwyddion,
    /// Axon binary file (.abf).
    Axon,
    /// European Data Format (.edf, .bdf).
    Edf,
    /// NetCDF in the classic format.
    NetCdf,
    /// FITS.
    Fits,
    /// R data (.rds, .RData).
    R,
    /// Origin project (.opj, .opju).
    Origin,
    /// DuckDB database.
    DuckDb,
}

/// Number of bytes from which the format is detected.
pub(crate) const HEAD: usize = 1024;

/// A format, its name in a sentence, the words that select it, including the extension of its files, and the bytes at
/// given offsets that identify it.
type Known = (Format, &'static str, &'static str, &'static [(usize, &'static [u8])]);

/// All formats with their identifying bytes.
const KNOWN: &[Known] = &[
    (Format::Text, "delimited text", "text csv txt tsv dat lvm", &[]),
    (Format::Wav, "a WAV sound file", "wav", &[(0, b"RIFF"), (0, b"RF64")]),
    (Format::Mat5, "a MATLAB file (level 5)", "mat", &[(0, b"MATLAB 5.0")]),
    (
        Format::Hdf5,
        "an HDF5 file (MATLAB 7.3 writes these too)",
        "hdf5 h5",
        &[(0, b"\x89HDF\r\n\x1a\n"), (512, b"\x89HDF\r\n\x1a\n")],
    ),
    (Format::Xls, "an old Excel file (.xls)", "xls", &[(0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")]),
    (Format::Xlsx, "an Excel file (.xlsx)", "xlsx", &[]),
    (Format::Ods, "an OpenDocument spreadsheet (.ods)", "ods", &[]),
    (Format::Zip, "a ZIP archive", "zip", &[(0, b"PK\x03\x04")]),
    (Format::Npz, "NumPy arrays in an archive (.npz)", "npz", &[]),
    (Format::Arrow, "an Arrow IPC file", "arrow feather", &[(0, b"ARROW1\0\0"), (0, b"\xff\xff\xff\xff")]),
    (Format::Touchstone, "a Touchstone file", "touchstone s1p s2p", &[]),
    (Format::Tracker, "a Tracker project (.trk)", "tracker trk", &[]),
    (Format::NanoSurf, "a NanoSurf file (.nid)", "nid", &[(0, b"[DataSet]")]),
    (Format::Gzip, "a gzip file", "gzip gz", &[(0, b"\x1f\x8b")]),
    (Format::Xz, "an xz file", "xz", &[(0, b"\xfd7zXZ\0")]),
    (Format::Bzip2, "a bzip2 file", "bzip2 bz2", &[(0, b"BZh")]),
    (Format::Zstd, "a Zstandard file", "zstd zst", &[(0, b"\x28\xb5\x2f\xfd")]),
    (Format::Npy, "a NumPy array (.npy)", "npy", &[(0, b"\x93NUMPY")]),
    (Format::Parquet, "a Parquet file", "parquet", &[(0, b"PAR1")]),
    (Format::Tdms, "a LabVIEW TDMS file", "tdms", &[(0, b"TDSm"), (0, b"TDSh")]),
    (Format::Mdf, "an ASAM MDF measurement file (.mf4)", "mdf mf4", &[(0, b"MDF     "), (0, b"UnFinMF ")]),
    (Format::Universal, "a universal file of modal analysis (.unv)", "universal unv uff", &[]),
    (
        Format::Pickle,
        "a Python pickle (.pkl)",
        "pickle pkl",
        &[(0, b"\x80\x02"), (0, b"\x80\x03"), (0, b"\x80\x04\x95"), (0, b"\x80\x05\x95")],
    ),
    (Format::Pdf, "a PDF document", "pdf", &[(0, b"%PDF-")]),
    (Format::Png, "a PNG picture", "png", &[(0, b"\x89PNG\r\n\x1a\n")]),
    (Format::Sqlite, "an SQLite database", "sqlite", &[(0, b"SQLite format 3\0")]),
    (Format::Flac, "a FLAC sound file", "flac", &[(0, b"fLaC")]),
    (
        Format::Mp3,
        "an MP3 sound file",
        "mp3",
        &[(0, b"ID3"), (0, b"\xff\xfb"), (0, b"\xff\xfa"), (0, b"\xff\xf3"), (0, b"\xff\xf2")],
    ),
    (Format::Mp4, "an MPEG-4 file (.m4a)", "m4a mp4 3gp mov", &[(4, b"ftyp")]),
    (Format::Ogg, "an Ogg sound file", "ogg oga", &[(0, b"OggS")]),
    (Format::Aac, "an AAC sound file", "aac", &[(0, b"\xff\xf1"), (0, b"\xff\xf9")]),
    (Format::FeatherV1, "a Feather file of the first version", "feather1", &[(0, b"FEA1")]),
    (Format::Json, "JSON", "json jsonl ndjson", &[]),
    (Format::Xml, "an XML file (Logger Pro's .cmbl is one)", "xml cmbl", &[]),
    (Format::Html, "a web page", "html htm", &[]),
    (Format::Igor, "an Igor Pro wave (.ibw)", "ibw", &[]),
    (
        Format::LeCroy,
        "a LeCroy trace (.trc)",
        "trc",
        &[(0, b"WAVEDESC"), (11, b"WAVEDESC"), (15, b"WAVEDESC"), (16, b"WAVEDESC")],
    ),
    (
        Format::Tektronix,
        "a Tektronix waveform (.isf, .wfm)",
        "isf wfm",
        &[(0, b":WFMP:"), (0, b":WFMPRE:"), (0, b"WFMPRE:"), (0, b":WFMO"), (2, b":WFM#")],
    ),
    (Format::Keysight, "a waveform of a Keysight oscilloscope (.bin)", "ag10", &[]),
    (Format::Sigrok, "a sigrok session (.sr)", "sr", &[]),
    (Format::RosBag, "a ROS bag (.bag)", "bag", &[(0, b"#ROSBAG")]),
    (Format::Mcap, "an MCAP file, as ROS 2 writes them", "mcap", &[(0, b"\x89MCAP")]),
    (
        Format::NanoScope,
        "a NanoScope file of Bruker (.spm)",
        "spm nanoscope",
        &[(0, b"\\*File list"), (0, b"\\*Force file list"), (0, b"?*File list")],
    ),
    (Format::NtMdt, "an NT-MDT file (.mdt)", "mdt", &[(0, b"\x01\xb0\x93\xff")]),
    (Format::Jpk, "a file of JPK force curves (.jpk-force)", "jpk-force jpk", &[]),
    (Format::Gwyddion, "a Gwyddion file (.gwy)", "gwy", &[(0, b"GWYP"), (0, b"GWYO")]),
    (Format::Axon, "an Axon binary file (.abf)", "abf", &[]),
    (Format::Edf, "a file of the European Data Format (.edf, .bdf)", "edf bdf", &[(0, b"\xffBIOSEMI")]),
    (
        Format::NetCdf,
        "a NetCDF file of the classic form",
        "netcdf nc",
        &[(0, b"CDF\x01"), (0, b"CDF\x02"), (0, b"CDF\x05")],
    ),
    (Format::Fits, "a FITS file", "fits fit", &[(0, b"SIMPLE  =")]),
    (
        Format::R,
        "data saved by R (.rds, .RData)",
        "rds rdata",
        &[(0, b"RDX2"), (0, b"RDX3"), (0, b"X\n\0\0\0")],
    ),
    (Format::Origin, "an Origin project (.opj, .opju)", "opj opju", &[(0, b"CPYA "), (0, b"CPYUA ")]),
    (Format::DuckDb, "a DuckDB database", "duckdb", &[(8, b"DUCK")]),
];

impl Format {
    /// The format of a file that begins with these bytes, if they identify it.
    pub(crate) fn by_magic(head: &[u8]) -> Option<Self> {
        let begins =
            |(at, magic): &(usize, &[u8])| head.get(*at..).is_some_and(|rest| rest.starts_with(magic));
        KNOWN.iter().find(|(.., magic)| magic.iter().any(begins)).map(|(format, ..)| *format)
    }

    /// How to export numbers from a file that is not read.
    pub(crate) fn export(self) -> &'static str {
        match self {
            Self::Tdms => {
                "export it from LabVIEW or DIAdem as CSV, or write its channels by npTDMS in Python as CSV, HDF5 or \
                 Parquet"
            }
            Self::Mdf => {
                "export the channel by asammdf or the program that recorded it as CSV, MAT or Parquet"
            }
            Self::Universal => {
                "export it as CSV or MAT from the program that wrote it, or by pyuff in Python: times and one \
                 channel, or frequencies with amplitudes and phases"
            }
            Self::Pickle => {
                "opening a pickle executes code that it contains: save the arrays in Python by \
                 numpy.savez, or a table by to_csv or to_parquet"
            }
            Self::Flac | Self::Mp3 | Self::Mp4 | Self::Ogg | Self::Aac => {
                "convert it by `ffmpeg -i FILE sound.wav`, or build slipfit with its feature `sound`"
            }
            Self::FeatherV1 => {
                "read it by pyarrow.feather.read_table in Python and write it again: the second version is Arrow IPC"
            }
            Self::Gzip | Self::Xz | Self::Bzip2 | Self::Zstd => "unpack it first",
            Self::Xml => {
                "export it as CSV or text from the program that wrote it (in Logger Pro: File, Export As)"
            }
            Self::Html => "this may be a page about the file instead of the file: download the file itself",
            Self::Igor => {
                "save the wave as delimited text from Igor Pro, or read it in Python by igor2 and write it as CSV"
            }
            Self::LeCroy => {
                "save the trace as text or MATLAB on the oscilloscope, or read it in Python by lecroyscope"
            }
            Self::Tektronix => {
                "save the waveform as CSV on the oscilloscope, or read it in Python by tm_data_types"
            }
            Self::Keysight => "save the waveform as CSV on the oscilloscope",
            Self::Sigrok => {
                "convert it by `sigrok-cli -i FILE -O csv -o swing.csv`, or export it from PulseView as CSV"
            }
            Self::RosBag => "write the topic as CSV, by `rostopic echo -b FILE -p /TOPIC > swing.csv`",
            Self::Mcap => "write the topic as CSV, with PlotJuggler or in Python by mcap",
            Self::NanoScope | Self::NtMdt | Self::Jpk | Self::Gwyddion => {
                "export the curve as text, from the program that wrote it or from Gwyddion"
            }
            Self::Axon => {
                "export it as text from Clampfit, or read it in Python by pyabf and write it as CSV"
            }
            Self::Edf => "write the channel as CSV, with EDFbrowser or in Python by pyedflib",
            Self::NetCdf => "write it as HDF5, by `nccopy -k nc4 FILE new.nc`, or as CSV by xarray in Python",
            Self::Fits => "write the table as CSV, in Python by astropy.table.Table.read",
            Self::R => "write the table in R by `write.csv(x, \"swing.csv\", row.names = FALSE)`",
            Self::Origin => "export the worksheet as CSV or text from Origin",
            Self::DuckDb => "write the table by `COPY x TO 'swing.parquet'`",
            _ => "export the data as text: one row per sample, columns for time and signal",
        }
    }

    /// Formats of other programs that have no identifying bytes at a fixed offset.
    pub(crate) fn by_structure(head: &[u8]) -> Option<Self> {
        let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
        let begins = |with: &str| {
            text.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with.as_bytes()))
        };
        if is_json(text) {
            Some(Self::Json)
        } else if begins("<!doctype html") || begins("<html") {
            Some(Self::Html)
        } else if begins("<?xml") {
            Some(Self::Xml)
        } else if is_binary(head, &[b"ABF ", b"ABF2"]) {
            Some(Self::Axon)
        } else if is_binary(head, &[b"AG01", b"AG03", b"AG10"]) {
            Some(Self::Keysight)
        } else if is_edf(head) {
            Some(Self::Edf)
        } else if is_igor(head) {
            Some(Self::Igor)
        } else {
            None
        }
    }

    /// Whether a text begins like a universal file: `-1` alone, then the number of a data set.
    pub(crate) fn is_universal(head: &[u8]) -> bool {
        let mut lines = head.split(|b| *b == b'\n').map(|l| l.strip_suffix(b"\r").unwrap_or(l));
        let mark = lines.find(|l| !l.trim_ascii().is_empty());
        let set = lines.next().unwrap_or_default().trim_ascii();
        let digits = set.iter().take_while(|b| b.is_ascii_digit()).count();
        let number = |l: &[u8]| l.starts_with(b"    ") && l.trim_ascii() == b"-1";
        mark.is_some_and(number) && (2..=4).contains(&digits) && matches!(set[digits..], [] | [b'b', ..])
    }

    /// Its name in a sentence.
    #[must_use]
    pub fn name(self) -> &'static str {
        KNOWN.iter().find(|(format, ..)| *format == self).map_or("a file", |(_, name, ..)| name)
    }
}

/// Whether a text is a JSON object or a list of objects, lists or numbers; a list of numbers with more text below it
/// may be a row of a table.
fn is_json(text: &[u8]) -> bool {
    let inner = |text: &[u8], of: u8| {
        let inner = text.strip_prefix(&[of])?.trim_ascii_start();
        inner.first().copied()
    };
    let object = |text: &[u8]| matches!(inner(text, b'{'), Some(b'"' | b'}'));
    let Some(list) = text.strip_prefix(b"[").map(<[u8]>::trim_ascii_start) else { return object(text) };
    let number = |byte: &u8| byte.is_ascii_digit() || b"-+.eE, \t\r\n".contains(byte);
    let begins = |text: &[u8]| text.first().is_some_and(|b| b.is_ascii_digit() || *b == b'-');
    match list.iter().position(|byte| !number(byte)) {
        Some(0) if list.starts_with(b"[") => {
            let row = list[1..].trim_ascii_start();
            begins(row)
                || row.starts_with(b"\"")
                || ["null", "NaN"].iter().any(|word| row.starts_with(word.as_bytes()))
        }
        Some(0) => object(list),
        Some(end) => begins(list) && list[end] == b']' && list[end + 1..].trim_ascii().is_empty(),
        None => begins(list),
    }
}

/// Whether a file begins with one of these marks and contains bytes that do not occur in text.
fn is_binary(head: &[u8], marks: &[&[u8]]) -> bool {
    marks.iter().any(|mark| head.starts_with(mark)) && head.iter().take(64).any(|byte| *byte == 0)
}

/// Whether a file begins like the European Data Format: version in eight characters, then patient, recording and date.
fn is_edf(head: &[u8]) -> bool {
    let at = |i: usize| head.get(i).copied();
    head.starts_with(b"0       ")
        && [(170, b'.'), (173, b'.'), (178, b'.'), (181, b'.')].iter().all(|(i, b)| at(*i) == Some(*b))
}

/// Whether a file begins like a wave of Igor Pro: a version, and 16-bit words whose sum is zero.
fn is_igor(head: &[u8]) -> bool {
    let sums_to_zero = |length: usize, word: fn([u8; 2]) -> u16| {
        let words = |head: &[u8]| {
            head.as_chunks::<2>().0.iter().fold(0_u16, |sum, pair| sum.wrapping_add(word(*pair)))
        };
        head.get(..length).is_some_and(|head| words(head) == 0)
    };
    match head {
        [5, 0, ..] => sums_to_zero(384, u16::from_le_bytes),
        [0, 5, ..] => sums_to_zero(384, u16::from_be_bytes),
        [2, 0, ..] => sums_to_zero(126, u16::from_le_bytes),
        [0, 2, ..] => sums_to_zero(126, u16::from_be_bytes),
        _ => false,
    }
}

/// Parses one of the words that name a format, such as the extension of its files.
///
/// ```
/// use slipfit_io::Format;
/// assert_eq!("h5".parse(), Ok(Format::Hdf5));
/// assert_eq!(".CSV".parse(), Ok(Format::Text));
/// let error = "docx".parse::<Format>().unwrap_err();
/// assert!(error.starts_with("no such format; there are text, wav, mat,"), "{error}");
/// ```
impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let word = text.trim().trim_start_matches('.').to_lowercase();
        let named = |(_, _, words, _): &&Known| words.split(' ').any(|known| known == word);
        let first = |(_, _, words, _): &Known| words.split(' ').next().unwrap_or_default();
        let unknown = || {
            let known: Vec<&str> = KNOWN.iter().map(first).collect();
            format!("no such format; there are {}", known.join(", "))
        };
        KNOWN.iter().find(named).map(|(format, ..)| *format).ok_or_else(unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_other_programs_are_known_by_their_first_bytes() {
        for (head, format) in [
            (&b"TDSm\x0e\0\0\0"[..], Format::Tdms),
            (b"MDF     4.10    ", Format::Mdf),
            (b"UnFinMF 4.11    ", Format::Mdf),
            (b"\x80\x04\x95\x10\0\0", Format::Pickle),
            (b"\x80\x02}q\0", Format::Pickle),
            (b"#9000001000WAVEDESC", Format::LeCroy),
            (b":WFMP:NR_P 10000;", Format::Tektronix),
            (b"#ROSBAG V2.0\n", Format::RosBag),
            (b"\x89MCAP0\r\n", Format::Mcap),
            (b"\\*File list\r\n", Format::NanoScope),
            (b"CDF\x01\0\0\0\0", Format::NetCdf),
        ] {
            assert_eq!(Format::by_magic(head), Some(format));
        }
        assert_eq!(Format::by_magic("\u{20ac} 5".as_bytes()), None);
    }

    #[test]
    fn json_and_waves_are_told_from_tables() {
        let igor = |version: u8| {
            let mut head = vec![0; 400];
            (head[0], head[8], head[20]) = (version, 0x37, 0xf1);
            let sum = head[..384]
                .as_chunks::<2>()
                .0
                .iter()
                .fold(0_u16, |s, w| s.wrapping_add(u16::from_le_bytes(*w)));
            head[2..4].copy_from_slice(&0_u16.wrapping_sub(sum).to_le_bytes());
            head
        };
        let edf = format!("0       {:160}01.02.2403.04.05768     ", "X");
        for (head, format) in [
            (b"{\"t\":0,\"x\":0.12}\r\n{".as_slice(), Some(Format::Json)),
            (b"\xef\xbb\xbf[\n  {\"t\": 0}", Some(Format::Json)),
            (b"[[0.0, 1.2], [0.1", Some(Format::Json)),
            (b"[\n  [\n    \"t\"", Some(Format::Json)),
            (b"[1.2, -1.1e-3,\n0.9", Some(Format::Json)),
            (b"[1, 2]\n", Some(Format::Json)),
            (b" [1] 0.98 0.95\n [3] 0.91 0.89\n", None),
            (b"[[channel]]\n", None),
            (b"[2024-05-01] 0.1\n", None),
            (b"<?xml version=\"1.0\"?><Document>", Some(Format::Xml)),
            (b"<!DOCTYPE html>", Some(Format::Html)),
            (edf.as_bytes(), Some(Format::Edf)),
            (&igor(5), Some(Format::Igor)),
            (b"ABF2\0\0\x06\x02", Some(Format::Axon)),
            (b"AG10\x20\0\0\0", Some(Format::Keysight)),
            (b"AG10,AG20\n1,2\n", None),
            (&[5, 0, 1, 0, 9, 9], None),
            (b"[Header]\nUnit=mm\n", None),
            (b"[0.0, 1.2]\n[0.1, 1.1]\n", None),
            (b"{t, x}\n0,1\n", None),
            (b"0       1\n1       2\n", None),
        ] {
            assert_eq!(Format::by_structure(head), format, "{}", String::from_utf8_lossy(head));
        }
    }

    #[test]
    fn a_universal_file_is_told_from_a_column_of_numbers() {
        for head in ["    -1\n    58\nbeam\n", "\r\n    -1\r\n   151\r\n", "    -1\n    58b     1     2\n"] {
            assert!(Format::is_universal(head.as_bytes()), "{head}");
        }
        for head in ["-1\n58\n57\n", "    -1\n    -2\n", "    -1\n    58.5\n", "    -1\n", ""] {
            assert!(!Format::is_universal(head.as_bytes()), "{head}");
        }
    }
}
