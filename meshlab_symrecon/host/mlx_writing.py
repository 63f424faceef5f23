"""Filter scripts written to files that MeshLab and ``mlx_reading`` read back alike."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

from meshlab_symrecon.errors import ScriptError
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.mlx import ROOT, Param, Step

__all__ = ["script_text", "write_script"]

HEADER = "<!DOCTYPE FilterScript>\n"
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_script(
    steps: Iterable[Step], path: str | Path, comments: Mapping[int, Sequence[str]] | None = None
) -> None:
    """Write a script that ``read_script`` reads back to equal steps; whole or not at all.

    Parameters
    ----------
    steps : iterable of Step
    path : str or Path
    comments : mapping of int to texts, optional
        What stands above the step at a position; after the last step at one more than its position.

    Raises
    ------
    ScriptError
        A text has a character that XML cannot hold.
    FileError
        The file cannot be written.
    """
    path = Path(path)
    text = script_text(steps, path, comments or {})
    with replacing(path) as staged:
        staged.write_bytes(text.encode("utf-8"))


def script_text(steps: Iterable[Step], path: Path, comments: Mapping[int, Sequence[str]]) -> str:
    """Return what ``write_script`` writes; ``path`` is what messages call it.

    Raises
    ------
    ScriptError
        A text has a character that XML cannot hold.
    """
    root = ElementTree.Element(ROOT)
    count = 0
    for step in steps:
        _append_comments(root, comments.get(count, ()), path)
        count += 1
        tag = "xmlfilter" if step.from_xml_plugin else "filter"
        element = ElementTree.SubElement(root, tag, {"name": _checked(step.name, path)})
        for parameter in step.parameters:
            _append(element, parameter, "xmlparam" if step.from_xml_plugin else "Param", path)
    _append_comments(root, comments.get(count, ()), path)
    ElementTree.indent(root, " ")
    return HEADER + ElementTree.tostring(root, encoding="unicode") + "\n"


def _append_comments(root: ElementTree.Element, texts: Iterable[str], path: Path) -> None:
    for text in texts:
        safe = re.sub("-(?=-)|-$", "- ", text)  # XML allows neither "--" nor a "-" at the end
        root.append(ElementTree.Comment(_checked(safe, path)))


def _append(element: ElementTree.Element, parameter: Param, tag: str, path: Path) -> None:
    written = {"type": parameter.rich_type} if parameter.rich_type else {}
    written["name"] = parameter.name
    if parameter.text is not None:
        written["value"] = parameter.text
    written |= parameter.attributes
    ElementTree.SubElement(
        element, tag, {name: _checked(text, path) for name, text in written.items()}
    )


def _checked(text: str, path: Path) -> str:
    found = NOT_XML.search(text)
    if found:
        message = f"{path}:1: XML cannot hold the character {found.group()!r} of {text!r:.60}"
        raise ScriptError(f"{message}; remove it")
    return text
