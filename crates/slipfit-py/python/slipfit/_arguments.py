"""Checks the arguments of every public function against its declared types; errors name the arguments."""

from __future__ import annotations

import builtins
import collections.abc
import difflib
import functools
import inspect
import itertools
import os
import reprlib
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ParamSpec, TypeVar

import numpy as np

from . import _core
from ._errors import Hint, OptionError, OptionTypeError, SlipfitError

_P = ParamSpec("_P")
_R = TypeVar("_R")

#: Names of types in error messages.
_WORDS: dict[Any, str] = {
    str: "a text", float: "a number", int: "a whole number", bool: "True or False", dict: "a dictionary",
    bytes: "bytes", os.PathLike: "a path", collections.abc.Callable: "a function",
}  # fmt: skip

#: Names used by the libraries, and the arguments that may correspond to each.
_BEHIND: dict[str, tuple[str, ...]] = {
    "calibration": ("stiffness", "mass", "torsion_stiffness", "inertia"),
    "position": ("amplitude",),
    "displacement": ("amplitude",),
    "drive amplitude": ("drive_amplitude", "drive_amplitudes", "tone"),
    "drive frequency_hz": ("drive_frequency_hz", "frequency_hz"),
    "omega": ("frequencies_hz", "drive_frequency_hz", "frequency_hz"),
    "omega_0": ("frequency_hz", "stiffness", "mass"),
    "end_s": ("drive_off_s",),
    "time_s": ("time",),
    "interval_s": ("dt",),
    "frequency_hz": ("frequency", "frequencies_hz"),
    "amplitude": ("response", "drive_amplitude"),
    "real": ("response",),
    "imaginary": ("response",),
    "source": ("time", "frequency", "drive", "reference"),
    "table": ("stack",),
}


#: Names used by other libraries, and the arguments that they stand for.
_ALIASES = {
    **dict.fromkeys(("fs", "sr", "samplerate", "sample_rate", "sampling_rate", "sampling_frequency"), ("rate_hz", "")),
    "dt": ("rate_hz", "=1/dt"),
    "fmin": ("band_hz", ""),
    "fmax": ("band_hz", ""),
    "k": ("stiffness", ""),
    "m": ("mass", ""),
}


@dataclass(frozen=True)
class _Named:
    """A class of a package that is imported only where its objects come from."""

    name: str

    def __getattr__(self, name: str) -> _Named:
        return _Named(f"{self.name}.{name}")

    def __or__(self, other: Any) -> Any:
        return typing.Union[typing.ForwardRef(self.name), other]

    def __ror__(self, other: Any) -> Any:
        return typing.Union[other, typing.ForwardRef(self.name)]


class _Names(dict[str, Any]):
    """Names in annotations; a name that a module does not import stands for itself."""

    def __init__(self, module: Mapping[str, Any]) -> None:
        # Arrays are checked when they are converted.
        super().__init__({"ArrayLike": object})
        self._module = module

    def __missing__(self, name: str) -> Any:
        if name in self._module or hasattr(builtins, name):
            raise KeyError(name)
        return _Named(name)


def _alternatives(annotation: Any) -> tuple[Any, ...]:
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        return tuple(kind for one in typing.get_args(annotation) for kind in _alternatives(one))
    if typing.get_origin(annotation) is typing.Literal:
        return tuple(dict.fromkeys(type(word) for word in typing.get_args(annotation)))
    # A number is anything that can be converted to one.
    return (float,) if annotation is typing.SupportsFloat else (annotation,)


def _is_number(value: Any) -> bool:
    # NumPy would convert a text, or a duration in whatever unit it counts.
    if getattr(value, "ndim", 0) or isinstance(value, bool):
        return False
    return hasattr(type(value), "__float__") and getattr(getattr(value, "dtype", None), "kind", "f") in "iuf"


def _is_pair(value: Any) -> bool:
    # Each character of a text would be a number.
    if isinstance(value, (str, bytes, set, Mapping)) or not isinstance(value, Iterable):
        return False
    held = getattr(value, "__len__", lambda: 0)() if getattr(value, "ndim", 1) else 0
    return held == 2 and all(map(_is_number, value))


