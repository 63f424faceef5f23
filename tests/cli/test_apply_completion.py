"""Mirror-Complete Points on files: what comes back, and what is said of what is wrong."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon import apply_filter
from meshlab_symrecon.errors import SymReconWarning
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_as_quads
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.plugin import Layer
from meshlab_symrecon.provenance import INVENTED, MEASURED

COMPLETE = "generate_mirror_completed_points"
NO_FACES = np.zeros((0, 3), dtype=np.int64)
BEYOND = np.array([1.0, 0.0, 0.0, -1e3])


def read(path):
    mesh_set = load(path)
    return read_layer(mesh_set, mesh_set.current_mesh_id())


def write(path, points, faces=NO_FACES, **attributes):
    mesh_set = new_document()
    add_layer(mesh_set, Layer(points, faces, "layer", **attributes), current=True)
    save_current(mesh_set, path)
    return path


@pytest.fixture
def sheet(tmp_path, statue, plane):
    """A file with the statue's mirror plane, or with others."""

    def draw(planes=plane):
        corners, faces = planes_as_quads(np.atleast_2d(planes), read(statue).points)
        return write(tmp_path / f"{PLANES_LABEL}.ply", corners, faces)

    return draw


def write_floats(path, points, kind):
    """A PLY of float or double coordinates, byte for byte as given."""
    name = {np.float32: "float", np.float64: "double"}[kind]
    properties = "".join(f"property {name} {axis}\n" for axis in "xyz")
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{properties}"
    path.write_bytes((head + "end_header\n").encode() + points.astype(kind).tobytes())
    return path


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_measured_points_come_back_bit_for_bit(run, statue, sheet, tmp_path, kind):
    points = (read(statue).points + 1.0 / 3.0).astype(kind)
    moved = write_floats(tmp_path / "scan.ply", points, kind)
    given = read(moved).points
    assert np.array_equal(given, points.astype(np.float64))
    result = run("apply", COMPLETE, sheet(), moved, "-o", tmp_path / "out.ply", "--blend", "0")
    assert result.exit_code == 0, result.stderr
    made = read(tmp_path / "out.ply")
    assert np.array_equal(made.points[: len(points)], given)
    assert len(made.points) > len(points) + 100
    assert np.array_equal(made.quality, np.arange(len(made.points)) >= len(points))
    result = run("apply", COMPLETE, sheet(), tmp_path / "out.ply", "-o", tmp_path / "again.ply",
                 "--blend", "0")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    again = read(tmp_path / "again.ply")
    assert np.array_equal(again.points[: len(made.points)], made.points)
    assert np.array_equal(again.quality, np.arange(len(again.points)) >= len(points))


def test_the_options_of_the_filter(run, statue, sheet, plane, tmp_path):
    both = sheet(np.stack([plane, [0.0, 1.0, 0.0, -1.3]]))
    out = tmp_path / "out.ply"
    result = run("apply", COMPLETE, both, statue, "-o", out, "--plane", "0", "--paint", "true",
                 "--blend", "0")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    made, count = read(out), len(read(statue).points)
    source = reflect(made.points[count:], plane)
    scan = made.points[:count]
    assert all(np.abs(scan - image).sum(axis=1).min() < 1e-4 for image in source[::50])
    colours = np.where(made.quality[:, np.newaxis] == 0.0, MEASURED, INVENTED)
    assert np.array_equal(np.round(255.0 * made.colours[:, :3]), colours)


def test_custom_scalars_of_a_document_are_carried(statue, plane):
    points = read(statue).points
    mesh_set = pymeshlab.MeshSet(verbose=False)
    add_layer(mesh_set, Layer(points, NO_FACES, "scan", quality=2.0 + points[:, 0]), current=True)
    mesh_set.current_mesh().add_vertex_custom_scalar_attribute(points[:, 2].copy(), "depth")
    corners, faces = planes_as_quads(plane[np.newaxis], points)
    add_layer(mesh_set, Layer(corners, faces, PLANES_LABEL), current=False)
    with pytest.warns(SymReconWarning, match="the scan has no normals"):
        apply_filter(mesh_set, COMPLETE, blend=0.0)
    made = read_layer(mesh_set, mesh_set.current_mesh_id())
    count = len(points)
    assert set(made.attributes) == {"depth", "scan_quality", "mirrored"}
    depth, quality = made.attributes["depth"], made.attributes["scan_quality"]
    assert np.array_equal(depth[:count], points[:, 2])
    assert np.array_equal(quality[:count], 2.0 + points[:, 0])
    pairs = {tuple(row) for row in np.stack([points[:, 2], 2.0 + points[:, 0]], axis=1).tolist()}
    assert {tuple(row) for row in np.stack([depth, quality], axis=1)[count:].tolist()} <= pairs
    assert np.array_equal(made.attributes["mirrored"], made.quality)


def test_a_mesh_is_completed_by_its_vertices(run, sheet, statue, tmp_path):
    points = read(statue).points
    faces = np.stack([np.arange(99), np.arange(1, 100), np.arange(2, 101)], axis=1)
    mesh = write(tmp_path / "mesh.ply", points, faces)
    result = run("apply", COMPLETE, sheet(), mesh, "-o", tmp_path / "out.ply")
    assert result.exit_code == 0, result.stderr
    made = read(tmp_path / "out.ply")
    assert np.array_equal(made.points[: len(points)], read(mesh).points)
    assert len(made.faces) == 0


