"""Trials of MeshLab's filters, each in a child process: how it ended, and what it left behind.

Posix only. The documents are made once, before the children are forked from them.
"""

from __future__ import annotations

import json
import os
import resource
import signal
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from meshlab_symrecon.host.document_state import FACTS, DocumentState
from meshlab_symrecon.host.native_documents import DOCUMENTS

__all__ = ["TALKS", "Before", "Bench", "Trial", "variations"]

Before = Mapping[str, tuple[Sequence[tuple[int, str]], int]]  # by document: layers, current

SECONDS = 4.0  # of the processor, for one trial
BYTES = 4 << 30  # of memory, for one trial
TALKS = frozenset({"export_mesh_to_sketchfab"})  # to a server; never tried
# What a filter is given in every trial, where its defaults lead nowhere or take too long.
GIVEN: Mapping[str, Mapping[str, Any]] = {
    "compute_mls_projection_apss": {"controlmesh": 1, "proxymesh": 0},
    "compute_mls_projection_rimls": {"controlmesh": 1, "proxymesh": 0},
    "compute_texmap_from_color": {"textname": "painted.png", "textw": 64, "texth": 64},
    "generate_sampling_volumetric": {"samplevolnum": 500},
    "generate_voronoi_scaffolding": {"samplevolnum": 500, "voxelres": 10},
    "set_texture_per_mesh": {"use_dummy_texture": True, "textname": "dummy.png"},
    "transfer_attributes_to_texture_per_vertex": {
        "sourcemesh": 0, "targetmesh": 1, "textname": "painted.png", "textw": 64, "texth": 64
    },
}  # fmt: skip
# Filters whose parameters hold a camera: asking pymeshlab for their defaults ends the process.
HOLD_A_CAMERA = frozenset({"raster_alignment_mutual_information", "set_camera_per_raster"})


@dataclass(frozen=True, slots=True)
class Trial:
    """One run of a filter on one document.

    Attributes
    ----------
    filter, document : str
    values : mapping
        What was given otherwise than by default; a word of an enum by its number.
    ending : str
        ``ran``, ``refused`` (an exception), ``slow``, or the signal that ended the process.
    message : str
        Of the exception.
    layers : list of [int, str]
        Afterwards: each layer's identifier, and which of ``FACTS`` hold, as y and n.
    current : int
        Identifier of the current layer afterwards, -1 for none.
    """

    filter: str
    document: str
    values: Mapping[str, Any]
    ending: str
    message: str = ""
    layers: tuple[tuple[int, str], ...] = ()
    current: int = -1

    def line(self) -> str:
        """Return the trial as a line of JSON."""
        return json.dumps(asdict(self))


class Bench:
    """The documents, and the process from which the children are forked."""

    def __init__(self, folder: Path) -> None:
        os.chdir(folder)
        self.documents = {name: make() for name, make in DOCUMENTS.items()}

    def before(self, document: str) -> tuple[list[tuple[int, str]], int]:
        """Return what a document is before a trial: its layers, and which is current."""
        return _observed(self.documents[document])

    def run(self, name: str, document: str, values: Mapping[str, Any]) -> Trial:
        """Run a filter on a document in a child process."""

        def task() -> dict[str, Any]:
            mesh_set = self.documents[document]
            try:
                mesh_set.apply_filter(name, **{**GIVEN.get(name, {}), **values})
            except Exception as error:  # noqa: BLE001  how it fails is what is asked
                return {"ending": "refused", "message": " ".join(str(error).split())[:300]}
            layers, current = _observed(mesh_set)
            return {"ending": "ran", "layers": layers, "current": current}

        answer = _in_child(task)
        return Trial(name, document, dict(values), **answer)

    def defaults(self, name: str) -> tuple[Mapping[str, Any], ...]:
        """Return the plain defaults of a filter, by Python name, on documents that differ."""

        def task(document: str) -> dict[str, Any]:
            found = self.documents[document].filter_parameter_values(name)
            plain = (bool, int, float)
            kept = {key: value for key, value in found.items() if type(value) in plain}
            return {"ending": "ran", "defaults": kept}

        if name in HOLD_A_CAMERA:
            return ()
        found = []
        for document in ("complete", "plain mesh", "rough cloud"):
            answer = _in_child(partial(task, document)).get("defaults", {})
            found.append({**answer, **GIVEN.get(name, {})})
        return tuple(found)


def variations(
    parameters: list[dict[str, Any]], defaults: tuple[Mapping[str, Any], ...]
) -> Iterator[dict[str, Any]]:
    """Yield each choice of one parameter that is not its only default: switches, words, layers."""
    for parameter in parameters:
        name = parameter["name"]
        known = {answer[name] for answer in defaults if name in answer}
        if not known:
            continue
        choices: dict[str, list[Any]] = {
            "RichBool": [False, True],
            "RichEnum": list(range(len(parameter.get("words", ())))),
            "RichMesh": [0, 1, 2],
        }
        for choice in choices.get(parameter["type"], []):
            if known != {choice}:
                yield {name: choice}


def _observed(mesh_set: Any) -> tuple[list[tuple[int, str]], int]:
    identifiers = [int(mesh.id()) for mesh in mesh_set]
    state = DocumentState.of(mesh_set)
    words = ["".join("ny"[layer.facts[fact]] for fact in FACTS) for layer in state.layers]
    current = -1 if state.current is None else identifiers[state.current]
    return list(zip(identifiers, words, strict=True)), current


def _in_child(task: Any) -> dict[str, Any]:
    """Return what the task returned in a child process, or how the child ended."""
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        os.close(reader)
        _answer(task, writer)
    os.close(writer)
    with os.fdopen(reader, "rb") as answers:
        answer = answers.read()
    ending = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if ending == 0:
        told: dict[str, Any] = json.loads(answer)
        return told
    if ending in (-signal.SIGPROF, -signal.SIGALRM):
        return {"ending": "slow"}
    return {"ending": signal.Signals(-ending).name if ending < 0 else f"exit {ending}"}


def _answer(task: Any, writer: int) -> None:
    """Do the task, write what it returns, and leave the process."""
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    signal.setitimer(signal.ITIMER_REAL, 10.0 * SECONDS)
    try:
        os.write(writer, json.dumps(task()).encode())
    except BaseException:  # noqa: BLE001  nothing of the parent may run on in the child
        os._exit(4)
    os._exit(0)
