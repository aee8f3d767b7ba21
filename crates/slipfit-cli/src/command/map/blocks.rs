//! Finished blocks of a map, kept until the map is whole.

use crate::failure::Failure;
use arrow_array::RecordBatch;
use arrow_ipc::reader::FileReader;
use arrow_ipc::writer::FileWriter;
use arrow_schema::ArrowError;
use sha2::{Digest as _, Sha256};
use slipfit_batch::Options;
use std::fs::{self, File};
use std::ops::Range;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A folder of blocks, each a file of Arrow.
pub(super) struct Blocks {
    folder: PathBuf,
    /// Everything beside its numbers that changes the answers of a block.
    asked: String,
}

const SIGNATURE: &str = "slipfit_block";

impl Blocks {
    pub(super) fn in_folder(folder: &Path, options: &Options) -> Result<Self, Failure> {
        fs::create_dir_all(folder)
            .map_err(|e| Failure::new(format!("--resume {}: cannot be made: {e}", folder.display())))?;
        let asked = format!("{} {options:?}", crate::version::long());
        Ok(Self { folder: folder.to_owned(), asked })
    }

    /// The block from the folder if it was made of the same numbers with the same options, else computed and
    /// kept.
    pub(super) fn taken_or(
        &self,
        rows: &Range<usize>,
        traces: Vec<f64>,
        fit: impl FnOnce(Vec<f64>) -> Result<RecordBatch, Failure>,
    ) -> Result<RecordBatch, Failure> {
        let path = self.folder.join(format!("rows-{}-{}.arrow", rows.start, rows.end));
        let signature = self.signature(&traces);
        if let Some(kept) = kept(&path, &signature) {
            return Ok(kept);
        }
        let found = fit(traces)?;
        self.keep(&path, signature, &found)
            .map_err(|e| Failure::new(format!("{}: cannot be written: {e}", path.display())))?;
        Ok(found)
    }

    fn signature(&self, traces: &[f64]) -> String {
        let mut digest = Sha256::new();
        digest.update(self.asked.as_bytes());
        let mut bytes = Vec::new();
        for part in traces.chunks(1 << 13) {
            bytes.clear();
            bytes.extend(part.iter().flat_map(|v| v.to_le_bytes()));
            digest.update(&bytes);
        }
        digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// As a whole or not at all.
    fn keep(&self, path: &Path, signature: String, found: &RecordBatch) -> Result<(), ArrowError> {
        let mut metadata = found.schema().metadata().clone();
        metadata.insert(SIGNATURE.to_owned(), signature);
        let schema = found.schema().as_ref().clone().with_metadata(metadata);
        let part = NamedTempFile::new_in(&self.folder)?;
        let mut writer = FileWriter::try_new(part.as_file(), &schema)?;
        writer.write(found)?;
        writer.finish()?;
        drop(writer);
        part.persist(path).map_err(|e| e.error)?;
        Ok(())
    }
}

/// A block of this signature; one that is missing, of other numbers or cut off is computed again.
fn kept(path: &Path, signature: &str) -> Option<RecordBatch> {
    let reader = FileReader::try_new(File::open(path).ok()?, None).ok()?;
    let schema = reader.schema();
    if schema.metadata().get(SIGNATURE).map(String::as_str) != Some(signature) {
        return None;
    }
    let mut batches = reader.collect::<Result<Vec<_>, _>>().ok()?;
    let batch = batches.pop().filter(|_| batches.is_empty())?;
    let plain = schema.as_ref().clone().with_metadata(std::collections::HashMap::default());
    RecordBatch::try_new(std::sync::Arc::new(plain), batch.columns().to_vec()).ok()
}
