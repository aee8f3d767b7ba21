"""Files and streams with pyarrow only."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from .. import _input
from .._arguments import public
from . import _rows

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import fs

#: Number of files per batch of rows.
_BATCH = 64


@public
def ringdown_files(
    pattern: str, *, filesystem: fs.FileSystem | None = None, threads: int = 8, **options: Any
) -> pa.RecordBatchReader:
    """Analyses every file that matches a pattern; one row per file, as they are read.

    Parameters
    ----------
    pattern : str
        ``s3://bucket/runs/*.csv``, ``gs://…``, a path; ``*`` in the last part only.
    filesystem : pyarrow.fs.FileSystem, optional
        For your own endpoint or keys; by default that of the URI.
    threads : int
        Files fetched and analysed at a time. At most 64 are held.
    **options
        Those of :func:`slipfit.ringdown`.

    Returns
    -------
    pyarrow.RecordBatchReader
        Columns file, status, reason, model, unit, parameters, evidence. The row of a file
        that cannot be read or analysed contains the reason.

    Raises
    ------
    OptionError
        For a pattern that matches no file.
    """
    import pyarrow as pa
    from pyarrow import fs

    options = _rows.checked(options)
    if threads < 1:
        raise _input.refuse("threads", f"threads={threads}: at least one is needed")
    if filesystem is None:
        held, place = fs.FileSystem.from_uri(pattern) if "://" in pattern else (fs.LocalFileSystem(), pattern)
    else:
        held, place = filesystem, pattern.split("://")[-1]
    folder, _, last = place.rpartition("/")
    found = held.get_file_info(fs.FileSelector(folder or ".", recursive=False))
    paths = sorted(info.path for info in found if info.is_file and fnmatch.fnmatch(info.base_name, last))
    if not paths:
        raise _input.refuse("pattern", f"{pattern}: no file fits")

    def row(path: str) -> dict[str, Any]:
        try:
            with held.open_input_stream(path) as stream:
                contents: bytes | None = stream.read()
        except OSError:
            contents = None
        return _rows.of_file(path, contents, **options)

    def batches() -> Iterator[pa.RecordBatch]:
        with ThreadPoolExecutor(threads) as pool:
            for first in range(0, len(paths), _BATCH):
                rows = list(pool.map(row, paths[first : first + _BATCH]))
                yield pa.RecordBatch.from_pylist(rows, schema=schema)

    schema = _rows.schema()
    return pa.RecordBatchReader.from_batches(schema, batches())
