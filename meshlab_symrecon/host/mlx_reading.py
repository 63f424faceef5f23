"""Filter scripts read from files, with the line on which each step and parameter stands.

The grammar is that of MeshLab: ``<filter>`` with typed ``<Param>`` children, and the untyped
``<xmlfilter>`` with ``<xmlparam>`` children that MeshLab wrote from 2014 to 2020.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from meshlab_symrecon.errors import FileError, ScriptError
from meshlab_symrecon.host.atomic import reason
from meshlab_symrecon.host.mlx import ROOT, Param, Script, Step, same_name

__all__ = ["read_script"]

LARGEST = 1 << 26  # bytes of a script
STEPS = ("filter", "xmlfilter")
PARAMETERS = ("param", "xmlparam")
TEXTS = ("RichString", "RichOpenFile", "RichSaveFile")
BYTE_ORDER_MARK = b"\xef\xbb\xbf"


def read_script(path: str | Path) -> Script:
    """Read a script.

    Tags are read in any case, and blank lines before the first line of XML are allowed.

    Raises
    ------
    FileError
        The file is missing or cannot be read.
    ScriptError
        It is no XML, defines entities, names a DTD, or is no filter script; the message starts with
        ``file:line:``. Steps and parameters without a name, and parameters that are given twice
        with different values, are read as they are: ``resolution.matched`` finds them.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:  # perhaps a pipe, or a device without an end
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        message = f"script {path} cannot be read: {reason(error)}; check its path"
        raise FileError(message) from error
    if len(content) > LARGEST:
        raise ScriptError(f"{path}:1: a filter script has at most {LARGEST >> 20} MB; got more")
    content, skipped = _without_leading_blanks(content)
    collector = _Collector(path, skipped)
    parser = DefusedXMLParser(target=collector)
    collector.parser = parser
    try:
        parser.feed(content)
        steps = parser.close()
    except ElementTree.ParseError as error:
        words = str(error).split(": line")[0]
        line = error.position[0] + skipped
        raise ScriptError(f"{path}:{line}: this is not XML: {words}") from error
    except DefusedXmlException as error:
        line = parser.parser.CurrentLineNumber + skipped
        message = f"{path}:{line}: a filter script must not define entities; remove them"
        raise ScriptError(message) from error
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        raise ScriptError(f"{path}:1: this is not readable as XML: {error}") from error
    return Script(path, steps, collector.comments)


class _Collector:
    """What expat calls: collects steps with the line on which each element starts."""

    def __init__(self, path: Path, skipped: int) -> None:
        self.path = path
        self.skipped = skipped  # lines before the first that expat was given
        self.steps: list[Step] = []
        self.comments: dict[int, list[str]] = {}
        self.open_tags: list[str] = []
        self.parser: Any = None  # set after construction: parser and target need each other

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        if system:  # never fetched; but what it declares would be missing
            line = self.parser.parser.CurrentLineNumber + self.skipped
            what = f"the DOCTYPE must not name a file or address; got {system!r:.60}"
            raise self.problem(line, f"{what}; write <!DOCTYPE {ROOT}>")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.parser.parser.CurrentLineNumber + self.skipped
        plain = tag.lower()
        if not self.open_tags:
            if plain != ROOT.lower():
                raise self.problem(line, f"the outermost element must be <{ROOT}>; got <{tag}>")
        elif len(self.open_tags) == 1:
            self.start_step(plain, line, attributes)
        elif len(self.open_tags) == 2 and plain in PARAMETERS:
            self.start_parameter(line, attributes)
        else:
            raise self.problem(line, f"<{tag}> has no place inside <{self.open_tags[-1]}>")
        self.open_tags.append(plain)

    def comment(self, text: str) -> None:
        inside_a_step = len(self.open_tags) > 1
        self.comments.setdefault(len(self.steps) - inside_a_step, []).append(text)

    def end(self, tag: str) -> None:
        self.open_tags.pop()

    def close(self) -> tuple[Step, ...]:
        return tuple(self.steps)

    def start_step(self, tag: str, line: int, attributes: dict[str, str]) -> None:
        if tag not in STEPS:
            raise self.problem(line, f"a step must be a <filter> or <xmlfilter>; got <{tag}>")
        self.steps.append(Step(attributes.get("name", ""), line, (), tag == "xmlfilter"))

    def start_parameter(self, line: int, attributes: dict[str, str]) -> None:
        rest = dict(attributes)
        name, rich_type = rest.pop("name", ""), rest.pop("type", "")
        step = self.steps[-1]
        parameter = Param(name, line, rich_type, rest.pop("value", None), rest)
        if not any(_says_the_same(known, parameter) for known in step.parameters):
            self.steps[-1] = replace(step, parameters=(*step.parameters, parameter))

    def problem(self, line: int, what: str) -> ScriptError:
        return ScriptError(f"{self.path}:{line}: {what}")


def _says_the_same(first: Param, second: Param) -> bool:
    """Say whether one of two parameters can be left out; only in texts does case matter."""
    texts = any(parameter.rich_type in TEXTS for parameter in (first, second))
    named = first.name.strip() and same_name(first.name, second.name)
    return bool(named) and _content(first, not texts) == _content(second, not texts)


def _content(parameter: Param, fold: bool) -> dict[str, str]:
    written = dict(parameter.attributes)
    if parameter.text is not None:
        written["value"] = parameter.text
    stripped = {name: text.strip() for name, text in written.items()}
    return {name: text.lower() for name, text in stripped.items()} if fold else stripped


def _without_leading_blanks(content: bytes) -> tuple[bytes, int]:
    """Return what XML allows to begin with ``<?xml``, and how many lines were cut."""
    text = content.removeprefix(BYTE_ORDER_MARK)
    begun = text.lstrip(b" \t\r\n")
    if begun is text or not begun.startswith(b"<?xml"):
        return content, 0
    return begun, text[: len(text) - len(begun)].replace(b"\r\n", b"\n").count(b"\n")
