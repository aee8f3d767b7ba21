"""Answers: parameters with uncertainties, and the data they are based on."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn

import numpy as np
from numpy.typing import NDArray

from . import _core, _plot
from ._arguments import public, wrong_type
from ._errors import Hint

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from typing_extensions import Self

__all__ = [
    "Answer",
    "LevelsAnswer",
    "Parameters",
    "Quantity",
    "ResonanceAnswer",
    "RingdownAnswer",
    "Section",
    "SeriesAnswer",
    "Table",
    "Warning",
]


@dataclass(frozen=True)
class Quantity:
    """An estimated quantity.

    Attributes
    ----------
    value : float
        Best estimate within its physical limits, in `unit`.
    std_error : float
        Standard error.
    interval_95 : tuple of float
        95 % confidence interval. Asymmetric near a limit.
    unbounded_value : float
        The estimate without its limit, whose averages are unbiased.
    unit : str
        Unit in plain text; empty for a pure number.

    Notes
    -----
    A format specification applies to the two numbers, ``f"{q:.3g}"``; its fill, alignment and width apply
    to the whole text. As in the package uncertainties, ``u`` counts the digits of the standard error
    and rounds the value to the same decimal: ``f"{q:.2u}"``.

    Examples
    --------
    >>> import slipfit
    >>> q = slipfit.Quantity(0.0123456, 0.000789, (0.0108, 0.0139), 0.0123456, "rad")
    >>> f"{q}", f"{q:.3g}"
    ('0.0123456 ± 0.00079 rad', '0.0123 ± 0.000789 rad')
    >>> f"{q:.4f}", f"{q:.1e}"
    ('0.0123 ± 0.0008 rad', '1.2e-02 ± 7.9e-04 rad')
    >>> f"{q:.2u}", f"{q:>24.1u}"
    ('0.01235 ± 0.00079 rad', '     0.0123 ± 0.0008 rad')
    """

    value: float
    std_error: float
    interval_95: tuple[float, float]
    unbounded_value: float
    unit: str

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.value:.6g} ± {self.std_error:.2g}{unit}"

    def __format__(self, spec: str) -> str:
        parts = _SPECIFICATION.fullmatch(spec)
        if parts is None:
            raise ValueError(f"Invalid format specifier {spec!r} for object of type 'Quantity'")
        fill, align, sign, other, width, group, digits, kind = parts.groups("")
        unit = f" {self.unit}" if self.unit else ""
        if kind == "u":
            text = self._to_digits_of_error(sign, max(int(digits[1:] or 2), 1)) + unit
        elif kind == "s" and not digits or not (sign or other or group or digits or kind):
            text = str(self)
        else:
            number = other + group + digits + kind
            text = f"{format(self.value, sign + number)} ± {format(self.std_error, number)}{unit}"
        # Right-aligned, like numbers.
        return format(text, f"{fill}{align or '>'}{width}")

    def _to_digits_of_error(self, sign: str, digits: int) -> str:
        """Value and error, rounded to the given number of digits of the error."""
        if not (math.isfinite(self.value) and 0 < self.std_error < math.inf):
            return f"{self.value:{sign}.6g} ± {self.std_error:.2g}"
        # Rounding may carry into the next decade: 0.0996 is 0.10.
        error = float(f"{self.std_error:.{digits - 1}e}")
        decimals = digits - 1 - math.floor(math.log10(error))
        decade = math.floor(math.log10(max(abs(self.value), error)))
        if decimals >= 0 and decade > -5:
            return f"{self.value:{sign}.{decimals}f} ± {error:.{decimals}f}"
        value, error_shown = (Decimal(number).scaleb(-decade) for number in (self.value, error))
        shown = decimals + decade
        return f"({value:{sign}.{shown}f} ± {error_shown:.{shown}f})e{decade:+03}"


#: Fill, alignment, sign, other options of numbers, width, thousands, precision, type.
_SPECIFICATION = re.compile(r"(?:(.)?([<>^]))?([-+ ]?)(z?#?)([1-9]\d*)?([,_]?)(\.\d+)?([a-zA-Z%]?)", re.DOTALL)


def _item(held: Mapping[str, Any], what: str, name: object) -> Any:
    """The item of this name; the error for any other name lists the existing ones."""
    try:
        return held[name]  # type: ignore[index]
    except KeyError:
        raise KeyError(f"no {what} {name!r}; there are {', '.join(held)}") from None


class Parameters(Mapping[str, Quantity]):
    """Parameters by name, as items and as attributes.

    Which of them exist depends on the analysis; docs/json.md lists all.
    """

    __slots__ = ("_held",)

    coulomb_force: Quantity
    cubic_rate: Quantity
    power_rate_per_s: Quantity
    loss_exponent: Quantity
    stribeck_rate_per_s: Quantity
    stribeck_velocity_ratio: Quantity
    presliding_rate_per_s: Quantity
    break_amplitude_ratio: Quantity
    decay_rate_per_s: Quantity
    drag_rate: Quantity
    drive_amplitude: Quantity
    frequency_hz: Quantity
    frequency_shift_by_amplitude: Quantity
    friction_displacement: Quantity
    friction_ratio: Quantity
    initial_amplitude: Quantity
    natural_frequency_hz: Quantity
    q_factor: Quantity
    sliding_rate: Quantity
    slope: Quantity
    threshold: Quantity
    viscous_coefficient: Quantity

    def __init__(self, held: Mapping[str, Quantity]) -> None:
        self._held = dict(held)

    def __getitem__(self, name: str) -> Quantity:
        quantity: Quantity = _item(self._held, "parameter", name)
        return quantity

    def __iter__(self) -> Iterator[str]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Quantity:
            if name != "_held" and name in self._held:
                return self._held[name]
            raise AttributeError(f"no parameter {name!r} in this answer; there are {', '.join(self)}")

        def __getstate__(self) -> dict[str, Quantity]:
            return self._held

        def __setstate__(self, held: dict[str, Quantity]) -> None:
            self._held = held

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._held]

    def __repr__(self) -> str:
        return "Parameters(" + ", ".join(f"{name}={quantity}" for name, quantity in self.items()) + ")"


def _part(value: Any) -> Any:
    """A value of JSON as a copy for the caller: objects become sections, lists are copied."""
    if isinstance(value, dict):
        return _Estimate(value) if _QUANTITY <= value.keys() else Section(value)
    return [_part(one) for one in value] if isinstance(value, list) else value


class Section(Mapping[str, Any]):
    """A part of an answer: its values, including sections, as items and as attributes.

    Those that are quantities, with ``value``, ``std_error``, ``interval_95`` and ``unit``, are formatted as a
    :class:`Quantity` is, and are numbers.

    Examples
    --------
    >>> import slipfit
    >>> swing = slipfit.simulate.decay(frequency_hz=1.2, q_factor=80, friction_displacement=0.002,
    ...     amplitude=0.4, duration_s=40, rate_hz=50, unit="rad", noise_rms=5e-4)
    >>> row = slipfit.series([slipfit.Measurement(swing, "9 N")]).table[0]
    >>> friction = row.ringdown.friction
    >>> f"{row.condition}: {friction:.1e}", friction.unit, float(friction) == friction.value
    ('9 N: 2.0e-03 ± 1.8e-06 rad', 'rad', True)
    """

    __slots__ = ("_held",)

    def __init__(self, held: Mapping[str, Any]) -> None:
        self._held = {name: _part(value) for name, value in held.items()}

    def __getitem__(self, name: str) -> Any:
        return _item(self._held, "value", name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)

    def __getattr__(self, name: str) -> Any:
        if name != "_held" and name in self._held:
            return self._held[name]
        raise AttributeError(f"no {name!r} here; there are {', '.join(self)}")

    def __getstate__(self) -> dict[str, Any]:
        return self._held

    def __setstate__(self, held: dict[str, Any]) -> None:
        self._held = held

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._held]

    def __repr__(self) -> str:
        return "Section(" + ", ".join(f"{name}={value!r}" for name, value in self.items()) + ")"


#: Keys of a part that is a quantity.
_QUANTITY = frozenset(("value", "std_error", "interval_95", "unbounded_value", "unit"))


class _Estimate(Section):
    """A section that is a quantity: a number, and formatted as a :class:`Quantity` is."""

    __slots__ = ()

    def _quantity(self) -> Quantity:
        low, high = self._held["interval_95"]
        # JSON has no infinite numbers, such as a quality factor without viscous loss.
        beyond = math.inf if high is None else math.nan
        value, std_error, unbounded = (
            beyond if self._held[name] is None else float(self._held[name])
            for name in ("value", "std_error", "unbounded_value")
        )
        interval = (-math.inf if low is None else low, math.inf if high is None else high)
        return Quantity(value, std_error, interval, unbounded, self._held["unit"])

    def __float__(self) -> float:
        return self._quantity().value

    def __str__(self) -> str:
        return str(self._quantity())

    def __format__(self, spec: str) -> str:
        return format(self._quantity(), spec)


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """Whether two columns are equal; missing numbers count as equal."""
    numbers = one.dtype.kind == other.dtype.kind == "f"
    return np.array_equal(one, other, equal_nan=numbers)


class Table(Mapping[str, NDArray[Any]]):
    """Columns of equal length, as items and as attributes."""

    __slots__ = ("_columns", "_units")

    def __init__(self, columns: Mapping[str, NDArray[Any]], units: Mapping[str, str] | None = None) -> None:
        self._columns = dict(columns)
        self._units = dict(units or {})

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns, where known."""
        return dict(self._units)

    def __getitem__(self, name: str) -> NDArray[Any]:
        column: NDArray[Any] = _item(self._columns, "column", name)
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __getattr__(self, name: str) -> NDArray[Any]:
        if name not in Table.__slots__ and name in self._columns:
            return self._columns[name]
        raise AttributeError(f"no column {name!r}; there are {', '.join(self)}")

    def __getstate__(self) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
        return self._columns, self._units

    def __setstate__(self, state: tuple[dict[str, NDArray[Any]], dict[str, str]]) -> None:
        self._columns, self._units = state

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._columns]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Table):
            return NotImplemented
        same = list(self) == list(other)
        return same and all(_same(column, other[name]) for name, column in self.items())

    __hash__ = None  # type: ignore[assignment]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NoReturn:
        # NumPy, and pandas through it, would make an array of the names.
        raise wrong_type("table", self, "a column is an array, table[name]; to_dataframe() has all of them")

    def to_dataframe(self) -> pd.DataFrame:
        """The columns as a pandas DataFrame."""
        import pandas as pd

        frame = pd.DataFrame(dict(self))
        if self._units:
            frame.attrs["units"] = self.units
        return frame

    def __repr__(self) -> str:
        rows = len(next(iter(self._columns.values()), ()))
        return f"Table({rows} rows: {', '.join(self)})"


