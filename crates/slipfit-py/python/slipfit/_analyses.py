"""Reading and analysing."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from . import _core, _input
from ._arguments import is_bytes, public, wrong_type
from ._answers import Answer, LevelsAnswer, ResonanceAnswer, RingdownAnswer, SeriesAnswer, Table
from ._errors import FolderError, OptionError, ReadError, SlipfitError
from .typing import Band, Column, Interval, Kind, Motion, Path, Scalar, Uncertain

#: Description of valid times and intervals.
_INTERVAL = "a number of seconds or a duration is needed"

_CHOICES = (
    "format", "sheet", "part", "run", "time", "time_unit", "rate_hz", "signal", "quadrature", "unit", "kind",
    "most_samples", "frequency", "frequency_unit", "centre_hz", "amplitude", "phase", "phase_unit",
    "real", "imaginary", "std_error", "drive", "drive_unit",
)  # fmt: skip


def _choices(**given: Any) -> dict[str, Any]:
    """All options of reading; a column may be given by its number."""
    counts, numbers = ("part", "run", "most_samples"), ("rate_hz", "centre_hz")

    def choice(name: str, value: Any) -> Any:
        if name in counts:
            return _input.whole(name, value)
        return value if value is None or name in numbers else str(value)

    return {name: choice(name, given.get(name)) for name in _CHOICES}


def _source(source: object) -> Any:
    if isinstance(source, (bytearray, memoryview)):
        return bytes(source)
    if isinstance(source, bytes):
        return source
    if isinstance(source, (str, os.PathLike)):
        name = os.fspath(source)
        lines = len(name.splitlines())
        if isinstance(source, str) and lines > 1:
            raise _input.refuse("source", f"source is a text of {lines} lines, no path: give its bytes, .encode()")
        return [name]
    if isinstance(source, Iterable):
        paths = list(source)
        if all(map(_input.path_like, paths)):
            return [os.fspath(one) for one in paths]
    raise wrong_type("source", source, "paths or bytes are needed")


def _refuse_folder(source: object, advice: str) -> None:
    """Refuses a folder where a file is needed."""
    if not isinstance(source, (str, os.PathLike)):
        return
    name = os.fspath(source)
    if os.path.isdir(name):
        hints = [(None, None, advice, advice)]
        raise FolderError(f"{name}: this is a folder", "folder", hints, advice, {"file": name, "row": None})


@public
def read(
    source: Path | bytes | bytearray | memoryview,
    name: str | None = None,
    *,
    time: Column | None = None,
    signal: Column | None = None,
    quadrature: Column | None = None,
    time_unit: str | None = None,
    unit: str | None = None,
    kind: Kind | None = None,
    rate_hz: Scalar | None = None,
    sheet: Column | None = None,
    part: int | None = None,
    run: int | None = None,
    most_samples: int | None = None,
    format: str | None = None,
) -> _core.Record:
    """Reads a record of any format that slipfit knows.

    Parameters
    ----------
    source : path or bytes
        A file, or its content.
    name : str, optional
        Name of the bytes in reports and errors.
    time, signal, quadrature : str or int, optional
        Columns by name or by number from 1; for a lock-in X and Y.
    time_unit, unit : str, optional
        Units, if the file does not state them.
    kind : str, optional
        ``displacement``, ``velocity``, ``acceleration``, ``envelope`` or ``lock-in``.
    rate_hz : float or quantity, optional
        Samples per second, instead of a column of times.
    sheet : str or int, optional
        Which sheet, variable, group or track.
    part, run : int, optional
        Which of several tables side by side; which of several runs, in groups of columns or one after
        the other; from 1.
    most_samples : int, optional
        Maximum number of samples held; longer records are averaged while they are read.
    format : str, optional
        The format (``text``, ``wav``, ``mat``, ...), if the first bytes do not identify it.

    Returns
    -------
    Record
        Samples with a clean clock, for :func:`ringdown`.

    Raises
    ------
    ReadError
        If the file cannot be read; gives the row and hints. A FolderError for a folder.
    OSError
        If the operating system refuses access.

    Examples
    --------
    >>> import slipfit
    >>> rows = "".join(f"{0.1 * i:.1f},{5 * 0.98**i * (-1) ** i:.4f}\\n" for i in range(60))
    >>> record = slipfit.read(b"t (s),x (mm)\\n" + rows.encode(), "swing.csv")
    >>> len(record), record.unit
    (60, 'mm')
    """
    if isinstance(source, (str, os.PathLike)):
        files = os.path.join(os.fspath(source), "*")
        _refuse_folder(source, f"slipfit.engines.arrow.ringdown_files({files!r}) makes a table of its decays")
    choices = _choices(
        time=time, signal=signal, quadrature=quadrature, time_unit=time_unit, unit=unit, kind=kind,
        rate_hz=_input.optional("rate_hz", rate_hz), sheet=sheet, part=part, run=run,
        most_samples=most_samples, format=format,
    )  # fmt: skip
    return _core.read_record(_source(source), name, choices)


@public
def read_curve(
    source: Path | Iterable[Path] | bytes | bytearray | memoryview,
    name: str | None = None,
    *,
    frequency: Column | None = None,
    amplitude: Column | None = None,
    phase: Column | None = None,
    real: Column | None = None,
    imaginary: Column | None = None,
    drive: Column | None = None,
    std_error: Column | None = None,
    frequency_unit: str | None = None,
    unit: str | None = None,
    phase_unit: str | None = None,
    centre_hz: Scalar | None = None,
    kind: Motion | None = None,
    sheet: Column | None = None,
    run: int | None = None,
    time: Column | None = None,
    time_unit: str | None = None,
    rate_hz: Scalar | None = None,
    format: str | None = None,
) -> _core.Curve:
    """Reads a resonance curve, or demodulates the driven records of several files or a folder.

    Parameters
    ----------
    source : path, sequence of paths or bytes
        The curve, or one driven record per frequency.
    name : str, optional
        Name of the bytes in reports and errors.
    frequency, amplitude, phase, real, imaginary, drive, std_error : str or int, optional
        Columns by name or by number from 1.
    frequency_unit, unit, phase_unit : str, optional
        Units, if the file does not state them.
    centre_hz : float or quantity, optional
        The frequency from which shifts are counted.
    kind : str, optional
        What the response is; divided by i omega once for a velocity, twice for an acceleration.
    sheet, run : str or int, optional
        Which table, which curve in groups of columns.
    time, time_unit, rate_hz : optional
        Clock of driven records.
    format : str, optional
        The format, if the first bytes do not identify it.

    Returns
    -------
    Curve
        For :func:`resonance`.

    Raises
    ------
    ReadError
        If the file cannot be read; gives the row and hints.
    """
    _check_motion(kind)
    choices = _choices(
        frequency=frequency, amplitude=amplitude, phase=phase, real=real, imaginary=imaginary,
        drive=drive, std_error=std_error, frequency_unit=frequency_unit, unit=unit,
        phase_unit=phase_unit, centre_hz=_input.optional("centre_hz", centre_hz), kind=kind,
        sheet=sheet, run=run, time=time, time_unit=time_unit, format=format,
        rate_hz=_input.optional("rate_hz", rate_hz),
    )  # fmt: skip
    return _core.read_curve(_source(source), name, choices)


@public
def read_levels(
    source: Path | bytes | bytearray | memoryview,
    name: str | None = None,
    *,
    drive: Column | None = None,
    amplitude: Column | None = None,
    real: Column | None = None,
    imaginary: Column | None = None,
    std_error: Column | None = None,
    unit: str | None = None,
    drive_unit: str | None = None,
    sheet: Column | None = None,
    format: str | None = None,
) -> _core.Levels:
    """Reads drive levels and the amplitudes they gave.

    Parameters
    ----------
    source : path or bytes
        The table.
    name : str, optional
        Name of the bytes in reports and errors.
    drive, amplitude, std_error : str or int, optional
        Columns by name or by number from 1.
    real, imaginary : str or int, optional
        Columns of the two outputs of a lock-in, whose modulus is used.
    unit, drive_unit : str, optional
        Units, if the file does not state them.
    sheet : str or int, optional
        Which table.
    format : str, optional
        The format, if the first bytes do not identify it.

    Returns
    -------
    Levels
        For :func:`levels`.

    Raises
    ------
    ReadError
        If the file cannot be read; gives the row and hints.
    """
    _refuse_folder(source, "one of its files is needed")
    choices = _choices(
        drive=drive, amplitude=amplitude, real=real, imaginary=imaginary, std_error=std_error, unit=unit,
        drive_unit=drive_unit, sheet=sheet, format=format,
    )  # fmt: skip
    return _core.read_levels(_source(source), name, choices)


def _record(
    time: Any,
    signal: Any = None,
    quadrature: ArrayLike | None = None,
    rate_hz: Scalar | None = None,
    unit: str | None = None,
    kind: Kind | None = None,
) -> _core.Record:
    given = {"signal": signal, "quadrature": quadrature, "rate_hz": rate_hz, "unit": unit, "kind": kind}
    if isinstance(time, _core.Record):
        _nothing_besides(given, "a Record", "")
        return time
    _own_kind("time", time)
    if _input.path_like(time) or is_bytes(time):
        if signal is None and quadrature is None:
            return read(time, rate_hz=rate_hz, unit=unit, kind=kind)
        _nothing_besides(given, "a file", "; slipfit.read(file, signal=…) names its columns")
    if kind == "lock-in" and quadrature is None:
        outputs = "signal=… and quadrature=… are the two outputs of a lock-in; kind='envelope' takes their amplitudes"
        raise _input.refuse("quadrature", f"kind={kind!r} without quadrature: {outputs}")
    if kind in get_args(Kind) and kind != "lock-in" and quadrature is not None:
        raise _input.refuse("kind", f"kind={kind!r} beside quadrature, which only a lock-in has")
    if rate_hz is not None and time is not None and signal is not None:
        raise _input.refuse("rate_hz", "rate_hz is given beside time, which tells it already")
    shape = getattr(time, "shape", None)
    if signal is None and isinstance(shape, tuple) and len(shape) == 2 and not _input.is_of_xarray(time):
        table, named = type(time).__name__, _input.columns_of(time)
        of = f"of {shape[1]} column{'s' if shape[1] != 1 else ''}"
        needed = "one is needed as time, one as signal" if shape[1] != 1 else "the column itself is needed"
        raise _input.refuse("time", f"time is a {table} {of}: {needed}{named and f'; there is {named}'}")
    times, values, own_unit = _input.time_and_signal(time, signal)
    if rate_hz is not None:
        # The rate replaces time stamps.
        times = None
        _input.check_every_row(time if signal is None else signal, rate_hz)
    elif times is None:
        if values is not None and np.ndim(_input.held("signal", values)) != 1:
            # A table, or anything else that is not a signal: the error about its shape is more helpful.
            _input.vector("signal", values)
        if signal is None and quadrature is None and time is not None:
            missing = "signal is missing; if this is the signal, give rate_hz"
            raise _input.refuse("time", f"no times: give time or rate_hz; {missing}")
        raise _input.refuse("time", "no times: give time or rate_hz")
    told, of_numbers = _input.named(time if signal is None else signal, own_unit, _input.unit_told("signal", own_unit, unit))
    _input.check_same_rows("quadrature", quadrature, "signal", time if signal is None else signal)
    if quadrature is None and _input.held("signal", values).dtype.kind == "c":
        advice = "of a lock-in give signal=z.real, quadrature=z.imag"
        raise _input.refuse("signal", f"signal is complex where real numbers are needed: {advice}")
    columns = {
        "time_s": times,
        "signal": _input.vector("signal", values),
        "quadrature": None if quadrature is None else _input.alike("quadrature", quadrature, of_numbers),
    }
    rate = _input.optional("rate_hz", rate_hz)
    record: _core.Record = _of_arrays(_core.record_of_arrays, columns, rate, told, kind)
    if times is not None:
        _input.check_order("time", times)
    return record


def _of_arrays(take: Callable[..., Any], columns: dict[str, Any], *others: Any) -> Any:
    """Reads arrays; errors name arguments and indices instead of a file."""
    try:
        return take(*columns.values(), *others)
    except ReadError as error:
        raise _as_option(error, [name for name, column in columns.items() if column is not None]) from None


def _as_option(error: ReadError, names: list[str]) -> OptionError:
    def named(place: re.Match[str]) -> str:
        number = int(place[1])
        return names[number - 1] if number <= len(names) else place[0]

    details = {name: value for name, value in error.details.items() if name not in ("file", "row", "column")}
    message = re.sub(r"^arrays(, row \d+)?: ", "", error.message)
    message = re.sub(r"\bcolumn (\d+)( `\w+`)?", named, message)
    # Rows of files count from one, arrays from zero.
    message = re.sub(r"\(row (\d+)", lambda row: f"(index {int(row[1]) - 1}", message)
    if error.details.get("row") is not None:
        details["index"] = error.details["row"] - 1
        message = f"{message}, at index {details['index']}"
    column = re.match(r"column (\d+)", error.details.get("column") or "")
    if column is not None:
        details["option"] = named(column)
    hints = [(one.option, one.value, one.advice, one.text) for one in error.hints]
    return OptionError(message, error.code, hints, error.advice, details)


def _of_frame(option: str, frame: Any, read: Callable[..., Any], **choices: str | None) -> Any:
    """Reads a data frame like the file that it would be written to: its columns are recognised by their names."""
    own = list(getattr(frame, "column_names", None) or frame.columns)
    columns = {}
    for name in own:
        if own.count(name) > 1:
            raise _input.refuse(option, f"{option} has several columns of one name: {_input.columns_of(frame)}")
        try:
            column = frame[name]
            dates = np.asarray(column).dtype.kind in "mM" or getattr(getattr(column, "dtype", None), "tz", None) is not None
            columns["time (s)" if dates else str(name)] = _input.seconds(str(name), column) if dates else _input.vector(str(name), column)
        except OptionError as error:
            raise _input.refuse(option, f"{option}: {error.message}") from None
    if len(columns) < len(own):
        raise _input.refuse(option, f"{option} has several columns of times: {_input.columns_of(frame)}")
    rows = np.empty(len(frame), [(name, np.float64) for name in columns])
    for name, numbers in columns.items():
        rows[name] = numbers
    file = io.BytesIO()
    np.save(file, rows)
    try:
        return read(file.getvalue(), "arrays", _choices(**choices))
    except ReadError as error:
        told = _as_option(error, list(columns))
        needed = "give the columns themselves, one by one"
        raise OptionError(told.message, told.code, advice=needed, details={**told.details, "option": option}) from None


def _own_kind(option: str, given: object) -> None:
    """Refuses objects of another analysis, a table of which columns are needed, and an open file."""
    for kind, analysis in ((_core.Record, "ringdown"), (_core.Curve, "resonance"), (_core.Levels, "levels")):
        if isinstance(given, kind):
            raise wrong_type(option, given, f"slipfit.{analysis} takes it")
    if callable(getattr(given, "read", None)):
        raise wrong_type(option, given, "a path, bytes or arrays are needed")
    if isinstance(given, Table):
        raise wrong_type(option, given, f"one of its columns is needed: {', '.join(given)}")


def _nothing_besides(given: dict[str, Any], what: str, hint: str) -> None:
    for name, value in given.items():
        if value is not None:
            raise _input.refuse(name, f"{name} is given beside {what}, which holds it already{hint}")


@public
def ringdown(
    time: Any = None,
    signal: Any = None,
    *,
    quadrature: ArrayLike | None = None,
    rate_hz: Scalar | None = None,
    unit: str | None = None,
    kind: Kind | None = None,
    model: str | None = None,
    band_hz: Band | None = None,
    start_s: Annotated[Interval | None, _INTERVAL] = None,
    end_s: Annotated[Interval | None, _INTERVAL] = None,
    min_amplitude: Scalar | None = None,
    law: str | None = None,
    frequency_hz: Scalar | None = None,
    lockin_time_constant_s: Scalar | None = None,
    lockin_order: int | None = None,
    stiffness: Uncertain | None = None,
    mass: Uncertain | None = None,
    torsion_stiffness: Uncertain | None = None,
    inertia: Uncertain | None = None,
) -> RingdownAnswer:
    """Separates viscous damping from sliding friction in a free decay.

    Finds the decay in the record, fits every combination of viscous, sliding
    and drag losses with the exact motion between turning points, compares them
    and gives the evidence.

    Parameters
    ----------
    time : array_like, shape (n,), or Record, path, Series, DataArray
        Times [s], or dates or durations. A pandas Series with its times as
        index, an xarray DataArray with a coordinate, a :class:`Record`, a path
        or the bytes of a file are given alone, without `signal`.
    signal : array_like, shape (n,)
        Samples in any unit; NaN is left out and counted. For a lock-in, its X output.
    quadrature : array_like, shape (n,), optional
        Y output of a lock-in.
    rate_hz : float or quantity, optional
        Samples per second, instead of `time`.
    unit : str, optional
        Unit of the samples, such as ``rad`` or ``mm``.
    kind : str, optional
        ``displacement``, ``velocity``, ``acceleration``, ``envelope`` or
        ``lock-in``; determined from the data if not given.
    model : str, optional
        Report this loss model, such as ``viscous+sliding``, whichever the data prefer.
    band_hz : (low, high), optional
        Use only oscillations between these frequencies [Hz].
    start_s, end_s : float, quantity or duration, optional
        First and last time used [s].
    min_amplitude : float or quantity, optional
        Follow the decay only down to this amplitude, unit of the signal.
    law : {"free", "rising"}, optional
        Also estimate the loss against amplitude without a model, with its confidence band;
        ``"rising"`` if the loss grows with the amplitude.
    frequency_hz : float or quantity, optional
        Frequency of the oscillation [Hz], for amplitudes, which do not contain it.
    lockin_time_constant_s, lockin_order : float and int, optional
        Output filter of the lock-in: time constant of a stage [s] and number of stages.
    stiffness, mass, torsion_stiffness, inertia : float, quantity or (value, std_error), optional
        One of them converts displacements to forces [N/m, kg, N m/rad, kg m²].

    Returns
    -------
    RingdownAnswer
        Parameters with 95 % intervals, evidence, comparison of models, warnings.

    Raises
    ------
    NoAnswerError
        If the record shows no oscillation or no decay.
    OptionError
        If an argument is invalid.
    ReadError
        If a file cannot be read.

    Notes
    -----
    The model is that of Vitorino, Vieira and Rodrigues, Sci. Rep. 7 (2017),
    doi:10.1038/s41598-017-03999-w.

    Arrays are analysed like the file that ``numpy.save`` would write of them:
    the command gives the same answer.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> swing = slipfit.simulate.decay(
    ...     frequency_hz=1.2, q_factor=80, friction_displacement=0.002,
    ...     amplitude=0.4, duration_s=40, rate_hz=50, unit="rad")
    >>> noise = 5e-4 * np.random.default_rng(1).standard_normal(len(swing))
    >>> answer = slipfit.ringdown(swing.time_s, swing.signal + noise, unit="rad")
    >>> answer.sliding.detected
    True
    >>> x_f = answer.parameters.friction_displacement
    >>> abs(x_f.value - 0.002) < 4 * x_f.std_error, x_f.unit
    (True, 'rad')
    """
    record = _record(time, signal, quadrature, rate_hz, unit, kind)
    choices = _ringdown_choices(
        start_s=start_s, end_s=end_s,
        min_amplitude=_input.of_samples("min_amplitude", min_amplitude, record.unit), band_hz=band_hz,
        model=model, law=law, lockin_time_constant_s=lockin_time_constant_s, lockin_order=lockin_order,
        frequency_hz=frequency_hz,
    )  # fmt: skip
    constants = _input.constants(
        {"stiffness": stiffness, "mass": mass, "torsion_stiffness": torsion_stiffness, "inertia": inertia}
    )
    _core.check_ringdown(choices, constants)
    _check_filter(record, choices)
    return RingdownAnswer(_core.ringdown_answer(record, choices, constants))


def _check_filter(record: _core.Record, choices: Mapping[str, Any]) -> None:
    """Refuses the output filter of a lock-in for a record that did not pass one."""
    constant, order = choices["lockin_time_constant_s"], choices["lockin_order"]
    if constant is not None and order is not None and record.kind not in ("envelope", "lock-in"):
        what = f"only for amplitudes and the outputs of a lock-in; this record oscillates, its kind is {record.kind!r}"
        raise _input.refuse("lockin_time_constant_s", f"lockin_time_constant_s={constant:g}: {what}")


def _ringdown_choices(
    start_s: Annotated[Interval | None, _INTERVAL] = None,
    end_s: Annotated[Interval | None, _INTERVAL] = None,
    min_amplitude: Scalar | None = None,
    band_hz: Band | None = None,
    model: str | None = None,
    law: str | None = None,
    lockin_time_constant_s: Scalar | None = None,
    lockin_order: int | None = None,
    frequency_hz: Scalar | None = None,
) -> dict[str, Any]:
    number = _input.optional
    return {
        "start_s": _input.interval("start_s", start_s),
        "end_s": _input.interval("end_s", end_s),
        "min_amplitude": number("min_amplitude", min_amplitude),
        "band_hz": _input.band(band_hz),
        "model": model,
        "law": law,
        "lockin_time_constant_s": number("lockin_time_constant_s", lockin_time_constant_s),
        "lockin_order": _input.whole("lockin_order", lockin_order),
        "frequency_hz": number("frequency_hz", frequency_hz),
    }


def _check_motion(kind: str | None) -> None:
    """Refuses kinds that only a record in time can have."""
    if kind in ("envelope", "lock-in"):
        raise _input.refuse("kind", f"kind={kind!r}: one of {', '.join(get_args(Motion))} for a resonance curve")


def _curve(
    frequency: Any,
    response: Any = None,
    *,
    phase_rad: ArrayLike | None = None,
    std_error: ArrayLike | None = None,
    drive: ArrayLike | None = None,
    unit: str | None = None,
    kind: Motion | None = None,
) -> _core.Curve:
    _check_motion(kind)
    given = {
        "response": response, "phase_rad": phase_rad, "std_error": std_error, "drive": drive,
        "unit": unit, "kind": kind,
    }  # fmt: skip
    if isinstance(frequency, _core.Curve):
        _nothing_besides(given, "a Curve", "")
        return frequency
    if _is_simulated(frequency, "frequency_hz"):
        _nothing_besides(given, "a simulated curve", "")
        of_response = frequency.units.get("amplitude")
        return _curve(frequency["frequency_hz"], frequency["amplitude"], phase_rad=frequency["phase_rad"], unit=of_response)
    _own_kind("frequency", frequency)
    paths = isinstance(frequency, (list, tuple)) and bool(frequency) and all(map(_input.path_like, frequency))
    if paths or _input.path_like(frequency) or is_bytes(frequency):
        del given["unit"], given["kind"]
        _nothing_besides(given, "a file", "; slipfit.read_curve(file, amplitude=…) names its columns")
        return read_curve(frequency, unit=unit, kind=kind)
    own, labelled = _input.own_unit(response), frequency if response is None else response
    if response is None:
        frequency, response, own = _input.frequency_and_response(frequency)
    told, of_numbers = _input.named(labelled, own, _input.unit_told("response", own, unit))
    if frequency is None or response is None:
        raise _input.refuse("response", "a curve needs frequencies and a response")
    for name in ("phase_rad", "std_error", "drive"):
        _input.check_same_rows(name, given[name], "response", labelled)
    parts = _parts("response", response)
    phases = None if phase_rad is None else _input.radians("phase_rad", phase_rad)
    errors = None if std_error is None else _input.alike("std_error", std_error, of_numbers)
    drives = None if drive is None else _input.vector("drive", drive)
    amplitude, real, imaginary = parts
    if real is not None and phase_rad is not None:
        raise _input.refuse("phase_rad", "phase_rad is given beside a complex response, which has it")
    columns = {
        "frequency_hz": _input.hertz("frequency", frequency), "amplitude": amplitude, "phase_rad": phases,
        "real": real, "imaginary": imaginary, "std_error": errors, "drive": drives,
    }  # fmt: skip
    _input.check_any(columns, {"frequency_hz": "frequency", "amplitude": "response", "real": "response", "imaginary": "response"})
    curve: _core.Curve = _of_arrays(_core.curve_of_arrays, columns, told, kind)
    return curve


def _is_simulated(given: Any, over: str) -> bool:
    """Whether this is what :mod:`slipfit.simulate` gives, amplitudes and phases over this column."""
    return isinstance(given, Table) and set(given) == {over, "amplitude", "phase_rad"}


def _parts(name: str, response: Any) -> tuple[Any, Any, Any]:
    """Amplitudes, or real and imaginary parts of complex values."""
    values = _input.held(name, response)
    if values.dtype.kind != "c":
        return _input.vector(name, response), None, None
    # Of a masked value both parts are missing.
    values = np.where(np.isnan(values), complex(np.nan, np.nan), values)
    return None, _input.vector(name, np.real(values)), _input.vector(name, np.imag(values))


@public
def resonance(
    frequency: Any,
    response: Any = None,
    *,
    phase_rad: ArrayLike | None = None,
    std_error: ArrayLike | None = None,
    drive: ArrayLike | None = None,
    unit: str | None = None,
    kind: Motion | None = None,
    reference: _core.Curve | Table | Path | Sequence[Path] | bytes | None = None,
    drive_amplitude: Uncertain | None = None,
    band_hz: Band | None = None,
    method: Literal["exact", "leading", "paper"] = "exact",
    model: str | None = None,
    background: bool | None = None,
    delay: bool | None = None,
    amplitude_offset: bool | None = None,
    noise_floor: bool | None = None,
    phase_offset: bool | None = None,
    duffing: bool | None = None,
    stiffness: Uncertain | None = None,
    mass: Uncertain | None = None,
    torsion_stiffness: Uncertain | None = None,
    inertia: Uncertain | None = None,
) -> ResonanceAnswer:
    """Separates viscous damping from sliding friction in a resonance curve.

    Parameters
    ----------
    frequency : array_like, shape (n,), or Curve, path, paths
        Frequencies [Hz]. A :class:`Curve`, the result of :func:`slipfit.simulate.sweep`, a path,
        several paths or a folder of driven records are given alone, without `response`.
    response : array_like, shape (n,)
        Amplitudes, or complex responses, in any unit.
    phase_rad : array_like, shape (n,), optional
        Phases [rad] of real amplitudes.
    std_error : array_like, shape (n,), optional
        Standard errors of the amplitudes.
    drive : array_like, shape (n,), optional
        Level of the drive at each point, which is divided out.
    unit : str, optional
        Unit of the response.
    kind : str, optional
        What the response is: ``displacement``, ``velocity``, ``acceleration``.
    reference : Curve, simulated curve or path, optional
        A friction-free curve of the same oscillator and drive, which gives the drive amplitude. It has
        its own frequency, viscous damping, phase and background; delay, drag and Duffing term are shared.
    drive_amplitude : float, quantity or (value, std_error), optional
        Drive amplitude x_0, in the unit of the response.
    band_hz : (low, high), optional
        Use only points between these frequencies [Hz].
    method : str, optional
        ``exact``, ``leading`` (eq. 8 of the paper) or ``paper`` (its eq. 14).
    model : str, optional
        Report this loss model, whichever the data prefer.
    background, delay, amplitude_offset, noise_floor, phase_offset, duffing : bool, optional
        Whether these terms are fitted; decided by the data if not given. ``amplitude_offset`` is a constant offset
        of every amplitude of a curve without phases, such as the zero of a detector; ``noise_floor`` is added in
        quadrature, as in a spectrum analyser.
    stiffness, mass, torsion_stiffness, inertia : float, quantity or (value, std_error), optional
        One of them converts displacements to forces.

    Returns
    -------
    ResonanceAnswer
        Parameters with 95 % intervals, evidence, comparison of models, warnings.

    Raises
    ------
    NoAnswerError
        If the curve shows no resonance.
    OptionError
        If an argument is invalid.
    ReadError
        If a file cannot be read.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> sweep = slipfit.simulate.sweep(
    ...     np.linspace(0.9, 1.1, 81), frequency_hz=1.0, q_factor=50,
    ...     friction_displacement=0.3, drive_amplitude=1.0)
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(81)
    >>> answer = slipfit.resonance(
    ...     sweep["frequency_hz"], sweep["amplitude"] + noise, drive_amplitude=1.0, unit="mm")
    >>> abs(answer.parameters.friction_displacement.value - 0.3) < 0.01
    True
    """
    curve = _curve(
        frequency, response, phase_rad=phase_rad, std_error=std_error, drive=drive, unit=unit, kind=kind
    )
    choices = _resonance_choices(
        band_hz=band_hz, method=method, model=model,
        drive_amplitude=_input.of_samples("drive_amplitude", drive_amplitude, curve.unit, uncertain=True),
        background=background, delay=delay, amplitude_offset=amplitude_offset, noise_floor=noise_floor,
        phase_offset=phase_offset, duffing=duffing,
    )  # fmt: skip
    constants = _input.constants(
        {"stiffness": stiffness, "mass": mass, "torsion_stiffness": torsion_stiffness, "inertia": inertia}
    )
    free = None if reference is None else _curve(reference)
    return ResonanceAnswer(_core.resonance_answer(curve, free, choices, constants))


def _resonance_choices(
    band_hz: Band | None = None,
    method: str = "exact",
    model: str | None = None,
    drive_amplitude: Uncertain | None = None,
    background: bool | None = None,
    delay: bool | None = None,
    amplitude_offset: bool | None = None,
    noise_floor: bool | None = None,
    phase_offset: bool | None = None,
    duffing: bool | None = None,
) -> dict[str, Any]:
    return {
        "band_hz": _input.band(band_hz),
        "method": method,
        "model": model,
        "drive_amplitude": _input.pair("drive_amplitude", drive_amplitude),
        "background": background,
        "delay": delay,
        "amplitude_offset": amplitude_offset,
        "noise_floor": noise_floor,
        "phase_offset": phase_offset,
        "duffing": duffing,
    }


def _levels(
    drive: Any,
    amplitude: Any = None,
    *,
    std_error: ArrayLike | None = None,
    unit: str | None = None,
    drive_unit: str | None = None,
) -> _core.Levels:
    given = {"amplitude": amplitude, "std_error": std_error, "unit": unit, "drive_unit": drive_unit}
    if isinstance(drive, _core.Levels):
        _nothing_besides(given, "Levels", "")
        return drive
    if _is_simulated(drive, "drive_amplitude"):
        _nothing_besides(given, "simulated levels", "")
        unit, of_drive = (drive.units.get(name) for name in ("amplitude", "drive_amplitude"))
        return _levels(drive["drive_amplitude"], drive["amplitude"], unit=unit, drive_unit=of_drive)
    _own_kind("drive", drive)
    if _input.path_like(drive) or is_bytes(drive):
        del given["unit"], given["drive_unit"]
        _nothing_besides(given, "a file", "; slipfit.read_levels(file, amplitude=…) names its columns")
        return read_levels(drive, unit=unit, drive_unit=drive_unit)
    if amplitude is None and len(getattr(drive, "columns", ())) > 1:
        _nothing_besides({"std_error": std_error}, "a table", "")
        table: _core.Levels = _of_frame("drive", drive, _core.read_levels, unit=unit, drive_unit=drive_unit)
        return table
    if amplitude is None:
        drive, amplitude = _input.drive_and_amplitude(drive)
    if amplitude is None:
        raise _input.refuse("amplitude", "levels need amplitudes beside the levels of the drive")
    _input.check_same_rows("std_error", std_error, "amplitude", amplitude)
    own = _input.own_unit(amplitude)
    told, of_numbers = _input.named(amplitude, own, _input.unit_told("amplitude", own, unit))
    measured, real, imaginary = _parts("amplitude", amplitude)
    columns = {
        "drive": _input.vector("drive", drive), "amplitude": measured, "real": real, "imaginary": imaginary,
        "std_error": None if std_error is None else _input.alike("std_error", std_error, of_numbers),
    }  # fmt: skip
    _input.check_any(columns, {"real": "amplitude", "imaginary": "amplitude"})
    of_drive, _ = _input.named(drive, None, _input.unit_told("drive", _input.own_unit(drive), drive_unit, "drive_unit"))
    levels: _core.Levels = _of_arrays(_core.levels_of_arrays, columns, told, of_drive)
    return levels


@public
def levels(
    drive: Any,
    amplitude: Any = None,
    *,
    std_error: ArrayLike | None = None,
    unit: str | None = None,
    drive_unit: str | None = None,
    frequency_hz: Scalar | None = None,
    drive_gain: Uncertain | None = None,
    q_factor: Uncertain | None = None,
    stiffness: Uncertain | None = None,
    mass: Uncertain | None = None,
    torsion_stiffness: Uncertain | None = None,
    inertia: Uncertain | None = None,
) -> LevelsAnswer:
    """Threshold and slope of the amplitude at resonance against the drive level.

    Parameters
    ----------
    drive : array_like, shape (n,), or Levels, path, Series, DataArray, DataFrame
        Levels of the drive. Given alone are :class:`Levels`, the result of :func:`slipfit.simulate.levels`, a path,
        a pandas Series with the levels as index, an xarray DataArray with a coordinate, and a DataFrame, whose
        columns are recognised by their names as in a file.
    amplitude : array_like, shape (n,)
        Amplitude at resonance at each level, or complex response, whose modulus is used.
    std_error : array_like, shape (n,), optional
        Standard errors of the amplitudes.
    unit, drive_unit : str, optional
        Units of amplitudes and levels; if both are lengths or both are angles, Q and x_F follow.
    frequency_hz : float or quantity, optional
        Frequency of the resonance [Hz], with which the decay rate follows from Q.
    drive_gain : float, quantity or (value, std_error), optional
        Drive amplitude at the base, in the unit of the amplitudes, per unit of the level.
    q_factor : float, quantity or (value, std_error), optional
        Quality factor of the viscous loss, instead of `drive_gain`.
    stiffness, mass, torsion_stiffness, inertia : float, quantity or (value, std_error), optional
        One of them converts displacements to forces.

    Returns
    -------
    LevelsAnswer
        Slope, threshold and derived parameters.

    Raises
    ------
    NoAnswerError
        If no line rises with the drive.
    OptionError
        If an argument is invalid.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> drive = np.arange(0.1, 1.3, 0.1)
    >>> amplitude = np.maximum(40 * (drive - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5)
    >>> answer = slipfit.levels(drive, amplitude, unit="mm", drive_unit="mm")
    >>> abs(answer.parameters.threshold.value - 0.35) < 0.01
    True
    """
    held = _levels(drive, amplitude, std_error=std_error, unit=unit, drive_unit=drive_unit)
    gain = _input.of_samples("drive_gain", drive_gain, _gain_unit(held), uncertain=True)
    choices = _levels_choices(frequency_hz=frequency_hz, drive_gain=gain, q_factor=q_factor)
    constants = _input.constants(
        {"stiffness": stiffness, "mass": mass, "torsion_stiffness": torsion_stiffness, "inertia": inertia}
    )
    return LevelsAnswer(_core.levels_answer(held, choices, constants))


def _gain_unit(held: _core.Levels) -> str:
    """Unit of the amplitude at the base per unit of the level; empty if unknown."""
    return f"{held.unit}/{held.drive_unit}" if held.unit and held.drive_unit else ""


def _levels_choices(
    frequency_hz: Scalar | None = None,
    drive_gain: Uncertain | None = None,
    q_factor: Uncertain | None = None,
) -> dict[str, Any]:
    return {
        "frequency_hz": _input.optional("frequency_hz", frequency_hz),
        "drive_gain": _input.pair("drive_gain", drive_gain),
        "q_factor": _input.pair("q_factor", q_factor),
    }


#: Data that are held by each analysis.
_HELD: dict[str, Any] = {"ringdown": _core.Record, "resonance": _core.Curve, "levels": _core.Levels}

#: What each analysis answers.
_ANSWERS = {"ringdown": RingdownAnswer, "resonance": ResonanceAnswer, "levels": LevelsAnswer}

#: What reads the arrays of each analysis, and its files.
_OF_ARGUMENTS: dict[str, Callable[..., Any]] = {"ringdown": _record, "resonance": _curve, "levels": _levels}
_OF_FILES: dict[str, Callable[..., Any]] = {
    "ringdown": _core.read_record, "resonance": _core.read_curve, "levels": _core.read_levels,
}  # fmt: skip

#: Options of each analysis that belong to its arrays.
_OF_ARRAYS = {
    "ringdown": ("quadrature", "rate_hz", "unit", "kind"),
    "resonance": ("phase_rad", "std_error", "drive", "unit", "kind"),
    "levels": ("std_error", "unit", "drive_unit"),
}

_DATA = (
    "a Record, a Curve or Levels are needed, as slipfit.read, read_curve and read_levels give them, an answer, or arrays, "
    "such as (time, signal)"
)


@dataclass(frozen=True)
class Measurement:
    """One measurement of a series.

    Parameters
    ----------
    data : Record, Curve, Levels, answer, pair of arrays, Series, DataArray, DataFrame
        What was measured: from :func:`read`, :func:`read_curve`, :func:`read_levels`; an answer of
        :func:`ringdown`, :func:`resonance` or :func:`levels`, whose data are analysed with its options; a
        simulated curve; or arrays, as the function called `analysis` takes them: ``(time, signal)``, a pandas
        Series with its times as index, an xarray DataArray. The columns of a DataFrame are recognised by their
        names as in a file. Arrays become a Record, a Curve or Levels.
    condition : str
        Label of the condition of the measurement, such as ``9 nN``; its value and unit if not given.
    value : float, quantity or (value, std_error), optional
        The condition as a number.
    name : str, optional
        Name of the measurement; that of its file if not given.
    reference : Curve, optional
        Friction-free reference of a curve.
    scale : float or quantity, optional
        Factor from its unit to that of the series, if the units do not determine it.
    options : dict
        Options of its analysis: those of :func:`ringdown`, :func:`resonance` or :func:`levels`. Those that say what
        arrays are, such as ``unit``, are for arrays only.
    analysis : str, optional
        What arrays are: ``ringdown``, ``resonance`` or ``levels``; ``ringdown`` if not given.

    Raises
    ------
    OptionError
        If the data are not such a measurement, or an option is invalid.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> t = 0.02 * np.arange(1500)
    >>> x = np.exp(-0.05 * t) * np.cos(8 * t)
    >>> slipfit.Measurement((t, x), value=5, options={"unit": "mrad"}).data
    <Record of arrays: 1500 samples, unit "mrad">
    """

    data: Any
    condition: Annotated[str, "a label; its number is `value`"] = ""
    value: Uncertain | None = None
    name: str | None = None
    reference: _core.Curve | None = None
    scale: Scalar | None = None
    options: dict[str, Any] = field(default_factory=dict)
    analysis: Literal["ringdown", "resonance", "levels"] | None = None

    def __post_init__(self) -> None:
        if self.analysis is not None and self.analysis not in _HELD:
            raise _input.refuse("analysis", f"analysis={self.analysis!r}: one of {', '.join(_HELD)}")
        held = next((name for name, kind in _HELD.items() if isinstance(self.data, kind)), None)
        if isinstance(self.data, Answer):
            held = self._answered()
        elif held is None:
            held = self._convert()
        if self.analysis not in (None, held):
            raise _input.refuse("analysis", f"analysis={self.analysis!r} beside data for slipfit.{held}")
        object.__setattr__(self, "analysis", held)
        self._entry()

    def _answered(self) -> str:
        """Which analysis gave the answer, whose data and options are used."""
        held = next((name for name, kind in _ANSWERS.items() if isinstance(self.data, kind)), None)
        if held is None:
            raise _input.refuse("data", "data is the answer to several measurements: each is needed by itself")
        if self.data._found is None:
            raise _input.refuse("data", "data is an answer from a pickle, which holds no measurement: what it was made of is needed")
        for name in ("options", "reference"):
            if getattr(self, name):
                raise _input.refuse(name, f"{name} is given beside an answer, which has its own: give the data instead")
        return held

    def _convert(self) -> str:
        """Converts arrays to a Record, a Curve or Levels."""
        data: Any = self.data
        if _input.path_like(data) or is_bytes(data):
            raise wrong_type("data", data, _DATA)
        simulated = [name for name, over in (("resonance", "frequency_hz"), ("levels", "drive_amplitude")) if _is_simulated(data, over)]
        analysis = simulated[0] if simulated else self.analysis or "ringdown"
        own = {name: self.options[name] for name in _OF_ARRAYS[analysis] if name in self.options}
        pair = data if isinstance(data, (tuple, list)) and len(data) == 2 else None
        framed = pair is None and len(getattr(data, "columns", ())) > 1
        if pair is None and not (framed or simulated or _input.is_labelled(data)):
            raise wrong_type("data", data, _DATA)
        try:
            if framed:
                words = {"unit", "drive_unit", "kind"}
                _nothing_besides({name: value for name, value in own.items() if name not in words}, "a table", "")
                held = _of_frame("data", data, _OF_FILES[analysis], **own)
            else:
                held = public(_OF_ARGUMENTS[analysis])(*(pair or (data,)), **own)
        except SlipfitError as error:
            option = "options" if error.details.get("option") in own else "data"
            raise type(error)(f"{option}: {error}", error.code, details={"option": option}) from None
        object.__setattr__(self, "data", held)
        object.__setattr__(self, "options", {name: value for name, value in self.options.items() if name not in own})
        return analysis

    def _choices(self) -> dict[str, Any]:
        choices: Callable[..., dict[str, Any]] = _levels_choices
        if isinstance(self.data, _core.Record):
            choices = _ringdown_choices
        elif isinstance(self.data, _core.Curve):
            choices = _resonance_choices
        units = {"min_amplitude": self.data.unit, "drive_amplitude": self.data.unit}
        if isinstance(self.data, _core.Levels):
            units["drive_gain"] = _gain_unit(self.data)
        try:
            options = {
                name: _input.of_samples(name, value, units[name], uncertain=name.startswith("drive")) if name in units else value
                for name, value in self.options.items()
            }
            chosen = public(choices)(**options)
            if isinstance(self.data, _core.Record):
                _check_filter(self.data, chosen)
            return chosen
        except SlipfitError as error:
            raise type(error)(f"options: {error}", error.code, details={"option": "options"}) from None
        except TypeError as error:
            analysis = choices.__name__.removeprefix("_").removesuffix("_choices")
            message = str(error).replace(f"{choices.__name__}()", f"slipfit.{analysis}()")
            raise _input.refuse("options", f"options: {message}") from None

    def _entry(self, condition_unit: str = "") -> tuple[Any, str, str, tuple[float, float] | None, float | None]:
        choices = {} if isinstance(self.data, Answer) else self._choices()
        if self.reference is not None and not isinstance(self.data, _core.Curve):
            raise _input.refuse("reference", "reference is the curve without friction of a curve, and data is none")
        measured: tuple[Any, ...] = (self.data, choices)
        if isinstance(self.data, Answer):
            measured = (self.data._found,)
        elif isinstance(self.data, _core.Curve):
            measured = (self.data, self.reference, choices)
        own = _input.unit_of_one(self.value) or ""
        if own and condition_unit and _core.unit_factor(own, condition_unit) is None:
            raise _input.refuse("value", f"a value is in {own!r} and condition_unit={condition_unit!r}")
        value = _input.pair("value", self.value, condition_unit or own)
        uncertain = value if value is None or isinstance(value, tuple) else (value, 0.0)
        if uncertain is not None and not (np.isfinite(uncertain).all() and uncertain[1] >= 0):
            raise _input.refuse("value", f"value={self.value}: finite numbers are needed, no error below zero")
        path = self.data._data["input"]["path"] if isinstance(self.data, Answer) else self.data.path
        name = self.name if self.name is not None else os.path.basename(path)
        scale = _input.optional("scale", self.scale)
        if scale is not None and not 0 < scale < float("inf"):
            raise _input.refuse("scale", f"scale={scale}: must be above zero")
        return measured, name, self.condition or _label(uncertain, condition_unit or own), uncertain, scale


setattr(Measurement, "__init__", public(Measurement.__init__))

def _label(value: tuple[float, float] | None, unit: str) -> str:
    """The label of a condition that has none, as the command gives it."""
    return "(none)" if value is None else f"{value[0]:.15g} {unit}".rstrip()


_MEASUREMENTS = (
    "several Measurements are needed, each such as slipfit.Measurement(slipfit.read(…), condition), or arrays, such as "
    "{value: (time, signal)}"
)


def _measurements(given: Any) -> list[Measurement]:
    """The measurements, made of arrays where they are arrays."""
    if _input.path_like(given) or is_bytes(given) or len(getattr(given, "columns", ())) or _input.is_labelled(given):
        raise wrong_type("measurements", given, _MEASUREMENTS)
    items = list(given.items()) if isinstance(given, Mapping) else [(None, one) for one in given]
    held = []
    for at, (condition, one) in enumerate(items):
        if _input.path_like(one) or is_bytes(one):
            raise wrong_type("measurements", given, _MEASUREMENTS)
        label: dict[str, Any] = {}
        if condition is not None:
            label = {"condition": condition} if isinstance(condition, str) else {"value": condition}
        try:
            if not isinstance(one, Measurement):
                one = Measurement(one, **label)
            elif label:
                if one.condition or one.value is not None:
                    raise _input.refuse("measurements", "it has a condition, and is given under another")
                one = replace(one, **label)
        except SlipfitError as error:
            raise type(error)(f"measurement {at + 1}: {error}", error.code, details={"option": "measurements"}) from None
        held.append(one)
    return held


def _checked(entries: list[Any]) -> list[Any]:
    """The entries, by names that differ; one label is one condition."""
    values: dict[str, tuple[float, float] | None] = {}
    names: dict[str, int] = {}
    told = []
    for measured, name, label, value, scale in entries:
        if values.setdefault(label, value) != value:
            both = " and ".join(_label(one, "") for one in (values[label], value))
            raise _input.refuse("measurements", f"condition {label!r} has the values {both}: one label is one condition")
        names[name] = names.get(name, 0) + 1
        told.append((measured, name if names[name] == 1 else f"{name} ({names[name]})", label, value, scale))
    return told


@public
def series(
    measurements: Annotated[Iterable[Any] | Mapping[Any, Any], _MEASUREMENTS],
    *,
    title: str = "",
    condition: str = "condition",
    condition_unit: str = "",
    unit: str | None = None,
    shared: Iterable[str] = (),
    stiffness: Uncertain | None = None,
    mass: Uncertain | None = None,
    torsion_stiffness: Uncertain | None = None,
    inertia: Uncertain | None = None,
) -> SeriesAnswer:
    """Analyses several measurements of one oscillator: individually, compared, and jointly.

    Parameters
    ----------
    measurements : iterable or mapping
        At least one :class:`Measurement`, or data of which one is made: ``(time, signal)``, a Record, an answer,
        a pandas Series. A mapping has their conditions as keys, numbers or labels.
    title, condition, condition_unit : str, optional
        Text of the report; `condition` is the quantity that was varied.
    unit : str, optional
        Unit of displacements in the table; that of the first measurement if not given.
    shared : iterable of str, optional
        Parameters common to all measurements: ``natural_frequency``, ``drive_amplitude``, ``decay_rate``.
    stiffness, mass, torsion_stiffness, inertia : float, quantity or (value, std_error), optional
        One of them converts displacements to forces.

    Returns
    -------
    SeriesAnswer
        One row for each condition, agreement of ring-down and resonance, friction against load.

    Raises
    ------
    OptionError
        If measurements are incompatible.

    Examples
    --------
    >>> import slipfit
    >>> swing = {"frequency_hz": 1.2, "q_factor": 80, "amplitude": 0.4, "duration_s": 40, "rate_hz": 50, "noise_rms": 5e-4}
    >>> records = [slipfit.simulate.decay(**swing, friction_displacement=x, unit="rad") for x in (1e-3, 2e-3, 3e-3)]
    >>> arrays = [(one.time_s, one.signal) for one in records]
    >>> found = slipfit.series(dict(zip((5, 10, 15), arrays)), condition="load", condition_unit="N", unit="rad")
    >>> [(row.condition, round(float(row.ringdown.friction), 4)) for row in found.table]
    [('5 N', 0.001), ('10 N', 0.002), ('15 N', 0.003)]
    """
    held = _measurements(measurements)
    if not condition_unit:
        condition_unit = next(filter(None, (_input.unit_of_one(one.value) for one in held)), "")
    entries = _checked([one._entry(condition_unit) for one in held])
    if not entries:
        raise _input.refuse("measurements", "a series needs at least one measurement")
    choices = {
        "title": title, "condition": condition, "condition_unit": condition_unit, "unit": unit,
        "shared": [shared] if isinstance(shared, str) else list(shared),
    }  # fmt: skip
    constants = _input.constants(
        {"stiffness": stiffness, "mass": mass, "torsion_stiffness": torsion_stiffness, "inertia": inertia}
    )
    return SeriesAnswer(_core.series_answer(entries, choices, constants))
