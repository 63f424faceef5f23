"""The state of the whole process that MeshLab's readers and writers leave changed."""

from __future__ import annotations

import locale
import os
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["process_kept"]


@contextmanager
def process_kept() -> Iterator[None]:
    """Undo what readers and writers change: the current directory and the locale.

    A reader or writer that fails leaves the process in the file's directory; the 3MF exporter sets
    the locale to ``C``.
    """
    directory = os.getcwd()  # noqa: PTH109  a text, as os.chdir takes it
    words = locale.setlocale(locale.LC_ALL)
    try:
        yield
    finally:
        os.chdir(directory)
        locale.setlocale(locale.LC_ALL, words)