def _are(value: Any, kinds: tuple[Any, ...]) -> bool:
    """Whether this is iterable and, as far as can be checked, holds items of these types."""
    if isinstance(value, (bytes, bytearray, memoryview)) or not isinstance(value, Iterable):
        return False
    if getattr(value, "ndim", 1) != 1:
        return False
    return not isinstance(value, (list, tuple, set, np.ndarray)) or all(_is(one, kinds) for one in value)


def _is(value: Any, kinds: tuple[Any, ...]) -> bool:
    return any(_is_one(value, kind) for kind in kinds)


def _is_one(value: Any, kind: Any) -> bool:
    if kind in (Any, object):
        return True
    if kind is float:
        return _is_number(value)
    if kind is int:
        return hasattr(type(value), "__index__") and not getattr(value, "ndim", 0) and not isinstance(value, bool)
    if kind is bool:
        return isinstance(value, bool) or getattr(getattr(value, "dtype", None), "kind", "") == "b"
    if isinstance(kind, (_Named, typing.ForwardRef)):
        name = kind.name if isinstance(kind, _Named) else kind.__forward_arg__
        return any(base.__name__ == name.rpartition(".")[2] for base in type(value).__mro__)
    origin = typing.get_origin(kind)
    if origin is tuple:
        return _is_pair(value)
    if origin in (collections.abc.Sequence, collections.abc.Iterable):
        return _are(value, _alternatives(typing.get_args(kind)[0]))
    return isinstance(value, origin or kind)


def _words(kinds: Iterable[Any]) -> str:
    """Description of what is needed, such as `a number or a text`."""
    held = [kind for kind in kinds if kind is not type(None)]
    plain = [typing.get_origin(kind) or kind for kind in held]
    if tuple in plain and float in plain:
        return "a number, or a number and its standard error"
    if tuple in plain:
        return "two frequencies, the lower one first"
    if bytes in plain:
        held = [kind for kind in held if kind not in (bytearray, memoryview)]
    if os.PathLike in plain:
        held = [kind for kind in held if kind is not str]
    words = []
    for kind in held:
        origin = typing.get_origin(kind) or kind
        if origin in (collections.abc.Sequence, collections.abc.Iterable):
            inner = _alternatives(typing.get_args(kind)[0])
            several = {str: "texts"}.get(inner[0], f"{getattr(inner[0], '__name__', '')}s")
            words.append("several paths" if any(_is_path(one) for one in inner) else f"several {several}")
        elif isinstance(kind, (_Named, typing.ForwardRef)):
            words.append(f"a {kind.name if isinstance(kind, _Named) else kind.__forward_arg__}")
        else:
            words.append(_WORDS.get(origin) or f"a {origin.__name__}")
    words = list(dict.fromkeys(words))
    verb = "are" if words[-1].startswith("several") else "is"
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words) + f" {verb} needed"


def _is_path(kind: Any) -> bool:
    return (typing.get_origin(kind) or kind) is os.PathLike


def shown(value: Any) -> str:
    """A value as it was written, shortened if it is long; anything without a short form by its type."""
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes, list, tuple, dict, set)):
        try:
            return " ".join(_SHORT.repr(value).split())
        except ValueError:
            # More digits than Python prints.
            pass
    return f"<{type(value).__name__}>"


_SHORT = reprlib.Repr()
_SHORT.maxstring, _SHORT.maxother, _SHORT.maxlevel = 60, 40, 2
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = 4


def wrong_type(option: str, value: Any, needed: str) -> OptionTypeError:
    """The exception for an argument of the wrong type."""
    if hasattr(value, "getvalue"):
        needed = f"{needed}: give its bytes, {option}.getvalue()"
    elif callable(getattr(value, "read", None)):
        needed = f"{needed}: give its bytes, {option}.read()"
    return OptionTypeError(
        f"{option}={shown(value)}: {needed}", "type", details={"option": option, "value": value}
    )


def _check_letters(option: str, value: Any, encode: Callable[[str], bytes]) -> None:
    """Refuses text with an incomplete character, which no library accepts; a path may hold any byte."""
    if isinstance(value, (list, tuple)):
        # Longer ones are samples.
        for one in value[:64]:
            _check_letters(option, one, encode)
    elif isinstance(value, str) and not value.isascii():
        try:
            encode(value)
        except UnicodeEncodeError as error:
            message = f"{option}={shown(value)}: {error.reason}"
            raise OptionError(message, "option", details={"option": option, "value": value}) from None


