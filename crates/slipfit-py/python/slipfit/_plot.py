"""Answers as matplotlib axes, with the panels of the command's figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._answers import LevelsAnswer, ResonanceAnswer, RingdownAnswer, SeriesAnswer

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
    """Amplitude over time; signal, loss per cycle and frequency beside it."""
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
    axes[2].plot(loss["amplitude"][order], loss["fitted_sliding"][order], label="of it sliding", **_FREE)
    axes[2].set(xlabel=_unit("amplitude", unit), ylabel=_unit("loss per cycle", unit))
    axes[2].legend()
    if with_frequency:
        used = envelope["used"]
        axes[3].plot(envelope["amplitude"][used], envelope["frequency_hz"][used], **_DOTS)
        axes[3].set(xlabel=_unit("amplitude", unit), ylabel="frequency [Hz]")
    axes[0].figure.suptitle(answer.sentence, fontsize=9, wrap=True)
    return axes


def resonance(answer: ResonanceAnswer, ax: Axes | None) -> list[Axes]:
    """Amplitude over frequency, and the phase where there is one."""
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
    """Amplitude over the level of the drive."""
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
    """Friction of each condition; damping beside it."""
    rows = answer.table
    axes = [ax] if ax is not None else _panels(2)
    labels = [row["condition"] for row in rows]
    for axis, what in zip(axes, ("friction", "damping")):
        unit = ""
        for shift, kind in enumerate(("ringdown", "resonance", "joint")):
            found = [(i, row[kind][what]) for i, row in enumerate(rows) if row[kind] is not None]
            if not found:
                continue
            unit = found[0][1]["unit"]
            axis.errorbar(
                [i + 0.12 * (shift - 1) for i, _ in found],
                [q["value"] for _, q in found],
                yerr=[q["std_error"] or 0.0 for _, q in found],
                fmt="o", markersize=4.0, label=kind,
            )
        axis.set_xticks(range(len(labels)), labels)
        axis.set(ylabel=_unit(what, unit))
        axis.legend()
    return axes
