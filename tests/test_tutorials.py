"""Tutorials are tests: their commands and Python run, and print what the page shows.

On a page, ``python`` blocks share their names, ``sh`` blocks are commands, and a ``text`` block is
what the block before it prints, numbers to within 5 %, seconds set aside. A paragraph that ends in
the name of a file, before a block, is either a link to a file of the repository, which the block
must equal, or the name under which the block is saved.
"""

from __future__ import annotations

import io
import math
import re
import shlex
import subprocess
import sys
import warnings
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path

import pytest

import meshlab_symrecon
from meshlab_symrecon.errors import SymReconWarning

ROOT = Path(__file__).parents[1]
TUTORIALS = sorted(ROOT.glob("docs/tutorials/*.md"))
BLOCK = re.compile(r"([^\n]*)\n\n```(\w*)\n(.*?)```", re.DOTALL)
LINKED = re.compile(r"\[`([\w./]+)`\]\([^)]*\)[^`]*:$")
SAVED = re.compile(r"`([\w./]+\.(?:mlx|py|sh))`[^`]*:$")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
SECONDS = re.compile(r"\(?\d+\.\d+ s\b\)?")
EXIT_CODE = re.compile(r"# exit code (\d)")
TOLERANCE = 0.05  # of a number that a page shows: other versions of numpy may count otherwise


@dataclass
class Page:
    """A tutorial that is being followed in a folder."""

    folder: Path
    names: dict = field(default_factory=dict)
    printed: str = ""

    def follow(self, before: str, language: str, text: str) -> None:
        linked, saved = LINKED.search(before), SAVED.search(before)
        if linked:
            assert text == ROOT.joinpath(linked[1]).read_text(encoding="utf-8"), linked[1]
        elif saved:
            (self.folder / saved[1]).write_text(text, encoding="utf-8")
        elif language == "python":
            self.printed = self.python(text)
        elif language == "sh":
            commands = text.replace("\\\n", " ").splitlines()
            self.printed = "".join(self.command(command) for command in commands)
        elif language == "text":
            assert_alike(self.printed, text)
        else:
            pytest.fail(f"a block of {language!r} that nobody looks at, after {before!r}")

    def python(self, text: str) -> str:
        heard = io.StringIO()
        with redirect_stdout(heard):
            exec(compile(text, "tutorial", "exec"), self.names)
        return heard.getvalue()

    def command(self, command: str) -> str:
        code = EXIT_CODE.search(command)
        done = subprocess.run(
            self.words(command), cwd=self.folder, capture_output=True, text=True, check=False,
            env=self.environment(),
        )  # fmt: skip
        assert done.returncode == (int(code[1]) if code else 0), f"{command}: {done.stderr}"
        return done.stdout + (done.stderr if code else "")

    def environment(self) -> dict[str, str]:
        installed = {"PYTHONPATH": str(self.folder / "site"), "OMP_WAIT_POLICY": "passive"}
        programs = f"{Path(sys.executable).parent}:/usr/bin:/bin"
        return {"PATH": programs, "HOME": str(self.folder), "COLUMNS": "200"} | installed

    def words(self, command: str) -> list[str]:
        program, *rest = shlex.split(command, comments=True)
        if program == "pip":
            assert rest[0] == "install"
            offline = ["--no-build-isolation", "--no-deps", "--no-index", "--target", "site"]
            quiet = ["--quiet", "--disable-pip-version-check", "--no-cache-dir"]
            return [sys.executable, "-m", "pip", "install", *offline, *quiet, *rest[1:]]
        if program == "python":
            return [sys.executable, *rest]
        if program in ("grep", "sed", "sh"):
            return [program, *rest]
        return [str(Path(sys.executable).with_name(program)), *rest]


def assert_alike(printed: str, shown: str) -> None:
    """Compare what is printed with what is shown: words exactly, numbers nearly."""
    printed, shown = (SECONDS.sub("SECONDS", text).rstrip() for text in (printed, shown))
    assert NUMBER.sub("N", printed) == NUMBER.sub("N", shown), printed
    for one, other in zip(NUMBER.findall(printed), NUMBER.findall(shown), strict=True):
        assert math.isclose(float(one), float(other), rel_tol=TOLERANCE, abs_tol=0.01), printed


@pytest.mark.parametrize("tutorial", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_does_what_it_says(tutorial, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("examples", "meshlab_scripts"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    blocks = BLOCK.findall(tutorial.read_text(encoding="utf-8"))
    assert len(blocks) == tutorial.read_text(encoding="utf-8").count("```") / 2
    page = Page(tmp_path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", SymReconWarning)
            for before, language, text in blocks:
                page.follow(before, language, text)
    finally:
        meshlab_symrecon.unload_plugins()


def test_there_are_tutorials():
    assert [path.stem for path in TUTORIALS] == [
        "first_scan", "mixed_script", "moving_from_meshlabserver", "own_filter",
    ]  # fmt: skip


def test_the_filter_of_ones_own_is_short():
    code = ROOT.joinpath("examples/own_filter/scan_base.py").read_text(encoding="utf-8")
    lines = [
        line for line in code.splitlines() if line.strip() and not line.lstrip().startswith('"""')
    ]
    assert len(lines) <= 30


@pytest.mark.parametrize(
    ("printed", "shown"),
    [("closed 100", "open 100"), ("100 points", "94 points"), ("1 2", "1 2 3"), ("True", "")],
)
def test_what_a_page_shows_is_compared(printed, shown):
    with pytest.raises(AssertionError):
        assert_alike(printed, shown)
    assert_alike(printed.replace("100", "103") + " in 2.4 s", printed + " in 7.1 s\n")