@dataclass(frozen=True)
class Warning:
    """A limitation of an answer.

    Attributes
    ----------
    code : str
        Identifier that a program can compare; docs/warnings.md explains each.
    message : str
        What was found.
    hints : tuple of Hint
        What helps.
    text : str
        All of it in words.
    """

    code: str
    message: str
    hints: tuple[Hint, ...]
    text: str

    def __str__(self) -> str:
        return self.text


def _column(values: list[Any]) -> NDArray[Any]:
    """A JSON list as an array; null among numbers becomes NaN."""
    if any(isinstance(v, str) for v in values):
        return np.array(["" if v is None else v for v in values], dtype=np.str_)
    if values and all(isinstance(v, bool) for v in values):
        return np.array(values, dtype=np.bool_)
    if values and all(isinstance(v, int) for v in values):
        return np.array(values, dtype=np.int64)
    return np.array([np.nan if v is None else v for v in values], dtype=np.float64)


def _table(columns: Mapping[str, list[Any]]) -> Table:
    return Table({name: _column(values) for name, values in columns.items()})


def _rows(rows: list[dict[str, Any]]) -> Table:
    names = list(rows[0]) if rows else []
    return Table({name: _column([row.get(name) for row in rows]) for name in names})


class Answer:
    """Base class of the answers of all analyses.

    ``print(answer)`` prints the report as in a terminal, ``to_json()`` returns the
    complete answer, the same text that ``slipfit … --json`` writes. A
    notebook shows an answer as a table.

    Two answers are equal if their JSON is. They can be copied and pickled.
    """

    def __init__(self, found: _core.Answer) -> None:
        self._found: _core.Answer | None = found
        self._held: dict[str, Any] = {}

    _PARTS = ("json", "csv", "screen", "html", "svg", "quantities", "warnings", "fit")

    def _part(self, name: str) -> Any:
        """A part of the report, computed when it is first requested."""
        if name not in self._held:
            assert self._found is not None, "a stored answer has every part"
            self._held[name] = getattr(self._found, name)()
        return self._held[name]

    @property
    def _data(self) -> dict[str, Any]:
        if "data" not in self._held:
            self._held["data"] = json.loads(self.to_json())
        data: dict[str, Any] = self._held["data"]
        return data

    def _section(self, name: str) -> Section | None:
        held = self._data[name]
        return None if held is None else Section(held)

    def __getstate__(self) -> dict[str, Any]:
        return {name: self._part(name) for name in self._PARTS}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._found = None
        self._held = dict(state)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        # An answer is immutable; arrays are returned as copies.
        return self

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Answer):
            return NotImplemented
        return self.to_json() == other.to_json()

    def __hash__(self) -> int:
        return hash(self.to_json())

    @property
    def sentence(self) -> str:
        """The answer in a sentence."""
        text: str = self._data["sentence"]
        return text

    @property
    def warnings(self) -> tuple[Warning, ...]:
        """Limitations of the answer."""
        return tuple(
            Warning(code, message, tuple(Hint(*hint) for hint in hints), text)
            for code, message, hints, text in self._part("warnings")
        )

    @property
    def fit(self) -> Table:
        """The fitted model as arrays, for drawing with the data."""
        return Table({name: values.copy() for name, values in self._part("fit").items()})

    def to_json(self) -> str:
        """The whole answer as JSON (docs/json.md), the text that the command writes."""
        text: str = self._part("json")
        return text

    def to_dict(self) -> dict[str, Any]:
        """The whole answer as a dictionary: :meth:`to_json`, parsed."""
        data: dict[str, Any] = json.loads(self.to_json())
        return data

    def to_csv(self) -> str:
        """The numbers behind the figure as CSV, the text that the command writes."""
        text: str = self._part("csv")
        return text

    def to_svg(self) -> str:
        """The figure as SVG, as the command draws it."""
        text: str = self._part("svg")
        return text

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters as a pandas DataFrame, one row per parameter."""
        raise NotImplementedError

    @public
    def plot(
        self, ax: Annotated[Axes | None, "matplotlib Axes are needed, such as plt.subplots() gives"] = None
    ) -> list[Axes]:
        """Draws data and fit with matplotlib.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw the main panel; if not given, a figure with all panels is made.

        Returns
        -------
        list of Axes
            The panels drawn.
        """
        return self._draw(ax)

    def _draw(self, ax: Axes | None) -> list[Axes]:
        raise NotImplementedError

    def __str__(self) -> str:
        text: str = self._part("screen")
        return text.rstrip("\n")

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.sentence}>"

    def _repr_html_(self) -> str:
        text: str = self._part("html")
        return text


class _Measured(Answer):
    """An answer with parameters."""

    @property
    def parameters(self) -> Parameters:
        """Parameters with uncertainties, by name."""
        return Parameters({name: Quantity(*parts) for name, *parts in self._part("quantities")})

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters as a pandas DataFrame.

        Returns
        -------
        DataFrame
            Indexed by parameter; columns value, std_error, low_95, high_95, unit.
        """
        import pandas as pd

        rows = {
            name: (q.value, q.std_error, *q.interval_95, q.unit) for name, q in self.parameters.items()
        }
        columns = ["value", "std_error", "low_95", "high_95", "unit"]
        frame = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
        return frame.rename_axis("parameter")


