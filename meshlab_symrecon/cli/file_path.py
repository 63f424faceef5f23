"""Paths on the command line, as :class:`pathlib.Path`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

__all__ = ["FilePath"]


class FilePath(click.Path):
    """A path that names something: ``pathlib`` would read an empty one as the folder ``.``."""

    def __init__(self) -> None:
        super().__init__(path_type=Path, readable=False)  # that, a reader says better

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path; refuse what other programs take for a stream, and what names nothing."""
        if value == "":
            self.fail("the path is empty; is a variable of the shell empty?", param, ctx)
        if value == "-":
            message = "'-' is no file, and nothing is read from or written to streams; give a path"
            self.fail(f"{message}, ./- for a file of that name", param, ctx)
        return super().convert(value, param, ctx)
