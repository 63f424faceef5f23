"""How often detection is right, and how often it finds a plane where there is none.

Needs the environment variable SYMRECON_DATA: a folder with ``meshes/*.ply``, ``planes.json`` and
``make_incomplete.py``.

    python benchmarks/symmetry_success.py --seeds 401 402
    python benchmarks/symmetry_success.py --models moai falcon --conditions cut outliers

A success is a first plane within 3 degrees and 2 % of the diagonal (at the centre) of a true one.
Every reported plane is right or wrong; on models without a plane every one is wrong.

The constants in ``symmetry/confidence.py`` and ``symmetry/plinth.py`` were fitted on damage (seeds
661, 662) of nefertiti, squirrel, max_planck, column, skull, trim_star, bunny and twirl, and on made
shapes; moai, falcon, wingnut, demosthenes, sea_vase and shepherd_boy had no part in it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.symmetry.completion import mirror_complete
from meshlab_symrecon.symmetry.detection import detect_reflection_planes

CONDITIONS = {
    "region": "--n 7000 --remove .25",
    "noise": "--n 7000 --remove .35 --noise .5 --random-pose",
    "occlusion": "--n 12000 --mode occlusion",
    "cut": "--n 9000 --mode cut --remove .3 --random-pose",
    "blobs": "--n 9000 --remove .3 --blobs 3 --outliers .05 --noise .2",
    "plinth": "--n 9000 --remove .3 --plinth --noise .2 --random-pose",
    "outliers": "--n 7000 --remove .3 --plinth --outliers .2 --noise .4 --random-pose",
}


def read_points(path):
    """Read the positions of a binary PLY of float32 vertices without other properties."""
    head, _, body = path.read_bytes().partition(b"end_header\n")
    count = next(int(line.split()[2]) for line in head.splitlines() if b"element vertex" in line)
    width = sum(b"property float" in line for line in head.splitlines())
    rows = np.frombuffer(body, "<f4", count * width).reshape(count, width)
    return rows[:, :3].astype(float)


def incomplete(data, model, arguments, seed, folder):
    """Damage a model; return scan, removed points, true planes, centre and diagonal."""
    out = Path(folder) / "scan"
    mesh = str(data / "meshes" / f"{model}.ply")
    command = [sys.executable, str(data / "make_incomplete.py"), mesh, str(out), "--planes"]
    command += [str(data / "planes.json"), "--seed", str(seed), *arguments.split()]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    truth = json.loads(out.with_suffix(".json").read_text())
    planes = np.array([[*p["normal"], -p["offset"]] for p in truth["planes"]]).reshape(-1, 4)
    whole = read_points(Path(f"{out}_complete.ply"))
    centre = (whole.max(axis=0) + whole.min(axis=0)) / 2
    missing = read_points(Path(f"{out}_missing.ply"))
    return read_points(Path(f"{out}.ply")), missing, planes, centre, truth["bbox_diagonal"]


def is_right(plane, truth, centre, diagonal):
    """Tell whether a plane lies within 3 degrees and 2 % of a true one."""
    for true in truth:
        sine = np.linalg.norm(np.cross(plane[:3], true[:3]))
        sign = np.sign(plane[:3] @ true[:3])
        gap = sign * (plane[:3] @ centre + plane[3]) - (true[:3] @ centre + true[3])
        if sine < np.sin(np.radians(3.0)) and abs(gap) < 0.02 * diagonal:
            return True
    return False


def recall(scan, missing, plane, truth, diagonal):
    """Share found again of the removed points that were seen on the other side."""
    near = 0.01 * diagonal
    true = truth[np.argmax(np.abs(truth[:, :3] @ plane[:3]))]
    images = missing - 2 * np.outer(missing @ true[:3] + true[3], true[:3])
    seen = cKDTree(scan).query(images)[0] < near
    completed = mirror_complete(scan, plane).points
    found = cKDTree(completed).query(missing[seen])[0] < near
    return found.mean() if seen.any() else np.nan


def main():
    """Print both tables."""
    data = Path(os.environ["SYMRECON_DATA"])
    models = json.loads((data / "planes.json").read_text())["models"]
    known = [name for name in models if (data / "meshes" / f"{name}.ply").exists()]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", nargs="+", default=known)
    parser.add_argument("--conditions", nargs="+", default=list(CONDITIONS))
    parser.add_argument("--seeds", nargs="+", type=int, default=[401])
    options = parser.parse_args()
    totals, recalls, seconds = Counter(), [], []
    print(f"{'model':14s}" + "".join(f"{name:>12s}" for name in options.conditions))
    print("first right + nothing reported / cases (planes reported, wrong)")
    for model in options.models:
        cells = []
        for condition in options.conditions:
            cell = Counter()
            for seed in options.seeds:
                with tempfile.TemporaryDirectory() as folder:
                    scan, missing, truth, centre, diagonal = incomplete(
                        data, model, CONDITIONS[condition], seed, folder
                    )
                start = time.process_time()
                planes = detect_reflection_planes(scan).planes
                seconds.append(time.process_time() - start)
                right = [is_right(plane, truth, centre, diagonal) for plane in planes]
                kind = "positive" if len(truth) else "negative"
                cell.update(
                    cases=1, planes=len(planes), wrong=len(planes) - sum(right),
                    first=int(bool(right) and right[0]), none=int(not right),
                )  # fmt: skip
                totals.update({f"{kind} {name}": count for name, count in cell.items()})
                if right and right[0]:
                    recalls.append(recall(scan, missing, planes[0], truth, diagonal))
            cells.append(
                f"{cell['first']}+{cell['none']}/{cell['cases']} ({cell['planes']},{cell['wrong']})"
            )
        print(f"{model:14s}" + "".join(f"{text:>12s}" for text in cells), flush=True)
    for name, count in sorted(totals.items()):
        print(f"{name}: {count}")
    if recalls:
        print(
            f"recall of removed points seen on the other side: median {np.nanmedian(recalls):.3f}"
        )
    print(f"CPU seconds of a detection: median {np.median(seconds):.2f}, most {max(seconds):.2f}")


if __name__ == "__main__":
    main()