class _Compared(_Measured):
    """An answer that compares loss models."""

    @property
    def model(self) -> str:
        """The reported loss model."""
        name: str = self._data["model"]
        return name

    @property
    def preferred_model(self) -> str:
        """The simplest loss model that the data support, that of lowest BIC."""
        name: str = self._data["preferred_model"]
        return name

    @property
    def comparison(self) -> Table:
        """All loss models, best first."""
        return _rows(self._data["comparison"])

    @property
    def sliding(self) -> Section:
        """Evidence for sliding friction: ``detected``, ``p_value``, shares of the loss."""
        return Section(self._data["sliding"])

    @property
    def diagnostics(self) -> Section:
        """How well the model describes the data."""
        return Section(self._data["diagnostics"])

    def correlation(self, a: str, b: str) -> float | None:
        """Correlation of two estimated parameters, in either order; None if it is not reported.

        Raises
        ------
        KeyError
            For a name that is not a parameter.
        """
        pairs = self._data["correlations"]
        known = {*Parameters.__annotations__, *(name for entry in pairs for name in entry["parameters"])}
        for name in (a, b):
            if name not in known:
                raise KeyError(f"no parameter {name!r}; there are {', '.join(sorted(known))}")
        for entry in pairs:
            if set(entry["parameters"]) == {a, b}:
                value: float | None = entry["value"]
                return value
        return None


