"""Make every picture that the documents show: ``make gallery``, or for some of them

python docs/gallery.py nefertiti.png planes.png

A picture is a row of ``PICTURES``. What needs something that is not here is passed over.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import browser

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs/pictures"
SYMRECON = (sys.executable, "-m", "meshlab_symrecon.cli.main")
PYTHON = (sys.executable,)
NEFERTITI = "examples/data/nefertiti_incomplete.ply"
CHROMIUM, DATA = "Chromium", "SYMRECON_DATA"


@dataclass(frozen=True)
class Picture:
    """A picture of ``docs/pictures``, and the commands that make it, run in the root of the tree.

    In the commands ``{path}`` is the picture and ``{scratch}`` a folder that is deleted afterwards.
    """

    name: str
    commands: tuple[tuple[str, ...], ...]
    needs: tuple[str, ...] = ()


PICTURES = (
    Picture(
        "nefertiti.png",
        (
            (*SYMRECON, "reconstruct", NEFERTITI, "-o", "{scratch}/a.ply", "--preview", "{path}"),
        ),
    ),
    Picture(
        "completion.png",
        ((*PYTHON, "benchmarks/completion_picture.py", "{path}"),),
        needs=(DATA,),
    ),
    Picture(
        "simplification.png",
        ((*PYTHON, "benchmarks/simplification_picture.py", "{path}"),),
        needs=(DATA,),
    ),
    Picture(
        "deviation.png",
        ((*PYTHON, "benchmarks/deviation_picture.py", "{path}"),),
        needs=(DATA,),
    ),
    Picture(
        "growth.png",
        (
            (*PYTHON, "benchmarks/growth.py", "--rows", "{scratch}/rows.json"),
            (*PYTHON, "benchmarks/growth_picture.py", "{scratch}/rows.json", "{path}"),
        ),
        needs=(DATA,),
    ),
    Picture("planes.png", ((*PYTHON, "benchmarks/plane_pictures.py", "{path}"),)),
    Picture(
        "report.png",
        (
            (
                *SYMRECON, "reconstruct", NEFERTITI,
                "-o", "{scratch}/a.ply", "--report", "{scratch}/a.html",
            ),
            (*PYTHON, "docs/browser.py", "{scratch}/a.html", "{path}"),
        ),
        needs=(CHROMIUM,),
    ),
)  # fmt: skip


def lacking(picture: Picture) -> str:
    """Say what a picture needs that is not here; nothing when it can be made."""
    reasons = {
        CHROMIUM: browser.missing(),
        DATA: "" if os.environ.get(DATA) else f"{DATA} (the folder with the models)",
    }
    return ", ".join(reasons[need] for need in picture.needs if reasons[need])


def make(picture: Picture) -> None:
    """Run the commands of a picture."""
    with tempfile.TemporaryDirectory(prefix="gallery-") as scratch:
        for command in picture.commands:
            words = [word.format(path=FOLDER / picture.name, scratch=scratch) for word in command]
            subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    known = [picture.name for picture in PICTURES]
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(known)}")
    names = parser.parse_args().names
    unknown = sorted(set(names) - set(known))
    if unknown:
        raise SystemExit(f"no picture {', '.join(unknown)}; there are: {', '.join(known)}")
    for picture in PICTURES:
        if names and picture.name not in names:
            continue
        reason = lacking(picture)
        if reason:
            print(f"{picture.name}: left as it is; missing here: {reason}")
            continue
        make(picture)
        print(f"{picture.name}: made")


if __name__ == "__main__":
    main()
