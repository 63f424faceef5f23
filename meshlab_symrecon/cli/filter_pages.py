"""The docs pages of filters, one a filter, rendered from their declarations.

Their form is that of MeshLab's own list of filters: names, what it does, and each parameter with
its type, default, label and tooltip. The examples are the same step in Python, in a script and on
the command line.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason, replacing
from meshlab_symrecon.host.mlx import Step, step_of
from meshlab_symrecon.plugin import Filter
from meshlab_symrecon.plugin.parameters import Kind, Parameter

__all__ = ["filter_page", "index_page", "write_pages"]

RENDERED = "Rendered from the declaration{} by `make docs`; edit {}, not this page."
RETURNS = ("Returns ", "Returns, ")  # the paragraph of a description that tells the measures


def index_page(filters: Iterable[Filter], folder: str = "filters") -> str:
    """Return the list of filters in Markdown, with a link to the page of each in ``folder``."""
    lines = [
        "# The filters",
        "",
        RENDERED.format("s of the filters", "those"),
        "",
        "| MeshLab filter name | python name | what it does |",
        "|---|---|---|",
        *(
            f"| {item.menu_name} | [`{item.python_name}`]({folder}/{item.python_name}.md) "
            f"| {item.summary} |"
            for item in filters
        ),
    ]
    return "\n".join(lines) + "\n"


def write_pages(filters: Iterable[Filter], folder: Path) -> list[Path]:
    """Write ``filters.md``, the list, and ``filters/NAME.md`` for each filter; return the paths.

    Raises
    ------
    FileError
        The folder cannot be made, or a page cannot be written.
    """
    shown = list(filters)
    pages = folder / "filters"
    try:
        pages.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{pages} cannot be made: {reason(error)}; give a folder that can be written to"
        raise FileError(message) from error
    texts = {folder / "filters.md": index_page(shown, pages.name)}
    texts |= {pages / f"{item.python_name}.md": filter_page(item) for item in shown}
    for path, text in texts.items():
        with replacing(path) as staged:
            staged.write_text(text, encoding="utf-8")
    return list(texts)


def filter_page(item: Filter) -> str:
    """Return the docs page of a filter, in Markdown."""
    paragraphs = item.description.split("\n\n")
    info = [paragraph for paragraph in paragraphs if not paragraph.startswith(RETURNS)]
    measures = [
        text.removeprefix("Returns").lstrip(", ") for text in paragraphs if text.startswith(RETURNS)
    ]
    blocks = [
        f"# {item.menu_name}",
        _facts(item),
        f"**{item.summary}**",
        *info,
        "## Parameters",
        *([_parameter(known) for known in item.parameters.declared()] or ["None."]),
        *(["## Returns", *(text[0].upper() + text[1:] for text in measures)] if measures else []),
        "## Examples",
        *_examples(item),
        *_references(item),
        RENDERED.format("", "that"),
    ]
    return "\n\n".join(blocks) + "\n"


def _facts(item: Filter) -> str:
    """Return the names, the menu, and what goes in and comes out, one a line."""
    reads = " and ".join(item.requires) + " in the current layer" if item.requires else "nothing"
    if item.arity == "VARIABLE":
        reads += "; it reads other layers too"
    makes = ", ".join(f"the layer `{label}`" for label in item.creates)
    facts = {
        "Python name": f"`{item.python_name}`",
        "MeshLab filter name": f"`{item.menu_name}`",
        "Aliases": ", ".join(f"`{alias}`" for alias in item.aliases) or "none",
        "Menu": f"{item.meshlab_class}; category {item.category}",
        "Needs": reads,
        "Makes": makes or "no layer",
    }
    return "\n".join(f"- *{title}*: {text}" for title, text in facts.items())


def _parameter(parameter: Parameter) -> str:
    declared = f"`{parameter.name} : {type(parameter.default).__name__} = {parameter.default!r}`"
    words = "; ".join(f"{number}: '{word}'" for number, word in enumerate(parameter.choices))
    values = "" if parameter.kind is Kind.BOOLEAN else f", {parameter.range_words}"
    lines = [
        f"- {declared}{'' if words else values}<br>",
        *([f"  Possible values: {words}.<br>"] if words else []),
        f"  *{parameter.label}*: {parameter.tooltip}",
    ]
    return "\n".join(lines)


def _examples(item: Filter) -> list[str]:
    """Return the step in Python, in a script, and on the command line."""
    call, option = "", ""
    for first in item.parameters.declared()[:1]:
        written = f'"{first.default}"' if isinstance(first.default, str) else ""
        call = f"{first.name}={written or repr(first.default)}"
        option = f" --{first.name.replace('_', '-')} {written or first.format(first.default)}"
    return [
        "In Python, where `ms` is a `MeshSet`, after `meshlab_symrecon.load_plugins()`:",
        f"```python\nmeasures = ms.{item.python_name}({call})\n```",
        "As a step of a script (`.mlx`), with every parameter at its default:",
        f"```xml\n{_step_text(step_of(item, {}))}\n```",
        "On the command line:",
        f"```sh\nsymrecon apply {item.python_name} scan.ply -o result.ply{option}\n```",
    ]


def _step_text(step: Step) -> str:
    element = ElementTree.Element("filter", name=step.name)
    for parameter in step.parameters:
        written = {"type": parameter.rich_type, "name": parameter.name}
        written |= {"value": parameter.text or ""} | dict(parameter.attributes)
        ElementTree.SubElement(element, "Param", written)
    ElementTree.indent(element, " ")
    return ElementTree.tostring(element, encoding="unicode")


def _references(item: Filter) -> list[str]:
    if not item.citations:
        return []
    return ["## References", "\n".join(f"- {citation}" for citation in item.citations)]