class RingdownAnswer(_Compared):
    """The answer to a free decay, see :func:`slipfit.ringdown`."""

    @property
    def envelope(self) -> Table:
        """Amplitudes along the record: time_s, amplitude, std_error, fitted, frequency_hz, used."""
        return _table(self._data["envelope"])

    @property
    def loss(self) -> Table:
        """Amplitude lost per cycle against amplitude, measured and fitted."""
        return _table(self._data["loss"])

    @property
    def free_law(self) -> Section | None:
        """The loss against amplitude without a model, if ``law`` requested it.

        ``curve`` is a table of amplitude, loss_per_cycle, low_95 and high_95; ``limit`` is the loss per
        second at vanishing amplitude (sliding), ``slope`` its slope there (viscous).
        """
        held = self._data["free_law"]
        return None if held is None else Section({**held, "curve": _table(held["curve"])})

    @property
    def segment(self) -> Section:
        """The part of the record taken as free decay, and why it starts and ends there."""
        return Section(self._data["segment"])

    @property
    def backbone(self) -> Section | None:
        """Frequency against amplitude; None for a bare envelope."""
        return self._section("backbone")

    @property
    def stop(self) -> Section | None:
        """Where and when the motion came to rest; None if the record does not show it."""
        return self._section("stop")

    @property
    def second_mode(self) -> Section | None:
        """A weaker second mode: ``frequency``, ``decay_rate``, ``amplitude``; None if there is only one mode."""
        return self._section("second_mode")

    @property
    def sensor_curve(self) -> Section | None:
        """Nonlinearity of the sensor: ``centre``, ``quadratic``, ``cubic``, ``saturation``; None if it is linear.

        It reads ``centre + x + quadratic x**2 + cubic x**3 / (1 + saturation x**2)`` for a displacement x;
        amplitude and friction displacement are those of x. Standard errors are ``cubic_std_error`` and
        ``saturation_std_error``.
        """
        return self._section("sensor_curve")

    def _draw(self, ax: Axes | None) -> list[Axes]:
        return _plot.ringdown(self, ax)


