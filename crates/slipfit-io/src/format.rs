//! Which kind of file this is, from its first bytes.

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
    /// MPEG-4 (.m4a, .mp4, .3gp), its sound.
    Mp4,
    /// Ogg (.ogg), its sound.
    Ogg,
    /// AAC sound in frames of its own (.aac).
    Aac,
    /// Feather of the first version.
    FeatherV1,
}

/// Bytes that tell a format.
pub(crate) const HEAD: usize = 1024;

/// A format, its name in a sentence, the words that name it alone, the ending of its files among
/// them, and bytes at offsets that mark it.
type Known = (Format, &'static str, &'static str, &'static [(usize, &'static [u8])]);

/// Each format with its marks.
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
];

impl Format {
    /// The format of a file that begins with these bytes, as far as they tell it.
    pub(crate) fn by_magic(head: &[u8]) -> Option<Self> {
        let begins =
            |(at, magic): &(usize, &[u8])| head.get(*at..).is_some_and(|rest| rest.starts_with(magic));
        KNOWN.iter().find(|(.., magic)| magic.iter().any(begins)).map(|(format, ..)| *format)
    }

    /// How to get numbers out of a file that is not read.
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
                "opening a pickle runs what it says: save the arrays in Python by numpy.savez, or a table by to_csv \
                 or to_parquet"
            }
            Self::Flac | Self::Mp3 | Self::Mp4 | Self::Ogg | Self::Aac => {
                "convert it by `ffmpeg -i FILE sound.wav`, or build slipfit with its feature `sound`"
            }
            Self::FeatherV1 => {
                "read it by pyarrow.feather.read_table in Python and write it again: the second version is Arrow IPC"
            }
            Self::Gzip | Self::Xz | Self::Bzip2 | Self::Zstd => "unpack it first",
            _ => "export the data as text: one row per sample, columns for time and signal",
        }
    }

    /// Whether a text begins as universal files do: `-1` alone, then the number of a data set.
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

/// By one of the words that name it, such as the ending of its files.
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
        ] {
            assert_eq!(Format::by_magic(head), Some(format));
        }
        assert_eq!(Format::by_magic("\u{20ac} 5".as_bytes()), None);
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
