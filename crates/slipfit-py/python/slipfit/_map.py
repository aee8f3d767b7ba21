"""Maps: a trace in each pixel."""

from __future__ import annotations

import hashlib
import json
import os
import threading
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from . import _core, _input
from ._arguments import public, shown, wrong_type
from ._analyses import _INTERVAL
from ._batch import answer_schema, fit_batch
from .typing import Band, Interval, Motion, Path, Scalar

if TYPE_CHECKING:
    import xarray as xr

#: Maximum number of bytes of traces held at a time, as doubles.
_BLOCK = 1 << 26


def _blocks(shape: tuple[int, ...], samples: int) -> Iterator[tuple[int, int]]:
    """First and last row of each block."""
    rows, columns = shape
    step = max(1, _BLOCK // (8 * max(1, columns * samples)))
    for first in range(0, rows, step):
        yield first, min(rows, first + step)


def _signature(traces: NDArray[Any], options: dict[str, Any]) -> str:
    """Fingerprint of a block: its numbers and everything that changes their answers."""
    asked = {**options, "dtype": traces.dtype.str, "version": _core.__version__}
    digest = hashlib.sha256(json.dumps(asked, sort_keys=True).encode())
    digest.update(np.ascontiguousarray(traces).data)
    return digest.hexdigest()


def _stored(path: FilePath, signature: str) -> dict[str, NDArray[Any]] | None:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as held:
            if str(held["signature"]) != signature:
                return None
            return {name: held[name] for name in held.files if name != "signature"}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        # Missing, or truncated when the last run ended.
        return None


def _store(path: FilePath, signature: str, found: dict[str, NDArray[Any]]) -> None:
    part = path.with_suffix(f".{os.getpid()}-{threading.get_ident()}.part")
    columns: dict[str, Any] = found
    with part.open("wb") as file:
        np.savez(file, signature=np.array(signature), **columns)
    # Written as a whole or not at all.
    part.replace(path)


class _Stored:
    """A stack in a file, read in slices."""

    def __init__(self, path: Path, data: str | None) -> None:
        self._held = _core.Stack(os.fspath(path), data)
        self.shape = self._held.shape
        self.unit = self._held.unit

    def __getitem__(self, cut: tuple[slice, ...]) -> NDArray[np.float64]:
        axis = next(i for i, part in enumerate(cut) if part != slice(None))
        return self._held.part(axis, cut[axis].start, cut[axis].stop)


@public
def fit_map(
    stack: Any,
    dt: Annotated[Interval | None, _INTERVAL] = None,
    *,
    data: str | None = None,
    axis: int | str | None = None,
    frequency_hz: Scalar | None = None,
    min_amplitude: Scalar | None = None,
    kind: Literal["amplitude", "displacement", "velocity", "acceleration"] = "amplitude",
    method: Literal["fit", "analyse"] = "fit",
    unit: str | None = None,
    model: str | None = None,
    band_hz: Band | None = None,
    start_s: Annotated[Interval | None, _INTERVAL] = None,
    end_s: Annotated[Interval | None, _INTERVAL] = None,
    lockin_time_constant_s: Scalar | None = None,
    lockin_order: int | None = None,
    resume: Path | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> xr.Dataset:
    """Separates viscous from sliding loss in every pixel of a stack.

    The stack is read block by block, some tens of megabytes at a time: it may
    be larger than memory.

    Parameters
    ----------
    stack : array of shape (y, x, t), in any order of axes
        A NumPy array or memmap, an h5py or zarr dataset, an xarray DataArray,
        whose coordinates and unit (``attrs["units"]``) are taken over, or the
        path of a .npy file, an HDF5 file or a zarr store.
    dt : float, quantity or duration
        Sampling interval [s]; for a DataArray with a coordinate of uniform
        times, the interval is that of the coordinate and no other is accepted.
    data : str, optional
        Path of the data set, if a file or a store has several of three axes.
    axis : int or str, optional
        The time axis, by number or, for a DataArray, by name. If not given, a
        dimension called ``time`` or ``t``, or the one with a coordinate of that name, of dates,
        durations or a unit of time, or else the last one, unless it has another coordinate.
    frequency_hz, min_amplitude, method : optional
        As for :func:`fit_batch`.
    kind : str
        What the samples are: amplitudes, or for ``method="analyse"`` the
        oscillation as displacement, velocity or acceleration.
    unit : str, optional
        Unit of the samples.
    model, band_hz, start_s, end_s, lockin_time_constant_s, lockin_order : optional
        Options of ``method="analyse"``, see :func:`ringdown`.
    resume : path, optional
        A folder for finished blocks. A map that was interrupted reuses the
        blocks with the same numbers and options, and computes the rest.
    progress : callable, optional
        Called after each block with the number of finished pixels and of all pixels.

    Returns
    -------
    xarray.Dataset
        The columns of :func:`fit_batch` over (y, x), with units. Its methods
        ``to_zarr(path, zarr_format=2)`` and ``to_netcdf(path, engine="h5netcdf")`` write it as
        zarr and as HDF5.

    Raises
    ------
    OptionError
        For a stack that does not have three axes, or an option out of range.
    ReadError
        For a file that cannot be read or contains no such array.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> t = 0.01 * np.arange(200)
    >>> friction = np.array([[0.0, 0.1], [0.2, 0.3]])
    >>> stack = np.exp(-0.5 * t) - friction[..., None] * (1 - np.exp(-0.5 * t)) / 0.5
    >>> found = slipfit.fit_map(stack, dt=0.01, unit="nm")
    >>> bool(abs(found["sliding_rate"].values - friction).max() < 1e-9), found["sliding_rate"].attrs["units"]
    (True, 'nm/s')
    """
    import xarray as xr

    if isinstance(stack, (str, os.PathLike)):
        stack = _Stored(stack, data)
        unit = stack.unit if unit is None else unit
    elif data is not None:
        raise _input.refuse("data", f"data={data!r}: it names an array in a file, and stack is one")
    labelled = isinstance(stack, xr.DataArray)
    if isinstance(stack, xr.Dataset):
        held = ", ".join(shown(str(name)) for name in stack.data_vars)
        raise wrong_type("stack", stack, f"one of the variables of the Dataset is needed: {held}")
    if not isinstance(getattr(stack, "shape", None), tuple):
        raise wrong_type("stack", stack, "an array with the axes (y, x, t), in any order, or a path is needed")
    shape = tuple(stack.shape)
    if len(shape) != 3:
        rows = "; slipfit.fit_batch takes traces in rows" if len(shape) == 2 else ""
        raise _input.refuse("stack", f"stack has the shape {shape}: (y, x, t) is needed, in any order{rows}")
    if 0 in shape:
        raise _input.refuse("stack", f"stack has the shape {shape}: it has no pixels or no samples")
    dims: tuple[Any, ...] = tuple(stack.dims) if labelled else ("y", "x")
    if len(set(dims)) < len(dims):
        raise _input.refuse("stack", f"stack has the dimensions {dims}: each needs a name of its own")
    if labelled and axis is None:
        named = _input.time_dimension(stack)
        if named is None and (dims[2] in stack.coords or str(dims[2]).lower() in ("x", "y", "z")):
            raise _input.refuse("axis", f"no coordinate of {dims} tells times: axis=… names the dimension of time")
        axis = None if named is None else dims.index(named)
    if isinstance(axis, str):
        if not labelled or axis not in dims:
            raise _input.refuse("axis", f"axis={axis!r}: there is no such dimension")
        axis = dims.index(axis)
    axis = 2 if axis is None else axis
    if not -3 <= axis < 3:
        raise _input.refuse("axis", f"axis={axis}: a stack has the axes 0, 1 and 2")
    axis %= 3
    coords: Any = {}
    if labelled:
        time_dim = dims[axis]
        dims = tuple(name for name in dims if name != time_dim)
        beside = stack.coords.to_dataset()
        coords = beside.drop_vars([name for name, one in beside.variables.items() if time_dim in one.dims]).coords
        timed = _input.time_coordinate(stack, time_dim)
        if timed is None and dt is None and time_dim in stack.coords:
            timed = time_dim
        if timed is not None:
            dt = _input.step_of(stack.coords[timed], timed, dt, "slipfit.fit_batch takes times")
    if not isinstance(stack, _Stored):
        own = _input.own_unit(stack)
        unit = _input.named(stack, own, _input.unit_told("stack", own, unit))[0]
    if dt is None:
        raise _input.refuse("dt", "dt is needed: the interval of the samples [s]")
    unit = unit or ""
    if kind in get_args(Motion) and method == "fit":
        raise _input.refuse("method", f"method='fit' and kind={kind!r}: an oscillation needs the method analyse")
    if kind != "amplitude" and _input.samples_in(unit)[2]:
        raise _input.refuse("kind", f"kind={kind!r} of samples in {unit!r}: levels are those of amplitudes; an oscillation has signs")
    column = "amplitude" if kind == "amplitude" else "signal"
    options: dict[str, Any] = {
        column: "trace", "dt": _input.interval("dt", dt),
        "frequency_hz": _input.optional("frequency_hz", frequency_hz),
        "min_amplitude": _input.optional("min_amplitude", _input.of_samples("min_amplitude", min_amplitude, _input.samples_in(unit)[0])),
        "method": method, "unit": unit, "kind": None if kind == "amplitude" else kind,
    }  # fmt: skip
    analysis = {
        "model": model, "band_hz": _input.band(band_hz),
        "start_s": _input.interval("start_s", start_s), "end_s": _input.interval("end_s", end_s),
        "lockin_time_constant_s": _input.optional("lockin_time_constant_s", lockin_time_constant_s),
        "lockin_order": _input.whole("lockin_order", lockin_order),
    }  # fmt: skip
    # Options that are not given leave the fingerprint of kept blocks unchanged.
    options.update({name: value for name, value in analysis.items() if value is not None})
    across = tuple(n for i, n in enumerate(shape) if i != axis)
    samples = shape[axis]
    # Errors of the options are raised before a pixel is read.
    columns = answer_schema(**options)
    taken = next((name for name in (*dims, *coords) if name in columns.column_names), None)
    if taken is not None:
        raise _input.refuse("stack", f"stack has {taken!r}, as a map has: rename that dimension or coordinate")
    folder = None if resume is None else FilePath(os.fspath(resume))
    if folder is not None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except ValueError as error:
            raise _input.refuse("resume", f"resume={resume!r}: {error}") from None
    parts: list[dict[str, NDArray[Any]]] = []
    for first, end in _blocks(across, samples):
        traces = _traces(stack, axis, first, end)
        place = None if folder is None else folder / f"rows-{first}-{end}.npz"
        signature = "" if place is None else _signature(traces, options)
        found = None if place is None else _stored(place, signature)
        if found is None:
            answers = fit_batch(traces, **options)
            found = {name: answers[name] for name in answers.column_names}
            if place is not None:
                _store(place, signature, found)
        parts.append(found)
        if progress is not None:
            progress(end * across[1], across[0] * across[1])
    variables = {
        name: (
            dims,
            np.concatenate([part[name] for part in parts]).reshape(across),
            {"units": columns.units.get(name, "")} if parts[0][name].dtype.kind == "f" else {},
        )
        for name in parts[0]
    }
    return xr.Dataset(variables, coords=coords, attrs={"method": method, "slipfit": _core.__version__})


def _traces(stack: Any, axis: int, first: int, end: int) -> NDArray[Any]:
    """The traces of some rows of pixels, one after the other."""
    # The first axis that is not time is cut.
    cut: list[slice] = [slice(None)] * 3
    cut[1 if axis == 0 else 0] = slice(first, end)
    block = np.moveaxis(np.asarray(_input.unmasked(_input.numbers(stack[tuple(cut)]))), axis, -1)
    if block.dtype.kind not in "fiu":
        raise _input.refuse("stack", f"stack holds {block.dtype} where real numbers are needed")
    return block.reshape(-1, block.shape[-1])