class ResonanceAnswer(_Compared):
    """The answer to a resonance curve, see :func:`slipfit.resonance`."""

    @property
    def method(self) -> Literal["exact", "leading", "paper"]:
        """How the response was computed."""
        name: Literal["exact", "leading", "paper"] = self._data["method"]
        return name

    @property
    def drive_source(self) -> Literal["known", "reference", "shape"]:
        """Source of the drive amplitude."""
        name: Literal["known", "reference", "shape"] = self._data["drive_source"]
        return name

    @property
    def curve(self) -> Table:
        """The points used and the fit, by increasing frequency."""
        return _table(self._data["curve"])

    @property
    def force(self) -> Table:
        """The force balance at each point, without a model; empty without phases."""
        return _table(self._data["force"])

    @property
    def instrument(self) -> Section:
        """Contributions of the instrument: phase offset, delay, background."""
        return Section(self._data["instrument"])

    @property
    def force_line(self) -> Section | None:
        """The line through the force balance; None without phases."""
        return self._section("force_line")

    @property
    def paper(self) -> Section | None:
        """Result of the paper's eq. (14) for the same curve, and its bias; None if it does not apply."""
        return self._section("paper")

    @property
    def reference(self) -> Section | None:
        """The friction-free curve; None if none was given."""
        return self._section("reference")

    @property
    def mean_drive(self) -> float | None:
        """Mean level of the drive that was divided out; None if there is none."""
        value: float | None = self._data["mean_drive"]
        return value

    def _draw(self, ax: Axes | None) -> list[Axes]:
        return _plot.resonance(self, ax)


