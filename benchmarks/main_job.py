"""The whole method on incomplete clouds with known answers, through the command line.

    SYMRECON_DATA=... python benchmarks/main_job.py [NAME ...]

For each cloud of SYMRECON_DATA/incomplete: the first plane's error (degrees; % of the diagonal at
the centre of the complete model), the completed cloud's recall on the removed part at 1 % of the
diagonal (of all of it, and of what exists on the other side of the true plane), and the surface.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pymeshlab
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.geometry.surfaces import enclosed_volume, topology

NEAR = 0.01  # diagonals


def load(path: Path) -> tuple[np.ndarray, np.ndarray]:
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(path))
    mesh = mesh_set.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)


def plane_error(found: np.ndarray, truth: dict, centre: np.ndarray, diagonal: float) -> tuple:
    normal = np.array(truth["normal"])
    angle = np.degrees(np.arccos(min(1.0, abs(normal @ found[:3]))))
    height = (found[:3] @ centre + found[3]) * np.sign(normal @ found[:3])
    return angle, 100 * abs(height - (normal @ centre - truth["offset"])) / diagonal


def run(name: str, folder: Path, target: Path) -> str:
    truth = json.loads(folder.joinpath(f"{name}.json").read_text())
    started = time.perf_counter()
    done = subprocess.run(
        [
            *("symrecon", "reconstruct", folder / f"{name}.ply", "-o", target / "statue.ply"),
            *("--json", target / "r.json", "--project", target / "p.mlp"),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    seconds = time.perf_counter() - started
    if done.returncode:
        return f"{name:24s} exit {done.returncode}: {done.stderr.strip()}"
    result = json.loads(target.joinpath("r.json").read_text())
    points, faces = load(target / "statue.ply")
    shape = topology(faces)
    words = f"{name:24s} {seconds:5.1f} s  "
    if result["planes"] and truth["planes"]:
        words += recall(name, folder, target, truth, np.array(result["planes"][0]["plane"]))
        words += f"confidence {result['planes'][0]['confidence']:.2f}  "
    else:
        words += f"planes {len(result['planes'])} (true: {len(truth['planes'])})  "
        words += f"[{done.stderr.strip()}]  "
    return words + (
        f"closed {shape.closed}, manifold {shape.vertex_manifold}, components "
        f"{shape.components}, genus {shape.genus}, {len(faces)} faces, "
        f"outward {enclosed_volume(points, faces) > 0}"
    )


def recall(name: str, folder: Path, target: Path, truth: dict, plane: np.ndarray) -> str:
    scan, _ = load(folder / f"{name}.ply")
    missing, _ = load(folder / f"{name}_missing.ply")
    complete, _ = load(folder / f"{name}_complete.ply")
    completed, _ = load(target / "p-completed-points.ply")
    diagonal = truth["bbox_diagonal"]
    centre = complete.mean(axis=0)
    angle, offset = min(plane_error(plane, true, centre, diagonal) for true in truth["planes"])
    true = truth["planes"][0]
    images = reflect(missing, np.append(true["normal"], -true["offset"]))
    mirrorable = cKDTree(scan).query(images)[0] < NEAR * diagonal
    hit = cKDTree(completed).query(missing)[0] < NEAR * diagonal
    return (
        f"plane {angle:.2f} deg {offset:.2f} %  recall {hit.mean():.3f} of all, "
        f"{hit[mirrorable].mean():.3f} of the {mirrorable.mean():.0%} on the other side  "
    )


def main() -> None:
    folder = Path(os.environ["SYMRECON_DATA"]) / "incomplete"
    names = sys.argv[1:] or sorted(path.stem for path in folder.glob("*.json"))
    for name in names:
        with tempfile.TemporaryDirectory() as target:
            print(run(name, folder, Path(target)), flush=True)


if __name__ == "__main__":
    main()
