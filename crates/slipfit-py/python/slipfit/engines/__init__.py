"""One call for each table engine, which takes and returns its rows.

One module per engine, imported on request: ``slipfit.engines.daft``,
``.spark``, ``.polars``, ``.dask``, ``.duckdb``, and ``.arrow`` for plain files.
``fit`` takes a frame with one trace per row and the options of
:func:`slipfit.fit_batch`; ``ringdown_files`` takes files by the million, one row
per file. slipfit does not install the packages of the engines: install the one you use.
"""

from __future__ import annotations

import importlib
from typing import Any

_ENGINES = ("arrow", "daft", "dask", "duckdb", "polars", "spark")


def __getattr__(name: str) -> Any:
    if name in _ENGINES:
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_ENGINES})
