"""Exceptions and the hints they carry."""

from __future__ import annotations

import errno
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Hint:
    """A hint on what helps against a warning or an error.

    Attributes
    ----------
    option : str or None
        The keyword argument that helps; None if none does.
    value : float, tuple of float, str or None
        A value to give it, if one is known.
    advice : str
        What it does.
    text : str
        All of it in words, ``band_hz=(79, 82) isolates the first``.
    """

    option: str | None
    value: float | tuple[float, float] | str | None
    advice: str
    text: str

    def __str__(self) -> str:
        return self.text


class SlipfitError(Exception):
    """Something that could not be done.

    Attributes
    ----------
    message : str
        What is wrong, without hints.
    code : str
        Kind of the error, as a word that a program can compare: ``not_a_ring_down``.
    hints : tuple of Hint
        What helps; may be empty.
    details : dict
        The values that explain the error, such as ``option`` and ``value``; each is also an
        attribute of the exception.
    """

    def __init__(
        self,
        message: str,
        code: str = "",
        hints: Iterable[tuple[Any, Any, str, str]] = (),
        advice: str = "",
        details: Mapping[str, Any] | None = None,
    ) -> None:
        hints = tuple(hints)
        details = dict(details or {})
        # Pickle passes these to the constructor.
        super().__init__(message, code, hints, advice, details)
        self.message = message
        self.code = code
        self.hints = tuple(Hint(*parts) for parts in hints)
        self.advice = advice
        self.details = details

    def __getattr__(self, name: str) -> Any:
        details = self.__dict__.get("details", {})
        if name in details:
            return details[name]
        raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")

    def __str__(self) -> str:
        return f"{self.message}\n  hint: {self.advice}" if self.advice else self.message


class OptionError(SlipfitError, ValueError):
    """An invalid value or array; ``option`` names the argument, ``value`` is what was given."""


class OptionTypeError(OptionError, TypeError):
    """An argument of the wrong type; ``option`` names it, ``value`` is what was given."""


class ReadError(SlipfitError, ValueError):
    """A file that could not be read; ``file`` and ``row`` say where."""


class FolderError(IsADirectoryError, ReadError):
    """A folder where a file is needed; ``file`` and ``filename`` name it."""

    def __init__(
        self,
        message: str,
        code: str = "folder",
        hints: Iterable[tuple[Any, Any, str, str]] = (),
        advice: str = "",
        details: Mapping[str, Any] | None = None,
    ) -> None:
        SlipfitError.__init__(self, message, code, hints, advice, details)
        self.errno, self.strerror = errno.EISDIR, "this is a folder"
        self.filename = self.details.get("file")

    def __str__(self) -> str:
        return SlipfitError.__str__(self)


class NoAnswerError(SlipfitError, ValueError):
    """Data from which nothing can be computed: no oscillation, no decay, no resonance."""
