//! Source of the bytes of a file.

use std::{
    fs::File,
    io::{self, Cursor, Read, Seek, SeekFrom},
};

/// A file with random access.
#[derive(Debug)]
pub(crate) enum Input {
    File(File),
    Bytes(Cursor<Vec<u8>>),
}

impl Input {
    pub(crate) fn of(bytes: Vec<u8>) -> Self {
        Self::Bytes(Cursor::new(bytes))
    }

    /// Its length in bytes.
    #[cfg(feature = "parquet")]
    pub(crate) fn size(mut self) -> io::Result<(u64, Self)> {
        let size = self.seek(SeekFrom::End(0))?;
        self.seek(SeekFrom::Start(0))?;
        Ok((size, self))
    }

    /// All its bytes.
    pub(crate) fn into_bytes(self) -> io::Result<Vec<u8>> {
        match self {
            Self::Bytes(bytes) => Ok(bytes.into_inner()),
            Self::File(mut file) => {
                let mut bytes = Vec::new();
                file.seek(SeekFrom::Start(0))?;
                file.read_to_end(&mut bytes)?;
                Ok(bytes)
            }
        }
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.read(buffer),
            Self::Bytes(bytes) => bytes.read(buffer),
        }
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::File(file) => file.seek(to),
            Self::Bytes(bytes) => bytes.seek(to),
        }
    }
}
