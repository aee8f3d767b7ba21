//! Which kind of file this is, from its first bytes.

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
    /// PDF.
    Pdf,
    /// PNG.
    Png,
    /// SQLite database.
    Sqlite,
    /// FLAC sound.
    Flac,
    /// MP3 sound with an ID3 tag.
    Mp3,
}

/// Bytes that tell a format.
pub(crate) const HEAD: usize = 1024;

/// A format, its name in a sentence, and bytes at offsets that mark it.
type Known = (Format, &'static str, &'static [(usize, &'static [u8])]);

/// Each format with its marks.
const KNOWN: &[Known] = &[
    (Format::Text, "delimited text", &[]),
    (Format::Wav, "a WAV sound file", &[(0, b"RIFF"), (0, b"RF64")]),
    (Format::Mat5, "a MATLAB file (level 5)", &[(0, b"MATLAB 5.0")]),
    (
        Format::Hdf5,
        "an HDF5 file (MATLAB 7.3 writes these too)",
        &[(0, b"\x89HDF\r\n\x1a\n"), (512, b"\x89HDF\r\n\x1a\n")],
    ),
    (Format::Xls, "an old Excel file (.xls)", &[(0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")]),
    (Format::Xlsx, "an Excel file (.xlsx)", &[]),
    (Format::Zip, "a ZIP archive", &[(0, b"PK\x03\x04")]),
    (Format::Npz, "NumPy arrays in an archive (.npz)", &[]),
    (Format::Arrow, "an Arrow IPC file", &[(0, b"ARROW1\0\0"), (0, b"\xff\xff\xff\xff")]),
    (Format::Touchstone, "a Touchstone file", &[]),
    (Format::Tracker, "a Tracker project (.trk)", &[]),
    (Format::NanoSurf, "a NanoSurf file (.nid)", &[(0, b"[DataSet]")]),
    (Format::Gzip, "a gzip file", &[(0, b"\x1f\x8b")]),
    (Format::Xz, "an xz file", &[(0, b"\xfd7zXZ\0")]),
    (Format::Bzip2, "a bzip2 file", &[(0, b"BZh")]),
    (Format::Zstd, "a Zstandard file", &[(0, b"\x28\xb5\x2f\xfd")]),
    (Format::Npy, "a NumPy array (.npy)", &[(0, b"\x93NUMPY")]),
    (Format::Parquet, "a Parquet file", &[(0, b"PAR1")]),
    (Format::Tdms, "a LabVIEW TDMS file", &[(0, b"TDSm")]),
    (Format::Pdf, "a PDF document", &[(0, b"%PDF-")]),
    (Format::Png, "a PNG picture", &[(0, b"\x89PNG\r\n\x1a\n")]),
    (Format::Sqlite, "an SQLite database", &[(0, b"SQLite format 3\0")]),
    (Format::Flac, "a FLAC sound file", &[(0, b"fLaC")]),
    (Format::Mp3, "an MP3 sound file", &[(0, b"ID3")]),
];

impl Format {
    /// The format of a file that begins with these bytes, as far as they tell it.
    pub(crate) fn by_magic(head: &[u8]) -> Option<Self> {
        let begins =
            |(at, magic): &(usize, &[u8])| head.get(*at..).is_some_and(|rest| rest.starts_with(magic));
        KNOWN.iter().find(|(.., magic)| magic.iter().any(begins)).map(|(format, ..)| *format)
    }

    /// Its name in a sentence.
    #[must_use]
    pub fn name(self) -> &'static str {
        KNOWN.iter().find(|(format, ..)| *format == self).map_or("a file", |(_, name, _)| name)
    }
}
