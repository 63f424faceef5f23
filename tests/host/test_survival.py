"""What survives: every cell of the tables in docs/survival.md, observed on a file."""

from __future__ import annotations

from pathlib import Path

import pytest
from survival import ROWS, WAYS, observe

from meshlab_symrecon.host import inspection

PAGE = Path(__file__).parents[2] / "docs" / "survival.md"


def tables() -> dict[tuple[str, str], str]:
    """Return the word in each cell of the page, by row and way."""
    cells: dict[tuple[str, str], str] = {}
    ways: list[str] = []
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        words = [word.strip() for word in line.strip("|").split("|")]
        if not line.startswith("|") or set(line) <= set("|-: "):
            continue
        if words[0] == "":
            ways = words[1:]
        else:
            cells |= {(words[0], way): word for way, word in zip(ways, words[1:], strict=True)}
    return cells


CELLS = tables()


def test_the_page_has_every_cell():
    assert set(CELLS) == {(row, way) for row in ROWS for way in WAYS}
    assert "lost" not in CELLS.values()


@pytest.mark.parametrize("way", WAYS)
def test_what_a_way_keeps(tmp_path, monkeypatch, way):
    """One test a column, since the cells of a column are quick and many."""
    monkeypatch.setattr(inspection, "try_in_child", lambda path: None)  # these files are ours
    found = {}
    for number, row in enumerate(ROWS):
        folder = tmp_path / str(number)
        found[row] = observe(folder, row, WAYS[way])
    assert found == {row: CELLS[row, way] for row in ROWS}
