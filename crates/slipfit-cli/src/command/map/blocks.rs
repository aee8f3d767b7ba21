//! Finished blocks of a map, kept until the map is complete.

use crate::failure::Failure;
use crate::output::{self, Outputs, Target};
use arrow_array::RecordBatch;
use arrow_ipc::reader::FileReader;
use arrow_ipc::writer::FileWriter;
use arrow_schema::ArrowError;
use sha2::{Digest as _, Sha256};
use slipfit_batch::Options;
use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File};
use std::io::{self, Read as _, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// A folder of blocks, each an Arrow file.
pub(super) struct Blocks {
    /// By their first row.
    targets: BTreeMap<usize, Target>,
    force: bool,
    /// Everything other than its numbers that changes the answers of a block.
    options_text: String,
}

const SIGNATURE: &str = "slipfit_block";
/// The first bytes of an Arrow file.
const MAGIC: &[u8] = b"ARROW1";

impl Blocks {
    /// The files of these blocks in `folder`, which is created if needed.
    ///
    /// # Errors
    /// The folder cannot be created, or one of its files is an input, an output, or not a block.
    pub(super) fn in_folder(
        folder: &Path,
        rows: impl Iterator<Item = Range<usize>>,
        options: &Options,
        outputs: &mut Outputs,
        force: bool,
    ) -> Result<Self, Failure> {
        fs::create_dir_all(folder).map_err(|e| {
            Failure::new(format!("--resume {}: the folder cannot be created: {e}", folder.display()))
        })?;
        let mut targets = BTreeMap::new();
        for rows in rows {
            let path = folder.join(format!("rows-{}-{}.arrow", rows.start, rows.end));
            let target = outputs.add_own("--resume, a block", &path)?;
            if !force && StoredBlock::of(&path, "").is_foreign() {
                return Err(output::foreign(&format!("--resume, a block {}", path.display())));
            }
            targets.insert(rows.start, target);
        }
        let options_text = format!("{} {options:?}", crate::version::long());
        Ok(Self { targets, options_text, force })
    }

    /// The block from the folder if it was computed from the same numbers with the same options; otherwise it is
    /// computed and kept.
    pub(super) fn load_or_compute(
        &self,
        rows: &Range<usize>,
        traces: Vec<f64>,
        fit: impl FnOnce(Vec<f64>) -> Result<RecordBatch, Failure>,
    ) -> Result<RecordBatch, Failure> {
        let Some(target) = self.targets.get(&rows.start) else { return fit(traces) };
        let signature = self.signature(&traces);
        if let StoredBlock::Block(kept) = StoredBlock::of(target.named(), &signature) {
            return Ok(kept);
        }
        let found = fit(traces)?;
        // Another program may have written one in the meantime.
        if !self.force && StoredBlock::of(target.named(), &signature).is_foreign() {
            return Err(output::foreign(&target.named().display().to_string()));
        }
        target.write(|out| keep(out, signature, &found).map_err(io::Error::other))?;
        Ok(found)
    }

    fn signature(&self, traces: &[f64]) -> String {
        let mut digest = Sha256::new();
        digest.update(self.options_text.as_bytes());
        let mut bytes = Vec::new();
        for part in traces.chunks(1 << 13) {
            bytes.clear();
            bytes.extend(part.iter().flat_map(|v| v.to_le_bytes()));
            digest.update(&bytes);
        }
        digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn keep(out: &mut dyn Write, signature: String, found: &RecordBatch) -> Result<(), ArrowError> {
    let mut metadata = found.schema().metadata().clone();
    metadata.insert(SIGNATURE.to_owned(), signature);
    let schema = found.schema().as_ref().clone().with_metadata(metadata);
    let mut writer = FileWriter::try_new(out, &schema)?;
    writer.write(found)?;
    writer.finish()
}

/// The file found in the place of a block.
enum StoredBlock {
    /// Nothing, a block of other numbers, or a truncated one: it is computed again.
    Nothing,
    Block(RecordBatch),
    /// A file that is not a block.
    Foreign,
}

impl StoredBlock {
    fn of(path: &Path, signature: &str) -> Self {
        let mut head = Vec::new();
        let opened = File::open(path).and_then(|file| file.take(MAGIC.len() as u64).read_to_end(&mut head));
        if opened.is_err() || head.is_empty() {
            return Self::Nothing;
        }
        if head != MAGIC {
            return Self::Foreign;
        }
        let Ok(reader) =
            File::open(path).map_err(ArrowError::from).and_then(|f| FileReader::try_new(f, None))
        else {
            return Self::Nothing;
        };
        let schema = reader.schema();
        match schema.metadata().get(SIGNATURE) {
            None => return Self::Foreign,
            Some(of) if of != signature => return Self::Nothing,
            Some(_) => {}
        }
        let Ok(mut batches) = reader.collect::<Result<Vec<_>, _>>() else { return Self::Nothing };
        let Some(batch) = batches.pop().filter(|_| batches.is_empty()) else { return Self::Nothing };
        let plain = schema.as_ref().clone().with_metadata(HashMap::default());
        RecordBatch::try_new(Arc::new(plain), batch.columns().to_vec()).map_or(Self::Nothing, Self::Block)
    }

    fn is_foreign(&self) -> bool {
        matches!(self, Self::Foreign)
    }
}
