"""Make the table of MeshLab's own filters: ``python -m meshlab_symrecon.host.native_table``.

pymeshlab tells neither menu names, nor types, nor which filters kill the process, nor what they do
to a document. So each filter is run with its defaults, in a child process, on one document of each
kind: what the children write to their history gives names and types, how they end tells which kinds
are fatal. Then it is run with every other choice of each parameter, and what it needs and leaves
behind is told from all these trials. Posix only; takes about twenty minutes. The result is
committed and only read at run time. With names of filters behind the command, only these are tried
again.
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

from meshlab_symrecon.host.native_behaviour import behaviour
from meshlab_symrecon.host.native_documents import DOCUMENTS
from meshlab_symrecon.host.native_trials import TALKS, Before, Bench, variations
from meshlab_symrecon.host.translation import script_name_in_python

__all__ = ["main"]

SECONDS = 20  # for one filter on one document
RAISED = 3  # exit code of a child whose filter raised an exception: the honest way to fail


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
    mesh_set = DOCUMENTS["mesh"]()
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


def _behaviour(
    bench: Bench, before: Before, name: str, parameters: list[dict[str, Any]] | None
) -> dict[str, Any] | None:
    """Return what the trials of a filter show; None for one that is never tried."""
    if name in TALKS:
        return None
    known = parameters or []
    choices = [{}, *variations(known, bench.defaults(name))]
    trials = []
    slow: set[str] = set()  # documents on which more trials would take too long
    for values in choices:
        for document in DOCUMENTS:
            if values and (document == "empty" or document in slow):
                continue
            trials.append(bench.run(name, document, values))
            if trials[-1].ending == "slow":
                slow.add(document)
    return behaviour(trials, before, any(p["type"] == "RichMesh" for p in known))


def main() -> None:
    """Write the table to the standard output, as JSON, one filter a line.

    The menu names of filters that never end well are taken from the table that is there.
    """
    known = json.loads(files("meshlab_symrecon.host").joinpath("native_filters.json").read_bytes())
    table = {}
    with tempfile.TemporaryDirectory(prefix="symrecon-") as folder:
        bench = Bench(Path(folder))
        before = {document: bench.before(document) for document in DOCUMENTS}
        for name in pymeshlab.filter_list():
            table[name] = known.get(name, {})
            if sys.argv[1:] and name not in sys.argv[1:]:
                continue
            facts = _facts(name, Path(folder))
            facts["menu"] = facts["menu"] or table[name].get("menu")
            facts["behaviour"] = _behaviour(bench, before, name, facts["parameters"])
            table[name] = facts
    lines = (f"{json.dumps(name)}: {json.dumps(facts)}" for name, facts in table.items())
    sys.stdout.write("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
