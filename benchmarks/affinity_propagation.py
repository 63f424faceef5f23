"""Affinity propagation beside scikit-learn's: time, memory, exemplars.

    SYMRECON_DATA=... python benchmarks/affinity_propagation.py [--sizes 500 1000 2000 4000 10000]

Data: candidate planes of cut and noisy scans of two meshes of SYMRECON_DATA/meshes, in the space in
which they are clustered; Gaussian mixtures; uniform points. Preferences: tied to the bandwidth, as
the detection of planes has them, or quantiles of the similarities; all with the same noise of 1e-6,
since without it the exemplar of a cluster of two is arbitrary. Every run has a process of its own;
CPU seconds are the best of three below a second, memory is what the process grew by. Scikit-learn
runs up to 4000 points. Jaccard: exemplars in common with scikit-learn's / exemplars of either; net:
net similarity beyond scikit-learn's, in %. Prints Markdown.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
import warnings
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree
from sklearn.cluster import AffinityPropagation as Reference
from solids import mesh_model

from meshlab_symrecon.clustering.affinity_propagation import AffinityPropagation
from meshlab_symrecon.clustering.similarities import similarity_quantile
from meshlab_symrecon.symmetry.candidates import vote
from meshlab_symrecon.symmetry.cascade import QUERIES
from meshlab_symrecon.symmetry.detection import MOST_CANDIDATES
from meshlab_symrecon.symmetry.embedding import embed_planes
from meshlab_symrecon.symmetry.exemplars import (
    BANDWIDTH,
    PREFERENCE,
    QUICK_QUERIES,
    QUICK_TOLERANCE,
    THINNING,
)
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.verification import examine

MODELS = ("nefertiti", "skull")
REFERENCE_LIMIT = 4_000  # points: 1.4 GB there
DENSE_LIMIT = 4_000
SETTINGS = {"damping": 0.7, "max_iter": 2000}
FORMS = {
    "scikit-learn": lambda preference: Reference(preference=preference, random_state=0, **SETTINGS),
    "dense": lambda preference: AffinityPropagation(
        preference=preference, n_neighbors=None, **SETTINGS
    ),
    "sparse": lambda preference: AffinityPropagation(preference=preference, **SETTINGS),
}


def candidate_planes(name):
    """Thinned candidates of a scan of which a quarter is missing, and how likely each is."""
    rng = np.random.default_rng(1)
    model = mesh_model(Path(os.environ["SYMRECON_DATA"]) / "meshes" / f"{name}.ply")
    points = model.sample(7_000, rng)
    side = points @ rng.normal(size=3)
    points = points[side < np.quantile(side, 0.75)]
    noise = 0.0025 * np.linalg.norm(np.ptp(points, axis=0))
    cloud = prepare(points + noise * rng.normal(size=points.shape), None, QUERIES)
    planes = vote(cloud, 1_200, MOST_CANDIDATES, rng).planes
    quick = examine(planes, cloud, QUICK_QUERIES, QUICK_TOLERANCE, exact=False)
    votes = quick.support - quick.contradiction
    order = np.argsort(-votes, kind="stable")
    places, votes = embed_planes(planes[order], cloud.root_covariance), votes[order]
    cells = np.floor(places / (THINNING * BANDWIDTH)).astype(np.int64)
    first = np.sort(np.unique(cells, axis=0, return_index=True)[1])
    return places[first], np.clip(votes[first] / votes.max(), 0.0, 1.0)


def bandwidth_preference(likely):
    return -PREFERENCE * BANDWIDTH**2 * (1.0 - 0.5 * likely)


def mixture(count, dimensions):
    rng = np.random.default_rng(dimensions)
    centres = 3 * rng.normal(size=(12, dimensions))
    return centres[rng.integers(12, size=count)] + 0.5 * rng.normal(size=(count, dimensions))


def cases(count):
    """Yield name, rows and preference."""
    for name in MODELS:
        places, likely = (part[:count] for part in CANDIDATES[name])
        yield f"planes of {name}, bandwidth", places, bandwidth_preference(likely)
        yield f"planes of {name}, median", places, 0.5
    uniform = np.random.default_rng(0).random((count, 9))
    for dimensions in (2, 3, 9):
        yield f"uniform {dimensions}-D, .9 quantile", uniform[:, :dimensions], 0.9
    yield "uniform 3-D, median", uniform[:, :3], 0.5
    yield "mixture 3-D, .9 quantile", mixture(count, 3), 0.9
    yield "mixture 3-D, median", mixture(count, 3), 0.5
    yield "mixture 9-D, .1 quantile", mixture(count, 9), 0.1


def with_noise(rows, preference):
    if np.ndim(preference) == 0:
        preference = similarity_quantile(rows, preference, np.random.RandomState(0))
    return preference * (1 + 1e-6 * np.random.default_rng(3).random(len(rows)))


def peak_memory():
    """MB of this process, on Linux."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024