def test_without_planes_the_scan_is_written_with_a_warning(run, statue, tmp_path):
    result = run("apply", COMPLETE, statue, "-o", tmp_path / "out.ply")
    assert result.exit_code == 0
    assert "there is no layer 'reflection planes', so nothing was mirrored" in result.stderr
    assert np.array_equal(read(tmp_path / "out.ply").points, read(statue).points)


# --- mistakes -------------------------------------------------------------------------------------


def refused(run, tmp_path, *files, options=()):
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    result = run("apply", COMPLETE, *files, "-o", tmp_path / "out.ply", *options)
    assert result.exit_code == 1, result.output
    (sentence,) = result.stderr.splitlines()
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    return sentence


def cloud(count=60):
    return np.random.default_rng(4).normal(size=(count, 3))


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (cloud(4), "got 4 points; load a fuller scan"),
        (cloud() * [1.0, 0.0, 0.0], "got 60 points on one line"),
        (cloud() * [1.0, 1.0, 0.0], "got 60 points in one plane"),
        (np.repeat(cloud(1), 100, axis=0), "got 100 points that all coincide"),
        (cloud() * 1e200, "with which nothing can be measured"),
        (cloud() * 1e-310, "got an extent of"),
    ],
    ids=["four", "line", "flat", "one", "giant", "denormal"],
)
def test_clouds_that_cannot_be_completed(run, sheet, tmp_path, points, said):
    scan = write_floats(tmp_path / "scan.ply", points, np.float64)
    assert said in refused(run, tmp_path, sheet(), scan)


def test_points_that_are_no_numbers_are_left_out_and_told(run, statue, sheet, tmp_path):
    points = read(statue).points
    scan = write_floats(tmp_path / "scan.ply", np.insert(points, 7, np.nan, axis=0), np.float64)
    result = run("apply", COMPLETE, sheet(), scan, "-o", tmp_path / "out.ply")
    assert result.exit_code == 0
    assert "1 of" in result.stderr
    assert "not numbers; MeshLab left them out" in result.stderr
    assert np.array_equal(read(tmp_path / "out.ply").points[: len(points)], points)


def test_an_empty_cloud(run, sheet, tmp_path):
    scan = write_floats(tmp_path / "scan.ply", np.zeros((0, 3)), np.float64)
    refused(run, tmp_path, sheet(), scan)


def test_the_planes_as_the_current_layer(run, sheet, statue, tmp_path):
    said = refused(run, tmp_path, statue, sheet())
    assert "needs the scan as the current layer; got layer" in said


def test_a_plane_that_misses_the_scan(run, sheet, statue, tmp_path):
    said = refused(run, tmp_path, sheet(BEYOND), statue)
    assert "a mirror plane must pass through the scan; got plane 0 at" in said
    assert "diagonals from it" in said


def test_planes_that_are_not_flat(run, statue, tmp_path):
    dome = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0.0]])
    path = write(tmp_path / f"{PLANES_LABEL}.ply", dome, np.array([[0, 1, 2], [0, 2, 3]]))
    assert "piece 0 of the planes layer must be a flat patch" in refused(
        run, tmp_path, path, statue
    )


def test_a_planes_layer_without_faces(run, statue, tmp_path):
    path = write(tmp_path / f"{PLANES_LABEL}.ply", cloud(4))
    assert "has no faces; detect planes first" in refused(run, tmp_path, path, statue)


def test_a_plane_number_that_is_too_high(run, sheet, statue, tmp_path):
    said = refused(run, tmp_path, sheet(), statue, options=("--plane", "1"))
    assert "0 to 0; got 1; use -1 for all" in said


def test_onlyselected_without_a_selection(run, sheet, statue, tmp_path):
    said = refused(run, tmp_path, sheet(), statue, options=("--onlyselected", "true"))
    assert "onlyselected needs a selection; layer" in said
    assert "has none; select what the filter shall look at" in said


@pytest.mark.parametrize("copies", [2, 100])
def test_copies_of_points_change_nothing(run, sheet, statue, tmp_path, copies):
    points = read(statue).points[::4]
    counts = []
    for times in (1, copies):
        scan = write_floats(tmp_path / "scan.ply", np.repeat(points, times, axis=0), np.float64)
        result = run("apply", COMPLETE, sheet(), scan, "-o", tmp_path / "out.ply", "--blend", "0")
        assert result.exit_code == 0, result.stderr
        made = read(tmp_path / "out.ply")
        counts.append(made.points[times * len(points) :])
    assert len(counts[0]) > 10
    assert np.allclose(counts[0], counts[1], atol=1e-6)


def test_five_points_are_enough(run, tmp_path):
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0.0], [-0.5, 0, 1]])
    corners, faces = planes_as_quads(np.array([[1.0, 0, 0, 0]]), points)
    drawn = write(tmp_path / f"{PLANES_LABEL}.ply", corners, faces)
    scan = write_floats(tmp_path / "scan.ply", points, np.float64)
    result = run("apply", COMPLETE, drawn, scan, "-o", tmp_path / "out.ply")
    assert result.exit_code == 0, result.stderr
    assert np.array_equal(read(tmp_path / "out.ply").points[:5], points)
