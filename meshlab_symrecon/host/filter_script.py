"""A filter script in Python: read, checked, edited, written, run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import ScriptError
from meshlab_symrecon.host.checking import check_script
from meshlab_symrecon.host.comment_places import Comments, with_step_at, without_step_at
from meshlab_symrecon.host.document_state import DocumentState
from meshlab_symrecon.host.explanation import explained
from meshlab_symrecon.host.findings import Finding
from meshlab_symrecon.host.mlx import Script, Step
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script
from meshlab_symrecon.host.native_only import checked_for_the_window
from meshlab_symrecon.host.python_script import python_script
from meshlab_symrecon.host.resolution import Matching, find_any, matched
from meshlab_symrecon.host.script import ScriptReport, run_steps
from meshlab_symrecon.host.script_history import recorded_script
from meshlab_symrecon.host.trial import try_script
from meshlab_symrecon.host.upgrade import checked, upgraded
from meshlab_symrecon.host.written_steps import written_step
from meshlab_symrecon.plugin import Progress
from meshlab_symrecon.plugin.filter import silent

__all__ = ["FilterScript"]

IN_MEMORY = Path("script")  # what messages call a script that was never in a file


@dataclass(frozen=True, slots=True)
class FilterScript:
    """Steps in their order. It is never changed: each edit returns a new script.

    ``FilterScript()`` is empty; ``len(script)``, ``script[0]`` and ``for step in script`` look at
    its steps, which have a ``name`` and ``parameters`` as they were written.

    Attributes
    ----------
    steps : tuple of Step
    path : Path
        The file it was read from, for messages.
    comments : mapping of int to texts
        What stands above the step at a position; after the last one at one more than its position.
        They stay with their steps, and are no part of the comparison.
    """

    steps: tuple[Step, ...] = ()
    path: Path = IN_MEMORY
    comments: Comments = field(default_factory=dict, compare=False)

    @classmethod
    def read(cls, path: str | Path) -> FilterScript:
        """Read a script, of any version of MeshLab.

        Raises
        ------
        FileError, ScriptError
            As ``read_script``.
        """
        script = read_script(path)
        return cls(script.steps, script.path, script.comments)

    @classmethod
    def of(cls, mesh_set: Any) -> FilterScript:
        """Return the steps that ran on a MeshSet, or were loaded into its history.

        Numbers are exact for steps that ran through this package, or after ``load_plugins``;
        pymeshlab itself keeps six digits. Numbers of layers are positions.

        Raises
        ------
        HostError
            The history cannot be read.
        """
        script = recorded_script(mesh_set)
        return cls(script.steps, script.path)

    def __len__(self) -> int:
        return len(self.steps)

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    def __getitem__(self, position: int) -> Step:
        return self.steps[self._checked(position)]

    def check(self, mesh_set: Any = None) -> tuple[Finding, ...]:
        """Return everything that is wrong with it, and what would be mapped or ignored.

        Nothing is run. ``str`` of a finding is one line with file, line and reason.

        Parameters
        ----------
        mesh_set : pymeshlab.MeshSet, optional
            The document that it is meant for: each step is checked against what its layers will
            be then.
        """
        known = DocumentState.unknown() if mesh_set is None else DocumentState.of(mesh_set)
        return check_script(self._script, known)

    def with_step(
        self, name: str, /, *, at: int | None = None, **parameters: object
    ) -> FilterScript:
        """Return a script with one more step.

        Parameters
        ----------
        name : str
            Python name, alias or menu name, of a plugin's filter or one of MeshLab's.
        at : int, optional
            Position of the new step; at the end when left out.
        **parameters
            By their Python names.

        Raises
        ------
        UnknownFilterError, ParameterError
            No such filter or parameter, or a value of the wrong type.
        ScriptError
            There is no such position.
        """
        position = len(self.steps) if at is None else at
        if position != len(self.steps):
            self._checked(position)
        step = written_step(find_any(name), parameters)
        return replace(
            self,
            steps=(*self.steps[:position], step, *self.steps[position:]),
            comments=with_step_at(self.comments, position, len(self.steps)),
        )

    def with_values(self, position: int, /, **parameters: object) -> FilterScript:
        """Return a script in which one step has other values; its other parameters stay.

        Raises
        ------
        UnknownFilterError, ParameterError
            As ``with_step``.
        ScriptError
            There is no such position.
        """
        step = self[position]
        item = find_any(step.name)
        changed = {item.find(name).name for name in parameters}
        new = {
            param.name.lower(): param
            for param in written_step(item, parameters).parameters
            if item.find(param.name).name in changed
        }
        given = set(new)
        kept = []
        for param in step.parameters:  # of which one may be written twice
            name = param.name.strip().lower()
            if name in new or name not in given:
                kept.append(new.pop(name, param))
        steps = list(self.steps)
        steps[self._checked(position)] = replace(step, parameters=(*kept, *new.values()))
        return replace(self, steps=tuple(steps))

    def without_step(self, position: int, /) -> FilterScript:
        """Return a script that lacks one step, and the comments on it.

        What stands above the first step stays: it may be about the whole script.

        Raises
        ------
        ScriptError
            There is no such position.
        """
        gone = self._checked(position)
        return replace(
            self,
            steps=(*self.steps[:gone], *self.steps[gone + 1 :]),
            comments=without_step_at(self.comments, gone),
        )

    def upgraded(self, *, lenient: bool = False) -> FilterScript:
        """Return a script that does the same, in today's names, with comments on what changed.

        Raises
        ------
        ScriptError
            It has mistakes; ``lenient`` leaves out what cannot run.
        """
        return self._rewritten(checked(self._script, lenient=lenient))

    def native_only(self, *, lenient: bool = False) -> FilterScript:
        """Return what of it can run in MeshLab's window, in today's names.

        Raises
        ------
        ScriptError
            It has mistakes, changes the current layer or has percentages, which MeshLab's scripts
            cannot hold; ``lenient`` leaves these out. Or nothing is left of its steps.
        """
        return self._rewritten(checked_for_the_window(self._script, lenient=lenient))

    def explained(self) -> str:
        """Return in words what each step does; mistakes stand where they are made."""
        return explained(self._script, matched(self._script))

    def to_python(self, *, lenient: bool = False) -> str:
        """Return a program for pymeshlab that does the same.

        Raises
        ------
        ScriptError
            It has mistakes; ``lenient`` leaves out what cannot run.
        """
        return python_script(self._script, checked(self._script, lenient=lenient))

    def write(self, path: str | Path) -> None:
        """Write it; whole or not at all.

        Raises
        ------
        FileError, ScriptError
            As ``write_script``.
        """
        write_script(self.steps, path, self.comments)

    def run(
        self,
        mesh_set: Any,
        *,
        strict: bool = False,
        lenient: bool = False,
        isolate: bool = False,
        progress: Progress | None = None,
    ) -> ScriptReport:
        """Check all of it, then run it step by step on a MeshSet.

        Parameters
        ----------
        mesh_set : pymeshlab.MeshSet
        strict, lenient : bool
            As ``run_script``.
        isolate : bool
            Run it on a copy of the document in a child process first: when a step crashes MeshLab
            there, it is an error and the document is as it was. Takes twice the time.
        progress : callable, optional

        Raises
        ------
        ScriptError
            As ``run_script``.
        HostError
            A step crashed in the child process.
        """
        report = progress or silent
        if isolate:
            try_script(mesh_set, self._script, lenient=lenient, progress=_half(report, 0.0))
            report = _half(report, 0.5)
        return run_steps(mesh_set, self._script, strict=strict, lenient=lenient, progress=report)

    @property
    def _script(self) -> Script:
        return Script(self.path, self.steps, self.comments)

    def _rewritten(self, matching: Matching) -> FilterScript:
        new = upgraded(self._script, matching)
        return replace(self, steps=new.steps, comments=new.comments)

    def _checked(self, position: int) -> int:
        count = len(self.steps)
        if not -count <= position < count:
            message = f"the script has {count} steps, counted from 0; got position {position}"
            raise ScriptError(f"{message}; give one of them")
        return position % count


def _half(progress: Progress, start: float) -> Progress:
    return lambda fraction, message: progress(start + 0.5 * fraction, message)
