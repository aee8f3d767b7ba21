"""One call for each engine that people run: its rows in, its rows out.

A module an engine, imported where it is asked for: ``slipfit.engines.daft``,
``.spark``, ``.polars``, ``.dask``, ``.duckdb``, and ``.arrow`` for plain files.
``fit`` takes a frame with a trace in each row and the options of
:func:`slipfit.fit_batch`; ``ringdown_files`` takes files by the million, one row
each. The packages of the engines are not those of slipfit: install the one you run.
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
