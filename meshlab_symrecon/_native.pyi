"""Types of the compiled kernel; see the headers in ``native/`` for what each function computes."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

def regular_triangulation(
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
    progress: Callable[[float], object] | None = None,
) -> tuple[int, NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]: ...
def orthocentres(
    points: NDArray[np.float64], weights: NDArray[np.float64], cells: NDArray[np.int32]
) -> NDArray[np.float64]: ...
def find_poles(
    points: NDArray[np.float64], cells: NDArray[np.int32], samples: int
) -> tuple[
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.int32],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
]: ...
def curve_order(points: NDArray[np.float64]) -> NDArray[np.int32]: ...
def orientation(points: NDArray[np.float64], stage: int = 0) -> int: ...
def power_test(
    points: NDArray[np.float64], weights: NDArray[np.float64], stage: int = 0
) -> int: ...
def fine_power_determinant(
    points: NDArray[np.float64], weights: NDArray[np.float64], fused: bool
) -> float: ...
def perturbed_power_test(points: NDArray[np.float64], weights: NDArray[np.float64]) -> int: ...
def mixed_edge_polygons(
    cells: NDArray[np.int32],
    neighbours: NDArray[np.int32],
    inside: NDArray[np.uint8],
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]: ...
def power_vertices(
    centres: NDArray[np.float64],
    radii: NDArray[np.float64],
    samples: NDArray[np.int32],
    sites: NDArray[np.float64],
    sample_count: int,
    cells: NDArray[np.int32],
    chosen: NDArray[np.int32],
    reach: float,
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32]]: ...
def join_at_samples(
    positions: NDArray[np.float64],
    nearest: NDArray[np.int32],
    offsets: NDArray[np.int32],
    corners: NDArray[np.int32],
    samples: NDArray[np.float64],
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...
def contract_edges(
    points: NDArray[np.float64],
    faces: NDArray[np.int32],
    nearest: NDArray[np.int32],
    samples: NDArray[np.float64],
    spacing: NDArray[np.float64],
    weld: float,
    flat: float,
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...
def nearest_kept(
    points: NDArray[np.float64],
    reach: NDArray[np.float64],
    order: NDArray[np.int32],
    widest: float,
) -> NDArray[np.int32]: ...
def far_faces(
    points: NDArray[np.float64],
    faces: NDArray[np.int32],
    nearest: NDArray[np.int32],
    samples: NDArray[np.float64],
    spacing: NDArray[np.float64],
    multiple: float,
) -> NDArray[np.int32]: ...
def surface_topology(
    faces: NDArray[np.int32], vertex_count: int
) -> tuple[int, int, int, int, int, int, int, NDArray[np.int32]]: ...
def grow_without_loops(
    cells: NDArray[np.int32],
    wanted: NDArray[np.uint8],
    certain: NDArray[np.uint8],
    size: NDArray[np.float64],
) -> NDArray[np.uint8]: ...
def linked_pieces(
    sites: NDArray[np.float64],
    cells: NDArray[np.int32],
    room: NDArray[np.float64],
    loose: NDArray[np.uint8],
    reach: float,
) -> NDArray[np.int32]: ...
def pole_graph(
    centres: NDArray[np.float64],
    radii: NDArray[np.float64],
    samples: NDArray[np.int32],
    used: NDArray[np.uint8],
    sample_count: int,
    cells: NDArray[np.int32],
    neighbours: NDArray[np.int32],
    most_partners: int,
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]]: ...
def flatness_of_pairs(
    centres: NDArray[np.float64],
    pairs: NDArray[np.int32],
    samples: NDArray[np.float64],
    pair_samples: NDArray[np.int32],
) -> NDArray[np.float64]: ...
def evidence_paths(
    offsets: NDArray[np.int64],
    ends: NDArray[np.int32],
    lengths: NDArray[np.float32],
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    crossings: NDArray[np.float64],
    seeds: NDArray[np.uint8],
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def propagate_labels(
    offsets: NDArray[np.int64],
    ends: NDArray[np.int32],
    lengths: NDArray[np.float32],
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    flatness: NDArray[np.float64],
    radii: NDArray[np.float64],
    seeds: NDArray[np.uint8],
    offered: float,
    accepted: float,
    progress: Callable[[float], object] | None = None,
) -> NDArray[np.uint8]: ...

class MinimumCut:
    def __init__(
        self,
        offsets: NDArray[np.int64],
        ends: NDArray[np.int32],
        capacities: NDArray[np.uint16],
    ) -> None: ...
    def inner_side(
        self, ties: NDArray[np.int32], progress: Callable[[float], object] | None = None
    ) -> NDArray[np.uint8]: ...

def turn_small_pieces(
    cells: NDArray[np.int32],
    labels: NDArray[np.uint8],
    fixed: NDArray[np.uint8],
    samples: NDArray[np.int32],
    smallest: float,
) -> NDArray[np.uint8]: ...
def label_cells(
    sites: NDArray[np.float64],
    cells: NDArray[np.int32],
    neighbours: NDArray[np.int32],
    samples: int,
    centres: NDArray[np.float64],
    radii: NDArray[np.float64],
    on_balls: NDArray[np.int32],
    sides: NDArray[np.uint8],
    of_sample: NDArray[np.int32],
) -> NDArray[np.uint8]: ...
def settle_sides(
    sites: NDArray[np.float64],
    cells: NDArray[np.int32],
    neighbours: NDArray[np.int32],
    samples: int,
    sides: NDArray[np.uint8],
    smallest: int,
) -> NDArray[np.uint8]: ...
def power_shape(
    cells: NDArray[np.int32],
    neighbours: NDArray[np.int32],
    part: NDArray[np.uint8],
    centres: NDArray[np.float64],
    radii: NDArray[np.float64],
    redundancy: float,
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]: ...

class NearestField:
    def __init__(
        self,
        points: NDArray[np.float64],
        table: NDArray[np.int32],
        origin: NDArray[np.float64],
        cell: float,
    ) -> None: ...
    @property
    def shape(self) -> tuple[int, int, int]: ...
    @property
    def cell(self) -> float: ...
    def lookup(self, places: NDArray[np.float64]) -> NDArray[np.int32]: ...
    def closest(self, places: NDArray[np.float64], within: float = ...) -> NDArray[np.int32]: ...

class EvidenceRules:
    def __init__(
        self,
        *,
        tolerance: float,
        no_direction: float,
        full_direction: float,
        sideways: float,
        near_plane: float,
        no_match: float,
        rim_reach: float,
        least_gap: float,
        far: float,
        beyond: float,
        broken_off: NDArray[np.float64],
    ) -> None: ...

class RefinementRules:
    def __init__(
        self,
        *,
        reach: float,
        no_direction: float,
        full_direction: float,
        point_share: float,
        ridge: float,
        largest_turn: float,
        settled: float,
        fewest: int,
    ) -> None: ...

def examine(
    planes: NDArray[np.float64],
    queries: NDArray[np.int32],
    distinctness: NDArray[np.float64],
    field: NearestField,
    normals: NDArray[np.float64],
    oriented: NDArray[np.uint8],
    border_distance: NDArray[np.float64],
    exact: bool,
    rules: EvidenceRules,
) -> NDArray[np.float64]: ...
def landings(
    planes: NDArray[np.float64],
    queries: NDArray[np.int32],
    field: NearestField,
    normals: NDArray[np.float64],
    oriented: NDArray[np.uint8],
    border_distance: NDArray[np.float64],
    exact: bool,
    rules: EvidenceRules,
) -> tuple[
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.uint8],
]: ...
def relief(
    points: NDArray[np.float64], normals: NDArray[np.float64], radius: float
) -> NDArray[np.float64]: ...
def refine_planes(
    planes: NDArray[np.float64],
    queries: NDArray[np.int32],
    tolerances: NDArray[np.float64],
    field: NearestField,
    normals: NDArray[np.float64],
    exact: bool,
    rules: RefinementRules,
) -> NDArray[np.float64]: ...
def mirror_pairs(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    oriented: NDArray[np.uint8],
    shortest: float,
    least_cosine: float,
) -> NDArray[np.int32]: ...
def farthest_points(points: NDArray[np.float64], count: int, first: int) -> NDArray[np.int64]: ...
def propagate_sparse_affinity(
    similarities: NDArray[np.float64],
    targets: NDArray[np.int32],
    damping: float,
    most: int,
    calm: int,
    more: Callable[[NDArray[np.int32], int], tuple[NDArray[np.float64], NDArray[np.int32]] | None]
    | None = None,
) -> tuple[NDArray[np.uint8], bool, bool, int, float, int, NDArray[np.uint8]]: ...
def propagate_dense_affinity(
    similarities: NDArray[np.float64], damping: float, most: int, calm: int
) -> tuple[NDArray[np.uint8], bool, bool, int, float, int, NDArray[np.uint8]]: ...
def closest_faces(
    points: NDArray[np.float64],
    faces: NDArray[np.int32],
    normals: NDArray[np.float64],
    places: NDArray[np.float64],
    directions: NDArray[np.float64],
    least_cosine: float,
    sided: bool,
    within: float,
) -> tuple[NDArray[np.int32], NDArray[np.float64]]: ...
def stream_buffers() -> tuple[int, int]: ...
def flush_streams() -> None: ...
def set_stream_buffers(output: int, error: int) -> None: ...
def watch_signals(grace: float, sentence: str) -> int: ...
def stop_watching() -> None: ...
def acknowledge_signal() -> None: ...
def guard_folder(folder: bytes, prefix: bytes) -> None: ...
def guard_process(process: int, guarded: bool) -> None: ...
def guard_log(descriptor: int) -> None: ...
def guard_replacing(begins: bool) -> None: ...
def sweep_guarded() -> None: ...
def keep_freed_memory(keep: bool) -> None: ...
def tell_step(step: bytes) -> None: ...
