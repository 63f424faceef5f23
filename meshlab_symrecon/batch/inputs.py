"""Which scans are meant by files, folders and patterns."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from meshlab_symrecon.errors import FileError

__all__ = ["Scan", "find_scans", "natural"]

NOTES = "txt"  # MeshLab reads points from these, but in folders they are notes
MAGIC = re.compile(r"[*?\[]")


@dataclass(frozen=True, slots=True)
class Scan:
    """A scan's file, as it was named, and its folder relative to the one that was named."""

    path: Path
    folder: Path = Path()


def find_scans(
    inputs: Sequence[str | os.PathLike[str]],
    *,
    readable: Iterable[str],
    recursive: bool = False,
    results: Path | None = None,
) -> tuple[Scan, ...]:
    """Return the scans, each file once, in the natural order of their names.

    Parameters
    ----------
    inputs : sequence of path-like
        Files; folders, for the readable meshes in them; patterns with ``*``, ``?``, ``[...]`` and
        ``**``, for the readable files that fit.
    readable : iterable of str
        Extensions.
    recursive : bool
        Look into folders in folders.
    results : Path, optional
        A folder in one of those that are named: its files are results, no scans.

    Raises
    ------
    FileError
        One of them does not exist or has no name, or there is no scan in any.
    """
    extensions = {f".{extension}" for extension in readable if extension != NOTES}
    found: list[Scan] = []
    for text in (os.fspath(one) for one in inputs):
        path = Path(text)
        if not text:  # to a path it would be the folder that we are in
            raise FileError("an input has no name; is a variable of the shell empty?")
        if path.is_dir():
            base, files = path, _in_folder(path, recursive)
        elif not os.path.lexists(path) and MAGIC.search(text):
            base, files = _fixed_part(text), _fitting(text)
        elif os.path.lexists(path):
            found.append(Scan(path))
            continue
        else:
            raise FileError(f"{path} cannot be read: no such file or folder; check its path")
        scans = [
            Scan(file, file.parent.relative_to(base))
            for file in files
            if file.suffix.lower() in extensions and not _among_results(file, base, results)
        ]
        if not scans and MAGIC.search(text) and not path.is_dir():
            raise FileError(f"no scan fits the pattern '{text}'; check it, and quote it")
        found += scans
    if not found:
        named = ", ".join(os.fspath(one) for one in inputs)
        raise FileError(f"no scans are in {named}; name files, or add --recursive")
    return _each_once(sorted(found, key=lambda scan: natural(str(scan.path))))


def natural(text: str) -> list[tuple[int, int, str]]:
    """Return a key that sorts ``scan2`` before ``scan10``."""
    parts = re.split(r"([0-9]+)", text)
    return [
        (0, int(part), part) if position % 2 else (1, 0, part.casefold())
        for position, part in enumerate(parts)
    ] + [(2, 0, text)]


def _in_folder(folder: Path, recursive: bool) -> Iterator[Path]:
    """Yield the files of a folder; hidden ones, as half-written results are, stay hidden."""
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (Path(place, name) for name in sorted(names) if not name.startswith("."))
        if not recursive:
            return


def _fitting(pattern: str) -> Iterator[Path]:
    paths = (Path(name) for name in glob.iglob(pattern, recursive=True))  # noqa: PTH207  absolute ones too
    return (path for path in paths if not path.is_dir())


def _fixed_part(pattern: str) -> Path:
    """Return the folder that a pattern begins with."""
    fixed = []
    for part in Path(pattern).parts[:-1]:
        if MAGIC.search(part):
            break
        fixed.append(part)
    return Path(*fixed)


def _among_results(file: Path, base: Path, results: Path | None) -> bool:
    if results is None:
        return False
    below = Path(os.path.realpath(results))
    return Path(os.path.realpath(base)) in below.parents and below in (
        Path(os.path.realpath(file.parent), file.name).parents
    )


def _each_once(scans: Iterable[Scan]) -> tuple[Scan, ...]:
    """Drop further names of the same file."""
    kept: dict[str, Scan] = {}
    for scan in scans:
        kept.setdefault(os.path.normcase(os.path.realpath(scan.path)), scan)
    return tuple(kept.values())
