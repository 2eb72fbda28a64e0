"""How gearfem fails: the input cannot be used, an effect is not written as it must be, or a solve did not succeed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    """Input that cannot be used, said in one line: where, what was found, what is allowed.

    Parameters
    ----------
    where : str
        Key, row or argument, in the words of the user ("pinion.bore_radius_mm", "row 7, column x_mm").
    found : object
        What was found there.
    allowed : str
        What is allowed, with its unit, and the remedy where one is known.
    file : str, optional
        File that holds the key; a reader that knows it adds it by `in_file`.
    """

    def __init__(self, where: str, found: object, allowed: str, file: str | None = None) -> None:
        self.where, self.found, self.allowed, self.file = where, found, allowed, file
        place = f"{file}: {where}" if file else where
        super().__init__(f"{place}: found {found}; allowed: {allowed}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str, str | None]]:
        """Return how to make it again: errors travel between processes."""
        return InputError, (self.where, self.found, self.allowed, self.file)

    def in_file(self, file: str) -> InputError:
        """Return the same error with the name of the file in front.

        Parameters
        ----------
        file : str
            Path as the user gave it.

        Returns
        -------
        InputError
            A new error; one that names a file already keeps it.
        """
        return self if self.file else InputError(self.where, self.found, self.allowed, file)


def not_utf8(error: UnicodeDecodeError, kind: str, file: str) -> InputError:
    """Return how text is refused that is in no UTF-8, by the line of its first wrong byte.

    Parameters
    ----------
    error : UnicodeDecodeError
        Of a whole file.
    kind, file : str
        Of the text ("CSV"), and its name.
    """
    line, wrong = error.object[: error.start].count(b"\n") + 1, error.object[error.start]
    return InputError(f"line {line}", f"the byte 0x{wrong:02x}, which is not UTF-8", f"{kind} text in UTF-8, no other encoding", file)


def nearest(word: str, names: Iterable[str]) -> str:
    """Return what is allowed where a name is none: the nearest valid one, one that holds the word, or all where none is near.

    Parameters
    ----------
    word : str
        As found.
    names : iterable of str
        The valid ones.
    """
    names = list(names)
    close = difflib.get_close_matches(word, names, n=1) or [name for name in names if len(word) > 2 and word in name]
    return f"{close[0]} (the nearest valid name)" if close else ", ".join(names)


class EffectError(Exception):
    """An effect whose code fails; the message names it. Unlike a place without a model it is never passed over in a search."""


class SolveError(RuntimeError):
    """A computation that did not reach its tolerance; the message says which, and what to try."""


# What a model raises where it is moved to a place at which there is none: beyond bounds, unsolved, or no longer finite.
UNCOMPUTABLE = (InputError, SolveError, FloatingPointError)
