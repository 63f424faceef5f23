"""Names of results, from a template."""

from __future__ import annotations

import os
import re
import string
import unicodedata
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath

from meshlab_symrecon.batch.inputs import Scan
from meshlab_symrecon.errors import ParameterError

__all__ = ["FIELDS", "folded", "named"]

FIELDS = {
    "stem": "the scan's name without its extension",
    "extension": "its extension, or ply when that format can only be read",
    "parent": "the name of the folder that it lies in",
    "folder": "that folder, relative to the folder or pattern that was given",
    "number": "its place in the order, from 1; {number:04} for 0001",
    "script": "the script's name without its extension",
}
SHORT = re.compile(r"0?[0-9]{0,2}d?")  # a width


def named(
    template: str, scans: Sequence[Scan], *, script: str, writable: Iterable[str]
) -> tuple[Path, ...]:
    """Return the name of each scan's result, relative to the folder of results.

    Parameters
    ----------
    template : str
        With fields in braces, see ``FIELDS``.
    scans : sequence of Scan
    script : str
    writable : iterable of str
        Extensions; the template must give one of them.

    Raises
    ------
    ParameterError
        The template has an unknown field, leaves the folder, names no format that can be written,
        or gives two scans one name.
    """
    _check_fields(template)
    known = tuple(writable)
    names = tuple(
        _checked(template, template.format(**_values(scan, number, script, known)), known)
        for number, scan in enumerate(scans, 1)
    )
    first: dict[str, Scan] = {}
    for scan, name in zip(scans, names, strict=True):
        other = first.setdefault(folded(str(name)), scan)
        if other is not scan:
            message = f"{other.path} and {scan.path} would both become {name}"
            raise ParameterError(f"{message}; {_mended(template, other, scan)}")
    return names


def _check_fields(template: str) -> None:
    try:
        parts = list(string.Formatter().parse(template))
    except ValueError as error:
        message = f"the template '{template}' cannot be read: {error}"
        raise ParameterError(f"{message}; write fields like {{stem}}") from error
    for _, name, specification, conversion in parts:
        if name is None or specification is None:  # words alone
            continue
        if name not in FIELDS or conversion or (specification and name != "number"):
            known = ", ".join(f"{{{field}}}" for field in FIELDS)
            message = f"the template '{template}' has an unknown field '{{{name}}}'"
            raise ParameterError(f"{message}; known are {known}, and {{number:04}}")
        if not SHORT.fullmatch(specification):
            message = (
                f"the template '{template}' cannot be filled in: '{specification}' is no width"
            )
            raise ParameterError(f"{message} of up to 99; write {{number}} or {{number:04}}")


def _values(scan: Scan, number: int, script: str, writable: Iterable[str]) -> dict[str, object]:
    extension = scan.path.suffix.removeprefix(".").lower()
    return {
        "stem": scan.path.stem,
        "extension": extension if extension in writable else "ply",
        "parent": Path(os.path.abspath(scan.path)).parent.name or "root",  # noqa: PTH100  no links
        "folder": scan.folder.as_posix(),
        "number": number,
        "script": Path(script).stem,
    }


def _checked(template: str, name: str, writable: Iterable[str]) -> Path:
    path = PurePosixPath(name)
    if not name.strip() or path.is_absolute() or Path(name).is_absolute() or ".." in path.parts:
        message = f"the template '{template}' gives '{name}', which is not inside of the folder"
        raise ParameterError(f"{message} of results; give a relative name without '..'")
    if path.name.startswith(".") or "\0" in name:
        message = f"the template '{template}' gives the hidden or unusable name '{name}'"
        raise ParameterError(f"{message}; begin with a letter, a digit or a field")
    extension = path.suffix.removeprefix(".").lower()
    if extension not in writable:
        shown = f"the extension '.{extension}'" if extension else "no extension"
        message = f"the template '{template}' gives {shown}, which cannot be written"
        raise ParameterError(f"{message}; known are {', '.join(writable)}")
    return Path(path)


def folded(name: str) -> str:
    """Return what is the same for names that some file system takes for one.

    Which names those are is the file system's affair, not the operating system's: disks of others
    are mounted everywhere, and results are copied to them.
    """
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", name).casefold())


def _mended(template: str, first: Scan, second: Scan) -> str:
    """Return what to do about two scans of one name."""
    if first.path.stem != second.path.stem:
        field = "{stem}"
    elif first.path.suffix != second.path.suffix:
        field = "{extension}"
    elif first.path.parent.name != second.path.parent.name:
        field = "{parent}"
    else:
        field = "{folder}"
    if field in template:
        field = "{number}"
    more = {
        "{stem}": "{stem}.ply",
        "{extension}": "{stem}_{extension}.ply",
        "{parent}": "{parent}/{stem}.ply",
        "{folder}": "{folder}/{stem}.ply",
        "{number}": "{number:04}_{stem}.ply",
    }[field]
    return f"tell them apart by {field}, as in --name '{more}'"
