"""Make the table of MeshLab's own filters: ``python -m meshlab_symrecon.host.native_table``.

pymeshlab tells neither menu names, nor types, nor which filters kill the process. So each filter
is run with its defaults, in a child process, on one document of each kind: what the children
write to their history gives names and types, how they end tells which kinds are fatal. Posix only;
takes a few minutes. The result is committed and only read at run time.
"""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pymeshlab

from meshlab_symrecon.host.translation import script_name_in_python

__all__ = ["DOCUMENTS", "main"]

SECONDS = 20  # for one filter on one document
RAISED = 3  # exit code of a child whose filter raised an exception: the honest way to fail


def _mesh() -> Any:
    """Return two closed meshes with colours, quality and selections."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_cube()
    mesh_set.create_sphere(subdiv=2)
    mesh_set.compute_color_by_function_per_vertex()
    mesh_set.compute_color_by_function_per_face()
    mesh_set.compute_scalar_by_function_per_vertex(q="x")
    mesh_set.compute_scalar_by_function_per_face(q="x0")
    mesh_set.compute_selection_by_condition_per_vertex(condselect="x>0.3")
    mesh_set.compute_selection_by_condition_per_face(condselect="x0>0.3")
    return mesh_set


def _textured() -> Any:
    mesh_set = _mesh()
    mesh_set.compute_texcoord_parametrization_triangle_trivial_per_wedge(sidedim=0, textdim=256)
    mesh_set.compute_texmap_from_color(textname="colours.png")
    return mesh_set


def _sheet() -> Any:
    """Return a mesh with a boundary and texture coordinates a vertex, and clouds."""
    mesh_set = _cloud()
    mesh_set.create_grid(numvertx=12, numverty=12)
    mesh_set.compute_texcoord_parametrization_flat_plane_per_wedge()
    mesh_set.compute_texcoord_transfer_wedge_to_vertex()
    return mesh_set


def _cloud() -> Any:
    """Return two clouds with normals that lie almost on each other."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    directions = np.random.default_rng(0).normal(size=(500, 3))
    normals = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    for shift in (0.0, 0.01):
        points = normals * [1.0, 2.0, 3.0] + shift
        mesh_set.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_normals_matrix=normals))
    return mesh_set


def _void() -> Any:
    """Return one layer from which every vertex was deleted."""
    mesh_set = _cloud()
    mesh_set.set_selection_all()
    mesh_set.meshing_remove_selected_vertices()
    return mesh_set


def _empty() -> Any:
    return pymeshlab.MeshSet(verbose=False)


DOCUMENTS: dict[str, Callable[[], Any]] = {
    "mesh": _mesh,
    "textured": _textured,
    "sheet": _sheet,
    "cloud": _cloud,
    "void": _void,
    "empty": _empty,
}


def _in_child(task: Callable[[], None], folder: Path) -> int:
    """Return how the child ended: 0, ``RAISED``, or minus the signal that killed it."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    os.chdir(folder)
    ending = RAISED
    try:
        task()
        ending = 0
    finally:
        os._exit(ending)


def _run(name: str, document: str, script: Path) -> None:
    mesh_set = DOCUMENTS[document]()
    mesh_set.clear_filter_script()
    signal.alarm(SECONDS)
    mesh_set.apply_filter(name)
    mesh_set.save_filter_script(str(script))


def _facts(name: str, folder: Path) -> dict[str, Any]:
    fatal = {}
    element = None
    for document in DOCUMENTS:
        script = folder / f"{name}-{document}.mlx"
        ending = _in_child(partial(_run, name, document, script), folder)
        if ending < 0 and ending != -signal.SIGALRM:
            fatal[document] = signal.Signals(-ending).name
        if ending == 0 and element is None:
            element = ElementTree.parse(script).getroot().find("filter")  # noqa: S314  our own file
    facts: dict[str, Any] = {
        "menu": None if element is None else element.get("name"),
        # A filter that draws aborts for lack of a window wherever it gets as far as drawing.
        "display": fatal.get("textured") == "SIGABRT" and "empty" not in fatal,
        "fatal": fatal,
        "probed": element is None,
    }
    if element is None:
        probe = folder / f"{name}.json"
        ending = _in_child(partial(_probe, name, probe), folder)
        return facts | {"parameters": json.loads(probe.read_bytes()) if ending == 0 else None}
    return facts | {"parameters": [_declared(parameter) for parameter in element.iter("Param")]}


def _declared(parameter: ElementTree.Element) -> dict[str, Any]:
    script_name = parameter.get("name", "")
    facts: dict[str, Any] = {
        "name": script_name_in_python(script_name),
        "script_name": script_name,
        "type": parameter.get("type"),
    }
    count = int(parameter.get("enum_cardinality", "0"))
    if count:
        facts["words"] = [parameter.get(f"enum_val{number}") for number in range(count)]
    return facts


def _probe(name: str, answer: Path) -> None:
    """Tell types from defaults, and from what pymeshlab says to a wrong value.

    A layer's number is guessed from the parameter's name, and the case of that name in scripts
    stays unknown. A camera among the parameters makes pymeshlab leave the process.
    """
    mesh_set = _mesh()
    found = []
    for parameter, default in mesh_set.filter_parameter_values(name).items():
        facts: dict[str, Any] = {"name": parameter, "script_name": parameter}
        found.append(facts | _probed_type(mesh_set, name, parameter, default))
    answer.write_text(json.dumps(found), encoding="utf-8")


def _probed_type(mesh_set: Any, name: str, parameter: str, default: Any) -> dict[str, Any]:
    refusal = ""
    try:
        mesh_set.filter_parameter_values(name, **{parameter: "no such word"})
    except Exception as error:  # noqa: BLE001  the message is what is asked for
        refusal = str(error)
    if "Possible values are" in refusal:
        return {"type": "RichEnum", "words": re.findall(r"'([^']*)';", refusal)}
    if "Percentage" in refusal:
        return {"type": "RichAbsPerc"}
    simple = {bool: "RichBool", int: "RichInt", float: "RichFloat", str: "RichString"}
    if type(default) is int and re.search("mesh|cloud", parameter):
        return {"type": "RichMesh"}
    if type(default) in simple:
        return {"type": simple[type(default)]}
    if isinstance(default, np.ndarray):
        return {"type": "RichMatrix44f" if default.size == 16 else "RichPosition"}
    return {"type": "RichColor" if isinstance(default, pymeshlab.Color) else "RichShotf"}


def main() -> None:
    """Write the table to the standard output, as JSON, one filter a line.

    The menu names of filters that never end well are taken from the table that is there.
    """
    known = json.loads(files("meshlab_symrecon.host").joinpath("native_filters.json").read_bytes())
    table = {}
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        for name in pymeshlab.filter_list():
            facts = _facts(name, Path(folder))
            facts["menu"] = facts["menu"] or known.get(name, {}).get("menu")
            table[name] = facts
    lines = (f"{json.dumps(name)}: {json.dumps(facts)}" for name, facts in table.items())
    sys.stdout.write("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
