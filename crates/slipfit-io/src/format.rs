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

const MAGIC: &[(usize, &[u8], Format)] = &[
    (0, b"RIFF", Format::Wav),
    (0, b"RF64", Format::Wav),
    (0, b"MATLAB 5.0", Format::Mat5),
    (0, b"\x89HDF\r\n\x1a\n", Format::Hdf5),
    (512, b"\x89HDF\r\n\x1a\n", Format::Hdf5),
    (0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", Format::Xls),
    (0, b"PK\x03\x04", Format::Zip),
    (0, b"\x1f\x8b", Format::Gzip),
    (0, b"\xfd7zXZ\0", Format::Xz),
    (0, b"BZh", Format::Bzip2),
    (0, b"\x28\xb5\x2f\xfd", Format::Zstd),
    (0, b"\x93NUMPY", Format::Npy),
    (0, b"PAR1", Format::Parquet),
    (0, b"ARROW1\0\0", Format::Arrow),
    (0, b"\xff\xff\xff\xff", Format::Arrow),
    (0, b"[DataSet]", Format::NanoSurf),
    (0, b"TDSm", Format::Tdms),
    (0, b"%PDF-", Format::Pdf),
    (0, b"\x89PNG\r\n\x1a\n", Format::Png),
    (0, b"SQLite format 3\0", Format::Sqlite),
    (0, b"fLaC", Format::Flac),
    (0, b"ID3", Format::Mp3),
];

impl Format {
    /// The format of a file that begins with `head`; text if nothing else.
    pub(crate) fn of(head: &[u8]) -> Self {
        MAGIC
            .iter()
            .find(|(at, magic, _)| head.get(*at..).is_some_and(|rest| rest.starts_with(magic)))
            .map(|(_, _, format)| *format)
            .or_else(|| Self::of_text(head))
            .unwrap_or(Self::Text)
    }

    /// Formats that are written as text and are no tables of rows.
    fn of_text(head: &[u8]) -> Option<Self> {
        let xml = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start().starts_with(b"<?xml");
        if xml && memchr::memmem::find(head, b"cabrillo.tracker").is_some() {
            return Some(Self::Tracker);
        }
        crate::formats::touchstone::fits(head).then_some(Self::Touchstone)
    }

    /// Its name in a sentence.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Text => "delimited text",
            Self::Wav => "a WAV sound file",
            Self::Mat5 => "a MATLAB file (level 5)",
            Self::Hdf5 => "an HDF5 file (MATLAB 7.3 writes these too)",
            Self::Xls => "an old Excel file (.xls)",
            Self::Xlsx => "an Excel file (.xlsx)",
            Self::Zip => "a ZIP archive",
            Self::Npz => "NumPy arrays in an archive (.npz)",
            Self::Arrow => "an Arrow IPC file",
            Self::Touchstone => "a Touchstone file",
            Self::Tracker => "a Tracker project (.trk)",
            Self::NanoSurf => "a NanoSurf file (.nid)",
            Self::Gzip => "a gzip file",
            Self::Xz => "an xz file",
            Self::Bzip2 => "a bzip2 file",
            Self::Zstd => "a Zstandard file",
            Self::Npy => "a NumPy array (.npy)",
            Self::Parquet => "a Parquet file",
            Self::Tdms => "a LabVIEW TDMS file",
            Self::Pdf => "a PDF document",
            Self::Png => "a PNG picture",
            Self::Sqlite => "an SQLite database",
            Self::Flac => "a FLAC sound file",
            Self::Mp3 => "an MP3 sound file",
        }
    }
}
