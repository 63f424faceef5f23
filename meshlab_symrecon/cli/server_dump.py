"""Every filter with its parameters as text, for ``-d``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

__all__ = ["write_dump"]


def write_dump(path: Path) -> int:
    """Write the filters of plugins, then MeshLab's own; return how many there are.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    from meshlab_symrecon.host.atomic import replacing
    from meshlab_symrecon.host.native_filters import native_filters
    from meshlab_symrecon.host.registration import registry

    pages = [_page(item) for item in registry()]
    pages += [_native_page(item) for item in native_filters().values()]
    with replacing(path) as staged:
        staged.write_bytes("\n\n".join(pages).encode() + b"\n")
    return len(pages)


def _page(item: Any) -> str:
    from meshlab_symrecon.plugin.documentation import parameter_lines

    lines = parameter_lines(item) or ["No parameters."]
    return "\n".join([item.menu_name, item.python_name, item.summary, *lines])


def _native_page(item: Any) -> str:
    lines = [
        f"- {parameter.script_name} : {parameter.rich_type}"
        + (f", one of {', '.join(parameter.words)}" if parameter.words else "")
        for parameter in item.parameters
    ]
    return "\n".join([item.menu_name, item.python_name, *(lines or ["No parameters."])])
