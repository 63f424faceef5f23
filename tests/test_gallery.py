"""Every picture of the documents is made by the gallery, and every picture made is shown."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs/pictures"
DOCUMENTS = (ROOT / "README.md", *sorted(ROOT.glob("docs/*.md")))


@pytest.fixture(scope="module")
def gallery():
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        import gallery as loaded
    finally:
        sys.path.remove(str(ROOT / "docs"))
    return loaded


def shown():
    """Return each picture that a document shows, by its path, with its words."""
    found = {}
    for document in DOCUMENTS:
        text = document.read_text(encoding="utf-8")
        for words, target in re.findall(r"!\[([^\]]*)\]\(([^)#]+)", text):
            found[(document.parent / target).resolve()] = words
    return found


def test_the_gallery_is_what_the_documents_show(gallery):
    made = {(FOLDER / picture.name).resolve() for picture in gallery.PICTURES}
    assert len(made) == len(gallery.PICTURES)
    assert made == set(shown())
    assert made == {path.resolve() for path in FOLDER.iterdir()}  # committed, and nothing else


def test_every_picture_is_described(gallery):
    assert all(len(words) > 10 for words in shown().values())


def test_the_commands_exist(gallery):
    for picture in gallery.PICTURES:
        assert picture.commands
        assert any("{path}" in word for command in picture.commands for word in command)
        for command in picture.commands:
            for word in command:
                assert not word.endswith(".py") or (ROOT / word).is_file(), word
        for need in picture.needs:
            assert need in (gallery.CHROMIUM, gallery.DATA)


def test_what_is_missing_is_said(gallery, monkeypatch, capsys):
    wanting = gallery.Picture("x.png", (("false",),), needs=(gallery.DATA, gallery.CHROMIUM))
    monkeypatch.setattr(gallery, "PICTURES", (wanting,))
    monkeypatch.setattr(gallery.browser, "missing", lambda: "Chromium, chromedriver")
    monkeypatch.delenv("SYMRECON_DATA", raising=False)
    monkeypatch.setattr(sys, "argv", ["gallery.py"])
    gallery.main()
    assert capsys.readouterr().out == (
        "x.png: left as it is; missing here: SYMRECON_DATA (the folder with the models), "
        "Chromium, chromedriver\n"
    )


def test_a_picture_is_made_where_it_belongs(gallery, monkeypatch, tmp_path, capsys):
    copy = "import pathlib, sys; pathlib.Path(sys.argv[1]).write_text(sys.argv[2])"
    row = gallery.Picture("x.png", ((sys.executable, "-c", copy, "{path}", "{scratch}"),))
    monkeypatch.setattr(gallery, "PICTURES", (row,))
    monkeypatch.setattr(gallery, "FOLDER", tmp_path)
    monkeypatch.setattr(sys, "argv", ["gallery.py", "x.png"])
    gallery.main()
    assert not Path((tmp_path / "x.png").read_text()).exists()  # the scratch folder is gone
    assert capsys.readouterr().out == "x.png: made\n"


def test_an_unknown_picture_is_refused():
    words = [sys.executable, "docs/gallery.py", "none.png"]
    ended = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert ended.stderr.startswith("no picture none.png; there are: nefertiti.png, ")
