"""Images of textures that have one name in several scans: each result keeps its own."""

from __future__ import annotations

import numpy as np
import pytest
import survival_inputs as inputs
from batch_inputs import Witness

from meshlab_symrecon.batch import Batch, run_batch
from meshlab_symrecon.host.atomic import together
from meshlab_symrecon.host.files import load, save_current
from meshlab_symrecon.host.textures import images_named_by_contents

HALVE = """<FilterScript>
 <filter name="Transform: Scale, Normalize"><Param type="RichFloat" name="axisX" value="0.5"/>
 </filter>
</FilterScript>
"""
TRIANGLE = """mtllib in.mtl
v 0 0 0
v 1 0 0
v 1 1 0
vt 0 0
vt 1 0
vt 1 1
usemtl stone
f 1/1 2/2 3/3
"""
SEEDS = {"athena": 1, "hermes": 2, "kore": 2, "nike": 3}  # two of them have one image


@pytest.fixture
def scans(tmp_path):
    """Return OBJ files whose images all have the name ``skin.png``."""
    found = []
    for name, seed in SEEDS.items():
        folder = tmp_path / "in" / name
        folder.mkdir(parents=True)
        inputs.png(folder / "skin.png", seed)
        (folder / "in.mtl").write_text("newmtl stone\nmap_Kd skin.png\n")
        (folder / "in.obj").write_text(TRIANGLE)
        found.append(folder / "in.obj")
    (tmp_path / "out").mkdir()
    return found


def image_of(obj):
    """Return the file of the image that a result names."""
    words = obj.with_name(f"{obj.name}.mtl").read_text().split()
    return obj.parent / words[words.index("map_Kd") + 1]


def test_results_of_scans_at_once_keep_their_own_images(tmp_path, scans):
    script = tmp_path / "halve.mlx"
    script.write_text(HALVE)
    batch = Batch(script, scans, tmp_path / "out", name="{parent}.obj", jobs=2)
    assert run_batch(batch).failed == ()
    made = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    for scan in scans:
        image = image_of(tmp_path / "out" / f"{scan.parent.name}.obj")
        assert image.name.startswith("skin-")
        assert image.read_bytes() == (scan.parent / "skin.png").read_bytes()
    assert len([name for name in made if name.endswith(".png")]) == len(set(SEEDS.values()))
    image_of(tmp_path / "out/hermes.obj").write_bytes(b"edited")
    witness = Witness()
    assert run_batch(batch, witness).failed == ()
    assert len(witness.sentences) == 2
    del made["batch.jsonl"]
    assert {name: (tmp_path / "out" / name).read_bytes() for name in made} == made


@pytest.mark.parametrize("order", [1, -1])
def test_whoever_comes_first_the_names_are_the_same(tmp_path, scans, order):
    """Both have chosen their names before either is in its place: the moment of a race."""
    first, _, _, last = scans
    with together(), images_named_by_contents():
        for scan in (first, last)[::order]:
            save_current(load(scan), tmp_path / "out" / f"{scan.parent.name}.obj")
    for scan in (first, last):
        image = image_of(tmp_path / "out" / f"{scan.parent.name}.obj")
        assert image.read_bytes() == (scan.parent / "skin.png").read_bytes()
    again = tmp_path / "again"
    again.mkdir()
    with images_named_by_contents():  # of a result: it has such a name
        save_current(load(tmp_path / "out" / "nike.obj"), again / "nike.obj")
    assert image_of(again / "nike.obj").name == image_of(tmp_path / "out/nike.obj").name
    assert np.array_equal(
        load(again / "nike.obj").current_mesh().vertex_matrix(),
        load(last).current_mesh().vertex_matrix(),
    )
