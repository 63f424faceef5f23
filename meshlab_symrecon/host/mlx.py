"""MeshLab's filter scripts (``.mlx``) as plain data with line numbers; no pymeshlab in it.

The grammar is that of MeshLab: ``<filter>`` with typed ``<Param>`` children, and the untyped
``<xmlfilter>`` with ``<xmlparam>`` children that MeshLab wrote from 2014 to 2020.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from meshlab_symrecon.errors import FileError, ScriptError
from meshlab_symrecon.host.atomic import reason, replacing
from meshlab_symrecon.plugin.filter import Filter
from meshlab_symrecon.plugin.parameters import Kind, Parameter, Value

__all__ = [
    "Param",
    "Script",
    "Step",
    "choice_attributes",
    "read_script",
    "same_name",
    "script_text",
    "step_of",
    "write_script",
]

HEADER = "<!DOCTYPE FilterScript>\n"
ROOT = "FilterScript"
LARGEST = 1 << 26  # bytes of a script
STEPS = ("filter", "xmlfilter")
PARAMETERS = ("param", "xmlparam")
TEXTS = ("RichString", "RichOpenFile", "RichSaveFile")
BYTE_ORDER_MARK = b"\xef\xbb\xbf"
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True, slots=True)
class Param:
    """A parameter as it was written.

    Attributes
    ----------
    name : str
    line : int
        Line of the script; no part of the comparison.
    rich_type : str
        MeshLab's type, such as ``RichFloat``; empty in an ``<xmlparam>``, and where a script leaves
        it out: types are those of today's filters.
    text : str or None
        The attribute ``value``; None where the type keeps its value in other attributes.
    attributes : mapping of str to str
        Every other attribute, such as ``min``, ``enum_val0`` or ``x``.
    """

    name: str
    line: int = field(compare=False)
    rich_type: str
    text: str | None
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Step:
    """A filter as it was written: its name, its line, its parameters in their order."""

    name: str
    line: int = field(compare=False)
    parameters: tuple[Param, ...] = ()
    from_xml_plugin: bool = False  # an <xmlfilter> of 2014 to 2020


@dataclass(frozen=True, slots=True)
class Script:
    """The steps of a script, and the file they were read from.

    Attributes
    ----------
    path : Path
    steps : tuple of Step
    comments : mapping of int to texts
        What stands above or in the step at a position; after the last one at one more than its
        position.
    """

    path: Path
    steps: tuple[Step, ...]
    comments: Mapping[int, Sequence[str]] = field(default_factory=dict, compare=False)


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


def same_name(first: str, second: str) -> bool:
    """Say whether two names of parameters are one, as scripts are read."""
    return first.strip().lower() == second.strip().lower()


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
        words = reason(error) if isinstance(error, OSError) else str(error)
        raise FileError(f"script {path} cannot be read: {words}; check its path") from error
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


def step_of(item: Filter, values: Mapping[str, object]) -> Step:
    """Return a step of one of our filters with every parameter, in the order of declaration.

    Raises
    ------
    ParameterError
        As ``Filter.bind``.
    """
    bound = item.bind(values).values()
    return Step(
        item.menu_name,
        0,
        tuple(_param_of(declared, bound[declared.name]) for declared in item.parameters.declared()),
    )


def _param_of(declared: Parameter, value: Value) -> Param:
    text = declared.format(value)
    return Param(declared.name, 0, declared.kind.rich_type, text, choice_attributes(declared))


def choice_attributes(declared: Parameter) -> dict[str, str]:
    """Return the attributes in which scripts list the words of a choice; none for other kinds."""
    if declared.kind is not Kind.CHOICE:
        return {}
    words = {f"enum_val{number}": word for number, word in enumerate(declared.choices)}
    return {"enum_cardinality": str(len(declared.choices)), **words}