def measure(form, rows, preference):
    """CPU seconds, MB, and the estimator; to be run in a process of its own."""
    warnings.simplefilter("ignore")
    FORMS[form](preference[:50]).fit(rows[:50])  # whatever is loaded at first use
    Path("/proc/self/clear_refs").write_text("5")  # forgets the peak
    before = peak_memory()
    seconds = []
    while not seconds or (len(seconds) < 3 and seconds[0] < 1.0):
        start = time.process_time()
        found = FORMS[form](preference).fit(rows)
        seconds.append(time.process_time() - start)
    return min(seconds), peak_memory() - before, found


def net_similarity(rows, preference, exemplars):
    squares = cKDTree(rows[exemplars]).query(rows)[0] ** 2
    squares[exemplars] = -preference[exemplars]
    return -squares.sum()


def compared(rows, preference, found, reference):
    one, other = (set(e.cluster_centers_indices_) for e in (found, reference))
    nets = [net_similarity(rows, preference, np.array(sorted(e))) for e in (one, other)]
    return len(one & other) / len(one | other), 100 * (nets[0] - nets[1]) / abs(nets[1])


def print_case(name, rows, preference):
    runs = {}
    for form in FORMS:
        limit = {"scikit-learn": REFERENCE_LIMIT, "dense": DENSE_LIMIT}.get(form, len(rows))
        if len(rows) <= limit:
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                runs[form] = pool.apply(measure, (form, rows, preference))
    sparse = runs["sparse"][2]
    cells = [str(len(rows)), name]
    for form in FORMS:
        cells.append("{:.2f} s, {:.0f} MB".format(*runs[form][:2]) if form in runs else "")
    reference = runs.get("scikit-learn")
    cells.append(f"{reference[0] / runs['sparse'][0]:.0f}" if reference else "")
    counts = {form: len(run[2].cluster_centers_indices_) for form, run in runs.items()}
    cells.append(" / ".join(str(counts.get(form, "-")) for form in FORMS))
    if reference and reference[2].n_iter_ == SETTINGS["max_iter"]:
        cells += ["not converged", ""]
    elif reference:
        pairs = [compared(rows, preference, runs[f][2], reference[2]) for f in ("dense", "sparse")]
        cells.append(" / ".join(f"{jaccard:.2f}" for jaccard, _ in pairs))
        cells.append(" / ".join(f"{net:+.2f}" for _, net in pairs))
    else:
        cells += ["", ""]
    cells.append(f"{sparse.n_edges_ / len(rows):.0f}{'' if sparse.exact_ else ', not exact'}")
    cells.append(f"{sparse.n_iter_}{'' if sparse.converged_ else ', not converged'}")
    print("|", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[500, 1000, 2000, 4000, 10_000])
    arguments = parser.parse_args()
    CANDIDATES = {name: candidate_planes(name) for name in MODELS}
    print("| points | data, preference | scikit-learn | dense | sparse | times faster", end=" ")
    print("| exemplars | Jaccard: dense / sparse | net, %: dense / sparse | edges a point", end=" ")
    print("| iterations |")
    print("|---" * 11 + "|")
    for size in arguments.sizes:
        for title, data, wanted in cases(size):
            print_case(title, data, with_noise(data, wanted))
