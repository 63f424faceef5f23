"""The comments of a script, each with the step that it stands above."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from defusedxml.ElementTree import DefusedXMLParser

__all__ = ["read_comments"]


class _Collector:
    """What expat calls: counts steps, and keeps comments."""

    def __init__(self) -> None:
        self.depth = 0
        self.steps = 0
        self.found: dict[int, list[str]] = {}

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.steps += self.depth == 1
        self.depth += 1

    def end(self, tag: str) -> None:
        self.depth -= 1

    def comment(self, text: str) -> None:
        inside_a_step = self.depth >= 2
        self.found.setdefault(self.steps - inside_a_step, []).append(text)

    def close(self) -> Mapping[int, tuple[str, ...]]:
        return {position: tuple(texts) for position, texts in self.found.items()}


def read_comments(path: str | Path) -> Mapping[int, tuple[str, ...]]:
    """Return the comments of a script that ``read_script`` has read.

    A comment inside a step counts as one above it; one after the last step has the number of steps
    as its position.
    """
    parser = DefusedXMLParser(target=_Collector())
    parser.feed(Path(path).read_bytes())
    found: Mapping[int, tuple[str, ...]] = parser.close()
    return found
