"""Answers as matplotlib axes, with the panels of the command's figures; data that were read as axes and frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from . import _input
from ._arguments import public

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from ._answers import LevelsAnswer, ResonanceAnswer, RingdownAnswer, SeriesAnswer
    from ._core import Curve, Levels, Record

_DATA: dict[str, Any] = {"color": "0.55", "linewidth": 0.6}
_DOTS: dict[str, Any] = {"color": "0.35", "markersize": 3.0, "linestyle": "none", "marker": "o"}
_FIT: dict[str, Any] = {"color": "C3", "linewidth": 1.4}
_FREE: dict[str, Any] = {"color": "0.5", "linewidth": 1.0, "linestyle": "--"}


def _panels(count: int) -> list[Axes]:
    import matplotlib.pyplot as plt

    columns = min(count, 2)
    _, grid = plt.subplots(
        -(-count // columns), columns, figsize=(5.2 * columns, 3.4 * -(-count // columns)),
        squeeze=False, layout="constrained",
    )
    panels: list[Axes] = list(grid.flat)
    return panels


def _unit(label: str, unit: str) -> str:
    return f"{label} [{unit}]" if unit else label


def _amplitude_over_time(ax: Axes, answer: RingdownAnswer, unit: str) -> None:
    envelope = answer.envelope
    used = envelope["used"]
    for chosen, alpha, label in ((used, 1.0, "measured"), (~used, 0.35, "not used")):
        if chosen.any():
            ax.plot(envelope["time_s"][chosen], envelope["amplitude"][chosen], alpha=alpha, label=label, **_DOTS)
    ax.plot(envelope["time_s"][used], envelope["fitted"][used], label=answer.model, **_FIT)
    if (envelope["amplitude"][used] > 0).any():
        ax.set_yscale("log")
    ax.set(xlabel="time [s]", ylabel=_unit("amplitude", unit))
    ax.legend()


def ringdown(answer: RingdownAnswer, ax: Axes | None) -> list[Axes]:
    """Amplitude over time, with signal, loss per cycle and frequency."""
    unit = answer.to_dict()["input"]["unit"]
    if ax is not None:
        _amplitude_over_time(ax, answer, unit)
        return [ax]
    envelope, loss, fit = answer.envelope, answer.loss, answer.fit
    with_frequency = bool(np.isfinite(envelope["frequency_hz"]).any())
    axes = _panels(4 if with_frequency else 3)
    _amplitude_over_time(axes[0], answer, unit)
    axes[1].plot(fit["time_s"], fit["signal"], **_DATA)
    axes[1].plot(fit["time_s"], fit["fitted"], color="C3", linewidth=0.5)
    axes[1].set(xlabel="time [s]", ylabel=_unit("signal", unit))
    order = np.argsort(loss["amplitude"])
    axes[2].errorbar(
        loss["amplitude"], loss["loss_per_cycle"], yerr=loss["std_error"],
        fmt="o", color="0.35", markersize=3.0, elinewidth=0.6, label="measured",
    )
    axes[2].plot(loss["amplitude"][order], loss["fitted"][order], label=answer.model, **_FIT)
    axes[2].plot(loss["amplitude"][order], loss["fitted_sliding"][order], label="sliding part", **_FREE)
    axes[2].set(xlabel=_unit("amplitude", unit), ylabel=_unit("loss per cycle", unit))
    axes[2].legend()
    if with_frequency:
        used = envelope["used"]
        axes[3].plot(envelope["amplitude"][used], envelope["frequency_hz"][used], **_DOTS)
        axes[3].set(xlabel=_unit("amplitude", unit), ylabel="frequency [Hz]")
    axes[0].figure.suptitle(answer.sentence, fontsize=9, wrap=True)
    return axes


def resonance(answer: ResonanceAnswer, ax: Axes | None) -> list[Axes]:
    """Amplitude over frequency, and the phase if there is one."""
    unit = answer.to_dict()["input"]["unit"]
    curve, fit = answer.curve, answer.fit
    with_phase = bool(np.isfinite(curve["phase_rad"]).any())
    axes = [ax] if ax is not None else _panels(2 if with_phase else 1)
    axes[0].plot(curve["frequency_hz"], curve["amplitude"], label="measured", **_DOTS)
    axes[0].plot(fit["frequency_hz"], fit["amplitude"], label=answer.model, **_FIT)
    axes[0].plot(fit["frequency_hz"], fit["friction_free"], label="without friction", **_FREE)
    axes[0].set(xlabel="frequency [Hz]", ylabel=_unit("amplitude", unit))
    axes[0].legend()
    if len(axes) > 1:
        axes[1].plot(curve["frequency_hz"], np.unwrap(curve["phase_rad"]), **_DOTS)
        axes[1].plot(fit["frequency_hz"], np.unwrap(fit["phase_rad"]), **_FIT)
        axes[1].set(xlabel="frequency [Hz]", ylabel="phase [rad]")
    return axes


def levels(answer: LevelsAnswer, ax: Axes | None) -> list[Axes]:
    """Amplitude against drive level."""
    data = answer.to_dict()["input"]
    axes = [ax] if ax is not None else _panels(1)
    points, fit = answer.levels, answer.fit
    axes[0].plot(points["drive"], points["amplitude"], label="measured", **_DOTS)
    axes[0].plot(fit["drive"], fit["amplitude"], label="fit", **_FIT)
    axes[0].plot(fit["drive"], fit["friction_free"], label="without friction", **_FREE)
    axes[0].set(xlabel=_unit("drive", data["drive_unit"]), ylabel=_unit("amplitude", data["unit"]))
    axes[0].legend()
    return axes


def series(answer: SeriesAnswer, ax: Axes | None) -> list[Axes]:
    """Friction and damping of each condition, over its number if every condition has one."""
    rows, heading = answer.table, answer.to_dict()
    axes = [ax] if ax is not None else _panels(2)
    labels = [row.condition for row in rows]
    numbers = [row.value for row in rows]
    numbered = None not in numbers and len(set(numbers)) == len(numbers) > 1
    places = np.array(numbers if numbered else range(len(rows)), dtype=float)
    aside = 0.0 if numbered else 0.12
    for axis, what in zip(axes, ("friction", "damping")):
        unit = ""
        for shift, kind in enumerate(("ringdown", "resonance", "joint")):
            found = [(at, row, row[kind][what]) for at, row in zip(places, rows) if row[kind] is not None]
            if not found:
                continue
            unit = found[0][2].unit
            axis.errorbar(
                [at + aside * (shift - 1) for at, _, _ in found],
                [float(q) for _, _, q in found],
                yerr=[q.std_error or 0.0 for _, _, q in found],
                xerr=[row.value_std_error or 0.0 for _, row, _ in found] if numbered else None,
                # At the same position, the joint fit is a ring around the others.
                fmt="o", markersize=9.0 if kind == "joint" else 4.0, label=kind,
                markerfacecolor="none" if kind == "joint" else None,
            )
        if not numbered:
            axis.set_xticks(range(len(labels)), labels)
        axis.set(xlabel=_unit(heading["condition"], heading["condition_unit"] if numbered else ""))
        axis.set(ylabel=_unit(what, unit))
        axis.legend()
    if ax is None:
        axes[0].figure.suptitle(answer.sentence, fontsize=9, wrap=True)
    return axes


#: Fraction of a pixel's side covered by the grey core of a pixel with a warning, as in the command's figure.
_CORE = 0.5
#: Fraction of the values that lies beyond either end of the colour scale.
_OUTSIDE = 0.01
#: Warnings of traces that do not determine their numbers.
_UNDETERMINED = frozenset(("not_converged", "not_separable"))


def _edges(found: xarray.Dataset, name: Any) -> tuple[NDArray[Any], str]:
    """Edges of the pixels of a dimension, and its label: from its coordinate if that is monotonic."""
    count, label, at = found.sizes[name], str(name), None
    if name in found.coords and found.coords[name].dtype.kind in "fiu":
        held = found.coords[name].to_numpy().astype(float)
        steps = np.diff(held)
        if (steps > 0).all() or (steps < 0).all():
            at, label = held, _unit(label, _input.own_unit(found.coords[name]) or "")
    at = np.arange(count, dtype=float) if at is None else at
    half = np.diff(at) / 2 if count > 1 else np.array([0.5])
    return np.concatenate([[at[0] - half[0]], at + np.append(half, half[-1])[:count]]), label


def _image(ax: Axes, found: xarray.Dataset, name: str) -> None:
    """One column of a map with its colours."""
    from matplotlib.collections import PolyCollection

    rows, columns = found[name].dims
    (y, y_label), (x, x_label) = _edges(found, rows), _edges(found, columns)
    codes = np.vectorize(lambda reason: not _UNDETERMINED.isdisjoint(str(reason).split(" ")), otypes=[bool])
    values = np.where(codes(found["reason"].to_numpy()), np.nan, found[name].to_numpy().astype(float))
    known = np.isfinite(values)
    # Warnings of a whole analysis concern effects that its numbers account for.
    doubtful = (found["status"].to_numpy() != "done") & (found.attrs.get("method") != "analyse")
    scale = values[known & ~doubtful] if (known & ~doubtful).any() else values[known]
    low, high = np.quantile(scale, [_OUTSIDE, 1 - _OUTSIDE], method="nearest") if scale.size else (None, None)
    ax.set_facecolor("0.8")
    colours = ax.pcolormesh(x, y, np.ma.masked_invalid(values), vmin=low, vmax=high)
    ax.figure.colorbar(colours, ax=ax, label=_unit(name, str(found[name].attrs.get("units", ""))), extend="both")
    at = np.argwhere(known & doubtful)
    corners = [((1 - _CORE) / 2, (1 + _CORE) / 2)[side] for side in (0, 1)]
    left, right = (x[at[:, 1]] + part * (x[at[:, 1] + 1] - x[at[:, 1]]) for part in corners)
    low_y, high_y = (y[at[:, 0]] + part * (y[at[:, 0] + 1] - y[at[:, 0]]) for part in corners)
    cores = np.stack([np.stack(c, -1) for c in ((left, low_y), (right, low_y), (right, high_y), (left, high_y))], 1)
    ax.add_collection(PolyCollection(list(cores), facecolors="0.8", linewidths=0), autolim=False)
    ax.set(xlabel=x_label, ylabel=y_label)


@public
def plot_map(
    found: xarray.Dataset,
    column: str | None = None,
    ax: Annotated[Axes | None, "matplotlib Axes are needed, such as plt.subplots() gives"] = None,
) -> list[Axes]:
    """Draws a map with matplotlib; doubtful pixels are marked as in the command's figure.

    Pixels with a warning have a grey core and do not affect the colour scale; those without an answer, or whose
    trace determines none (``not_converged``, ``not_separable``), are grey. The colour scale leaves out one value
    in a hundred at either end.

    Parameters
    ----------
    found : xarray.Dataset
        The map, from :func:`fit_map` or read back from a file.
    column : str, optional
        What is drawn; by default friction (as a displacement if there is one) and the decay rate.
    ax : matplotlib Axes, optional
        Where to draw `column`; if not given, a figure is made.

    Returns
    -------
    list of Axes
        The panels drawn.

    Raises
    ------
    OptionError
        For a data set that is not a map, or a column that it does not have.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> t = 0.01 * np.arange(200)
    >>> stack = 1 - np.array([[0.1, 0.2], [0.3, 0.7]])[..., None] * t
    >>> found = slipfit.fit_map(stack, dt=0.01)
    >>> [panel.get_xlabel() for panel in slipfit.plot_map(found)]
    ['x', 'x']
    """
    numbers = [str(name) for name, one in found.data_vars.items() if one.dtype.kind == "f" and one.ndim == 2]
    if not numbers or "status" not in found or "reason" not in found:
        raise _input.refuse("found", "found is no map: status, reason and numbers over two dimensions are needed")
    if column is not None and column not in numbers:
        raise _input.refuse("column", f"column={column!r}: there are {', '.join(numbers)}")
    if ax is not None and column is None:
        raise _input.refuse("column", "ax is given without column: one picture is drawn there")
    known = [name for name in ("friction_displacement", "sliding_rate") if bool(found[name].notnull().any())]
    names = [column] if column is not None else [*(known or ["sliding_rate"])[:1], "decay_rate_per_s"]
    axes = [ax] if ax is not None else _panels(len(names))
    for axis, name in zip(axes, names):
        _image(axis, found, name)
    return axes


def frame_of(read: Record | Curve | Levels) -> pd.DataFrame:
    """The data that were read, one row per sample or point, with units in the column names."""
    import pandas as pd

    return pd.DataFrame({f"{name} ({unit})" if unit else name: values for name, unit, values in read._columns()})


@public
def plot_read(
    read: Record | Curve | Levels,
    ax: Annotated[Axes | None, "matplotlib Axes are needed, such as plt.subplots() gives"] = None,
) -> list[Axes]:
    """Draws the other columns of the data over the first."""
    (over, over_unit, at), *others = read._columns()
    axes = [ax] if ax is not None else _panels(len(others))
    style = _DATA if over == "time" else _DOTS
    for panel, (name, unit, values) in zip(axes, others):
        panel.plot(at, values, **style)
        panel.set(xlabel=_unit(over, over_unit), ylabel=_unit(name, unit))
    return axes