class LevelsAnswer(_Measured):
    """The answer to amplitudes against drive levels, see :func:`slipfit.levels`."""

    @property
    def detected(self) -> bool:
        """Whether a threshold is detected."""
        detected: bool = self._data["detected"]
        return detected

    @property
    def p_value(self) -> float:
        """p value of the threshold, one-sided."""
        value: float = self._data["p_value"]
        return value

    def correlation(self, a: str = "slope", b: str = "threshold") -> float | None:
        """Correlation of two estimated parameters, in either order; None if it is not reported.

        Raises
        ------
        KeyError
            For a name that is not a parameter.
        """
        for name in (a, b):
            _item(dict(self.parameters), "parameter", name)
        value: float | None = self._data["correlation"]
        return value if {a, b} == {"slope", "threshold"} else None

    @property
    def levels(self) -> Table:
        """The levels and the fit, by increasing drive."""
        return _table(self._data["levels"])

    @property
    def breakaway(self) -> Section | None:
        """Level at which the mass breaks loose; None if that is not observed."""
        return self._section("breakaway")

    @property
    def diagnostics(self) -> Section:
        """How well the line describes the points."""
        return Section(self._data["diagnostics"])

    def _draw(self, ax: Axes | None) -> list[Axes]:
        return _plot.levels(self, ax)


class SeriesAnswer(Answer):
    """The answer to several measurements of one oscillator, see :func:`slipfit.series`."""

    @property
    def table(self) -> list[Section]:
        """One row per condition."""
        return [Section(row) for row in self._data["table"]]

    @property
    def measurements(self) -> list[Section]:
        """Each measurement on its own, in the order given."""
        return [Section(one) for one in self._data["measurements"]]

    @property
    def scatter(self) -> Section | None:
        """Scatter of repeated measurements beyond their errors; None if there is none."""
        return self._section("scatter")

    @property
    def joint(self) -> Section | None:
        """The joint fit; None if there is none."""
        return self._section("joint")

    @property
    def laws(self) -> list[Section]:
        """Laws of friction against the value of the condition, best first."""
        return [Section(law) for law in self._data["laws"]]

    @property
    def agreement_p_value(self) -> float | None:
        """p value of the agreement of ring-down and resonance at every condition."""
        value: float | None = self._data["agreement_p_value"]
        return value

    def to_dataframe(self) -> pd.DataFrame:
        """Friction and damping of each condition as a pandas DataFrame.

        Returns
        -------
        DataFrame
            One row per quantity, condition and kind of measurement; columns condition,
            condition_value and condition_std_error (NaN if no number was given), by, quantity, value,
            std_error, low_95, high_95, unit.

        Examples
        --------
        >>> import slipfit
        >>> swing = slipfit.simulate.decay(frequency_hz=1.2, q_factor=80, friction_displacement=0.002,
        ...     amplitude=0.4, duration_s=40, rate_hz=50, unit="rad", noise_rms=5e-4)
        >>> frame = slipfit.series([slipfit.Measurement(swing, "9 N", value=9)]).to_dataframe()
        >>> frame.loc[0, ["condition", "by", "quantity", "unit"]].tolist(), float(frame.condition_value[0])
        (['9 N', 'ringdown', 'friction', 'rad'], 9.0)
        """
        import pandas as pd

        columns = (
            "condition", "condition_value", "condition_std_error", "by", "quantity",
            "value", "std_error", "low_95", "high_95", "unit",
        )  # fmt: skip
        rows: list[tuple[Any, ...]] = []
        for row in self.table:
            at = (row.condition, *(math.nan if row[one] is None else row[one] for one in ("value", "value_std_error")))
            for kind in ("ringdown", "resonance", "joint"):
                for what in ("friction", "damping") if row[kind] is not None else ():
                    q = row[kind][what]._quantity()
                    rows.append((*at, kind, what, q.value, q.std_error, *q.interval_95, q.unit))
        return pd.DataFrame(rows, columns=list(columns))

    def _draw(self, ax: Axes | None) -> list[Axes]:
        return _plot.series(self, ax)