def _plain(kinds: tuple[Any, ...]) -> frozenset[type]:
    """Types that need no further check."""
    if object in kinds or Any in kinds:
        return frozenset((np.ndarray,))
    return frozenset(kind for kind in kinds if isinstance(kind, type) and kind is not str)


class _Function:
    """Parameters of a function, and the types each may have."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.name = function.__name__
        self.parameters = inspect.signature(function).parameters
        module = function.__globals__
        names = _Names(module)
        self.kinds: dict[str, tuple[Any, ...]] = {}
        self.words: dict[str, str] = {}
        for name, parameter in self.parameters.items():
            if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
                continue
            annotation = parameter.annotation
            if isinstance(annotation, str):
                annotation = eval(annotation, module, names)
            if typing.get_origin(annotation) is typing.Annotated:
                annotation, self.words[name] = typing.get_args(annotation)
            self.kinds[name] = (object,) if annotation is parameter.empty else _alternatives(annotation)
        self.order = tuple(self.kinds)
        self.takes_any = any(one.kind is one.VAR_KEYWORD for one in self.parameters.values())
        # Types that need no further check.
        self.plain = {name: _plain(kinds) for name, kinds in self.kinds.items()}

    def check(self, given: Iterable[tuple[str, Any]]) -> None:
        """Refuses arguments of another type than declared."""
        plain = self.plain
        for name, value in given:
            if name in plain and type(value) not in plain[name]:
                self._look(name, value)

    def check_names(self, given: Iterable[str]) -> None:
        """Refuses an unknown argument and suggests the one that may be meant."""
        if self.takes_any:
            return
        for name in given:
            if name not in self.parameters:
                near = self._near(name)
                meant = f"; did you mean {near}?" if near else ""
                raise TypeError(f"{self.name}() got an unexpected keyword argument {name!r}{meant}")

    def _near(self, name: str) -> str | None:
        near = [own for own in self.parameters if own.startswith(f"{name}_") or own == name.removesuffix("s")]
        alias = _ALIASES.get(name.lower(), ("", ""))
        if not near and alias[0] in self.parameters:
            return "".join(alias)
        if not near and "dt" in self.parameters and "rate_hz" in (name, alias[0]):
            return f"dt=1/{name}"
        near = near or difflib.get_close_matches(name, self.parameters, 1)
        return near[0] if near else None

    def _look(self, name: str, value: Any) -> None:
        kinds = self.kinds[name]
        if not _is(value, kinds):
            raise wrong_type(name, value, self.words.get(name) or _words(kinds))
        if isinstance(value, (str, list, tuple)):
            path = any(_is_path(kind) or kind in (object, Any) for kind in kinds)
            _check_letters(name, value, os.fsencode if path else str.encode)

    def behind(self, option: str, given: Mapping[str, Any]) -> str | None:
        """The argument that a name of the libraries stands for; one that was given takes precedence."""
        if option in self.parameters or option in given:
            return option
        names = _BEHIND.get(option.removesuffix(" std_error"), (option.removesuffix(" std_error"),))
        if self.takes_any:
            return next((name for name in names if name in given), option)
        known = [name for name in names if name in self.parameters]
        if option not in ("amplitude", "source"):
            known.sort(key=lambda name: given.get(name) is None)
        return known[0] if known else None

    def retell(self, error: SlipfitError, given: Mapping[str, Any]) -> None:
        """Rewrites an error for this call: its option and hints name arguments, its value is the one given."""
        details, message = dict(error.details), error.message
        option = details.get("option")
        if option is None and "column" in details:
            option = next((name for name, value in given.items() if _names(value, details["column"])), None)
        if option is not None:
            # An option of one of several measurements is an argument of that measurement only.
            own = self.behind(option, given) or ("measurements" if "measurements" in self.parameters else None)
            if own not in (None, option):
                if option.startswith("omega"):
                    # The value in the message is not the one that was given.
                    message = f"{own}={shown(given.get(own))}: {message}"
                elif message.startswith((f"{option} =", f"{option} is ", f"{option} has ", f"{option}:")):
                    message = f"{own}{message[len(option) :]}"
            details["option"] = own
            if own is not None and (own != option or "value" not in details):
                details["value"] = given.get(own)
        hints = [hint for hint in (self._hint(one, given) for one in error.hints) if hint is not None]
        error.__init__(  # type: ignore[misc]
            message,
            error.code,
            [(one.option, one.value, one.advice, one.text) for one in hints],
            together(hints) if error.hints else error.advice,
            details,
        )

    def _hint(self, hint: Hint, given: Mapping[str, Any]) -> Hint | None:
        """The hint as it applies to this call; None if it does not."""
        if hint.option is None or self.takes_any:
            return hint
        own = self.behind(hint.option, given) if hint.option not in _COLUMNS else hint.option
        read_before = hint.option in _OF_READING and isinstance(given.get(self.order[0]), _READINGS)
        if not read_before and own in self.kinds and object not in self.kinds[own] and Any not in self.kinds[own]:
            return hint if own == hint.option else replace(hint, option=own, text=own + hint.text[len(hint.option) :])
        # Only a file has columns and units to choose.
        reader = _READERS.get(self.name)
        if reader is None or not _is_read(given.get(self.order[0])):
            return None
        before = _before(hint)
        told = f"{before}=…" if before == hint.option else before
        return replace(hint, option=None, text=f"slipfit.{reader}(…, {told}) {hint.advice}")


_READINGS = (_core.Record, _core.Curve, _core.Levels)

#: Functions that read the files of each analysis.
_READERS = {
    "ringdown": "read", "resonance": "read_curve", "fit_resonance": "read_curve", "levels": "read_levels",
}  # fmt: skip

#: Columns of files whose names are also those of array arguments.
_COLUMNS = frozenset(
    ("time", "signal", "quadrature", "frequency", "amplitude", "phase", "real", "imaginary", "std_error", "drive")
)

#: Options that are fixed once a Record, a Curve or Levels has been read.
_OF_READING = frozenset(("rate_hz", "unit", "kind"))


def is_bytes(source: Any) -> bool:
    """Whether these are the bytes of a file; a view of larger numbers is an array."""
    if isinstance(source, memoryview):
        return source.format in ("B", "b", "c")
    return isinstance(source, (bytes, bytearray))


def _is_read(source: Any) -> bool:
    """Whether this is a file or was read from one."""
    if isinstance(source, (list, tuple)):
        return bool(source) and _is_read(source[0])
    return isinstance(source, (str, os.PathLike)) or is_bytes(source) or isinstance(source, _READINGS) and source.path != "arrays"


def _names(value: Any, column: str) -> bool:
    # Arrays, which a list may hold, cannot be compared with a text.
    names = value if isinstance(value, (list, tuple)) else (value,)
    return any(isinstance(one, str) and one == column for one in names)


def _before(hint: Hint) -> str:
    """The part of a hint before its advice: the option with its value."""
    return hint.text.removesuffix(hint.advice).rstrip()


def together(hints: Iterable[Hint]) -> str:
    """Several hints as one sentence; hints with the same advice are alternatives."""
    sentences = []
    for advice, group in itertools.groupby(hints, lambda hint: hint.advice):
        options = " or ".join(filter(None, map(_before, group)))
        sentences.append(f"{options} {advice}" if options else advice)
    return "; ".join(sentences)


def check(function: Callable[..., Any], given: Mapping[str, Any]) -> None:
    """Refuses arguments that a public function would refuse for their name or type."""
    inspect.signature(function).bind_partial(**given)
    _Function(inspect.unwrap(function)).check(given.items())


def public(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Checks the types of arguments by their annotations, and words errors in terms of the call."""
    found: list[_Function] = []

    def described() -> _Function:
        if not found:
            found.append(_Function(function))
        return found[0]

    @functools.wraps(function)
    def called(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        known = found[0] if found else described()
        known.check(zip(known.order, args))
        known.check(kwargs.items())
        known.check_names(kwargs)
        try:
            return function(*args, **kwargs)
        except SlipfitError as error:
            known.retell(error, dict(zip(known.order, args)) | kwargs)
            raise

    return called
