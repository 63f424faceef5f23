"""The picture of the page on deviation: the bust of Nefertiti against her own mirror image.

SYMRECON_DATA=/path/to/models python benchmarks/deviation_picture.py docs/pictures/deviation.png

A window is cut out of her chest first, to show what is said where nothing was measured.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pymeshlab

from meshlab_symrecon.pictures.deviation_map import deviation_picture
from meshlab_symrecon.symmetry.detection import detect_reflection_planes
from meshlab_symrecon.symmetry.deviation import mirror_deviation

SAMPLES = 20_000
COLUMN = np.array([52.0, -188.0])  # the window's middle, seen from before, in millimetres
RADIUS = 30.0


def main() -> None:
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(Path(os.environ["SYMRECON_DATA"], "meshes/nefertiti.ply")))
    points = meshes.current_mesh().vertex_matrix()
    faces = meshes.current_mesh().face_matrix().astype(np.int64)
    column = np.linalg.norm(points[:, :2] - COLUMN, axis=1) < RADIUS
    window = column & (points[:, 2] > 0.0)
    faces = faces[~window[faces].all(axis=1)]
    seen = np.random.default_rng(0).permutation(np.unique(faces))[:SAMPLES]
    plane = detect_reflection_planes(points[seen]).planes[0]
    found = mirror_deviation(points, plane, faces)
    print(f"median {found.median:.2f}, 95 % {found.percentile_95:.2f}, rms {found.rms:.2f} mm")
    print(f"within {found.tolerance:.1f} mm: {found.share_within:.1%}")
    deviation_picture(
        points,
        faces,
        found.distances,
        found.has_counterpart,
        plane,
        sys.argv[1],
        unit="mm",
        title="Nefertiti and her mirror image",
        captions=(
            "Her left side\na window was cut out of the chest",
            "Her right side\ngrey: opposite the window",
        ),
    )


if __name__ == "__main__":
    main()
