"""What a user asks for: which scans, which work, where the results go, within which limits."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike

from meshlab_symrecon.errors import ParameterError

__all__ = ["RECONSTRUCT", "Batch", "Limits", "bytes_of", "in_bytes"]

RECONSTRUCT = "reconstruct"  # in place of a script: the whole method
UNITS = {"": 1, "K": 1 << 10, "M": 1 << 20, "G": 1 << 30, "T": 1 << 40}
MOST = 1 << 60  # bytes; systems count in 64 bits with a sign
SIZE = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*([KMGT]?)(?:I?B)?\s*", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Limits:
    """What each scan may use; None is no limit.

    Attributes
    ----------
    seconds : float or None
    memory : int or None
        Bytes.
    points : int or None
        A scan with more is thinned out evenly to these first; at least 100.
    threads : int or None
        Of each scan; None is one when several scans are worked on at once, all cores otherwise.

    Raises
    ------
    ParameterError
        A limit that is not above zero, or of memory, points or threads no whole number.
    """

    seconds: float | None = None
    memory: int | None = None
    points: int | None = None
    threads: int | None = None

    def __post_init__(self) -> None:
        for name in ("seconds", "memory", "points", "threads"):
            value = getattr(self, name)
            kind = (int, float) if name == "seconds" else int
            if value is not None and not (_is_a(value, kind) and 0 < value < math.inf):
                what = "number" if name == "seconds" else "whole number"
                message = f"the limit of {name} is a {what} above zero; got {value!r}"
                raise ParameterError(f"{message}; leave it out for no limit")


@dataclass(frozen=True, slots=True)
class Batch:
    """One script, or the whole method, and the scans that it is for.

    Attributes
    ----------
    script : path-like
        A filter script, or the word ``reconstruct``.
    inputs : sequence of path-like
        Files, folders, patterns.
    folder : path-like
        Where the results go; it is made when it is missing.
    name : str
        Template of the results' names.
    recursive : bool
        Look into folders in folders.
    settings : mapping of str to value
        Parameters for ``reconstruct``, such as ``randomseed`` and ``paint``.
    strict, lenient : bool
        As ``FilterScript.run``.
    limits : Limits
    jobs : int or None
        How many scans at once; as many as there are cores when None.
    scheduler : str or None
        Address of a dask scheduler, whose workers do the work.
    log : path-like or None
        ``batch.jsonl`` in the folder when None.
    summary : path-like or None
        Where the caller will save what became of all scans; refused when it is a file of the batch.
    retry : bool
        Work again on scans that have failed before.
    again : bool
        Work again on every scan.

    Raises
    ------
    ParameterError
        The inputs are one text instead of a sequence, the folder is an empty text, or jobs is no
        whole number above zero.
    """

    script: str | PathLike[str]
    inputs: Sequence[str | PathLike[str]]
    folder: str | PathLike[str]
    name: str = "{stem}.ply"
    recursive: bool = False
    settings: Mapping[str, object] = field(default_factory=dict)
    strict: bool = False
    lenient: bool = False
    limits: Limits = field(default_factory=Limits)
    jobs: int | None = None
    scheduler: str | None = None
    log: str | PathLike[str] | None = None
    summary: str | PathLike[str] | None = None
    retry: bool = False
    again: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.inputs, (str, bytes, PathLike)):
            message = f"inputs is a sequence of files, folders and patterns; got {self.inputs!r}"
            raise ParameterError(f"{message}; write it in brackets")
        if not os.fspath(self.folder):  # to a path it would be the folder that we are in
            raise ParameterError("the folder of the results has no name; give '.' for this one")
        if self.jobs is not None and not (_is_a(self.jobs, int) and self.jobs > 0):
            message = f"jobs is a whole number above zero; got {self.jobs!r}"
            raise ParameterError(f"{message}; leave it out for as many as there are cores")


def _is_a(value: object, kind: type | tuple[type, ...]) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool)


def bytes_of(text: str) -> int:
    """Return the bytes that a text such as ``4G``, ``500M`` or ``1.5 GiB`` stands for.

    Raises
    ------
    ParameterError
        It is no size.
    """
    found = SIZE.fullmatch(text)
    size = 0.0 if found is None else float(found[1]) * UNITS[found[2].upper()]
    if not 0.0 < size <= MOST:
        raise ParameterError(f"'{text}' is no size of memory; give one like 500M or 4G")
    return max(1, round(size))


def in_bytes(count: int) -> str:
    """Return a number of bytes in words."""
    for unit in ("T", "G", "M", "K"):
        if count >= UNITS[unit]:
            return f"{count / UNITS[unit]:.3g} {unit}iB"
    return f"{count} bytes"
