"""A scan, or a result, of several files is what all of them are."""

from __future__ import annotations

import hashlib
import json

import pytest
from batch_inputs import Witness, cloud

from meshlab_symrecon.batch import Batch, run_batch
from meshlab_symrecon.batch.further_files import checksums_of, further_files, unchanged
from meshlab_symrecon.errors import FileError

PROJECT = """<!DOCTYPE MeshLabDocument>
<MeshLabProject><MeshGroup><MLMesh label="a" filename="{name}"/></MeshGroup></MeshLabProject>
"""
HALVE = """<FilterScript>
 <filter name="Transform: Scale, Normalize"><Param type="RichFloat" name="axisX" value="0.5"/>
 </filter>
</FilterScript>
"""


def project(path, name):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(PROJECT.format(name=name))
    return path


def test_materials_images_and_meshes_are_behind_a_file(tmp_path):
    (tmp_path / "a.mtl").write_text('newmtl x\nmap_Kd "two words.png"\nbump -bm 1 rough.png\n')
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nmtllib none.mtl\nv 0 0 0\n")
    header = "ply\nformat ascii 1.0\ncomment TextureFile b.png\nelement vertex 1\nend_header\n"
    (tmp_path / "b.ply").write_text(header + "comment TextureFile no.png\n")
    images = [tmp_path / name for name in ("two words.png", "rough.png")]
    assert further_files(tmp_path / "a.obj") == (tmp_path / "a.mtl", *images)
    assert further_files(tmp_path / "b.ply") == (tmp_path / "b.png",)
    whole = project(tmp_path / "p.mlp", "a.obj")
    assert further_files(whole) == (tmp_path / "a.obj", tmp_path / "a.mtl", *images)
    assert further_files(project(tmp_path / "q.mlp", "none.ply")) == ()
    assert further_files(tmp_path / "none.obj") == ()
    assert further_files(tmp_path) == ()


def test_checksums_are_by_name(tmp_path):
    (tmp_path / "in").mkdir()
    for name in ("in/a", "b"):
        (tmp_path / name).write_text(name)
    files = [tmp_path / name for name in ("in/a", "b", "in/none")]
    known = checksums_of(files, tmp_path / "in")
    assert known == {
        "a": hashlib.sha256(b"in/a").hexdigest(),
        str(tmp_path / "b"): hashlib.sha256(b"b").hexdigest(),
        "none": None,
    }
    assert unchanged(known, tmp_path / "in")
    (tmp_path / "b").unlink()
    assert not unchanged(known, tmp_path / "in")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("projects")
    (folder / "halve.mlx").write_text(HALVE)
    for number in (1, 2):
        cloud(folder / "in" / "meshes" / f"m{number}.ply", 50, number)
        project(folder / "in" / f"p{number}.mlp", f"meshes/m{number}.ply")
    return folder


def test_a_project_is_done_again_when_any_of_its_files_has_changed(place, monkeypatch):
    monkeypatch.chdir(place)
    scans = ["in/p1.mlp", "in/p2.mlp"]

    def told():
        witness = Witness()
        report = run_batch(Batch("halve.mlx", scans, "out", name="{stem}.mlp", jobs=1), witness)
        assert report.failed == ()
        return witness.sentences

    assert told() == []
    assert told() == []
    lines = [json.loads(line) for line in (place / "out/batch.jsonl").read_text().splitlines()]
    written = [name for line in lines for name in line["output_files"]]
    assert len(written) == len(set(written)) == 2
    assert [list(line["input_files"]) for line in lines] == [["meshes/m1.ply"], ["meshes/m2.ply"]]
    first, second = (place / "out" / name for name in written)
    before, other = first.read_bytes(), second.read_bytes()
    assert lines[0]["output_files"][written[0]] == hashlib.sha256(before).hexdigest()
    first.unlink()
    assert told() == ["in/p1.mlp is done again: a file of its result is gone or has been changed"]
    assert first.read_bytes() == before
    cloud(place / "in/meshes/m1.ply", 60, 1)
    assert told() == ["in/p1.mlp is done again: a file behind the scan has changed"]
    assert b"element vertex 60" in first.read_bytes()
    assert second.read_bytes() == other
    assert told() == []


def test_the_meshes_of_a_project_are_not_written_over(place, monkeypatch):
    monkeypatch.chdir(place)
    before = (place / "in/meshes/m2.ply").read_bytes()
    for how in (
        {"folder": "in/meshes", "name": "m2.ply"},
        {"summary": "in/meshes/m2.ply"},
        {"log": "in/meshes/m2.ply"},
    ):
        with pytest.raises(FileError, match="would overwrite"):
            run_batch(
                Batch(**({"script": "halve.mlx", "inputs": ["in/p2.mlp"], "folder": "x"} | how))
            )
    assert (place / "in/meshes/m2.ply").read_bytes() == before
