"""The command line of ``meshlabserver``, old and older, as plain data: nothing is opened here."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import click

from meshlab_symrecon.cli.server_job import (
    CURRENT,
    FLAGS,
    LAST,
    Job,
    Load,
    Output,
    ProjectOutput,
)

__all__ = ["parse"]

LAYERS = {"c": CURRENT, "x": LAST, "l": LAST}  # "l" is in the help text of meshlabserver
STICKY = "sa"  # holds for the outputs behind it too
WORDED = {"ascii": ("sa",), "binary": ()}  # met in scripts; binary is what happens anyway
PROJECTS = (".mlp", ".mlb", ".aln")
WRITTEN_PROJECT = ".mlp"
QT = ("-platform", "-display", "-style")  # Qt took these, with a value; there is no window here
SWITCHES = {
    "--keep-all": "keep_all",
    "--bake": "bake",
    "--strict": "strict",
    "--lenient": "lenient",
    "--dry-run": "dry_run",
    "--list-filters": "list_filters",
    "--help": "help",
    "-help": "help",
    "-h": "help",
    "--version": "version",
    "-V": "version",
}
SHORT = ("-i", "-p", "-s", "-o", "-m", "-om", "-l", "-w", "-x", "-d")
OPTIONS = (*SHORT, "--json", *(name for name in SWITCHES if name.startswith("--")))


@dataclass(slots=True)
class _Group:
    """One ``-o`` with what belongs to it."""

    paths: list[Path]
    layer: int | str | None = None
    mask: set[str] = field(default_factory=set)


class _Reader:
    """Goes through the words once; each method takes one option and what belongs to it."""

    def __init__(self, words: Sequence[str]) -> None:
        self.words = [word for word in words if word]  # split command lines hold empty words
        self.at = 0
        self.loads: list[Load] = []
        self.scripts: list[Path] = []
        self.groups: list[_Group] = []
        self.projects: list[ProjectOutput] = []
        self.masks_of_all = sum(word == "-om" for word in self.words) == 1
        self.of_all: set[str] = set()  # flags that hold for every output
        self.sticky: set[str] = set()
        self.files: dict[str, Path] = {}  # of -l, -d and --json
        self.switches: set[str] = set()
        self.notes: list[str] = []
        self.before = ""  # the option before this one
        self.takers: dict[str, Callable[[str], None]] = {
            "-i": self.take_meshes,
            "-p": self.take_projects,
            "-s": self.take_scripts,
            "-o": self.take_outputs,
            "-m": self.take_mask,
            "-om": self.take_mask,
            "-l": self.take_layer_or_log,
            "-w": self.take_project_outputs,
            "-d": self.take_file,
            "--json": self.take_file,
        }

    def read(self) -> Job:
        while self.at < len(self.words):
            option = self.words[self.at]
            self.at += 1
            self.take(option)
            if option not in ("-m", "-om", "-l"):
                self.before = option
        return self.job()

    def take(self, option: str) -> None:
        if option in SWITCHES:
            self.switches.add(SWITCHES[option])
        elif option in QT:
            self.one(option)
        elif option in self.takers:
            self.takers[option](option)
        elif option.startswith("--json="):
            self.set_file("--json", option.removeprefix("--json="))
        else:
            raise _unknown(option)

    def take_meshes(self, option: str) -> None:
        self.loads += (_load(word) for word in self.several(option))

    def take_projects(self, option: str) -> None:
        self.loads += (Load(Path(word), True) for word in self.several(option))

    def take_scripts(self, option: str) -> None:
        self.scripts += (Path(word) for word in self.several(option))

    def take_outputs(self, option: str) -> None:
        paths = [Path(word) for word in self.several(option)]
        self.groups.append(_Group(paths, mask=set(self.sticky)))

    def one(self, option: str) -> str:
        if self.at == len(self.words) or self.words[self.at].startswith("-"):
            got = f"'{self.words[self.at]}'" if self.at < len(self.words) else "none"
            raise click.UsageError(f"{option} needs a value behind it; got {got}")
        self.at += 1
        return self.words[self.at - 1]

    def several(self, option: str) -> list[str]:
        found = [self.one(option)]
        while self.at < len(self.words) and not self.words[self.at].startswith("-"):
            found.append(self.one(option))
        return found

    def take_mask(self, option: str) -> None:
        """Read flags; old scripts have one ``-om``, anywhere, or with nothing behind it."""
        words = []
        while self.at < len(self.words) and not self.words[self.at].startswith("-"):
            words += re.split(r"[\s,]+", self.one(option))
        mask = {flag for word in words if word for flag in self.flags(word)}
        self.sticky |= mask & {STICKY}
        if not self.groups or (option == "-om" and self.masks_of_all):
            self.of_all |= mask
        else:
            self.groups[-1].mask |= mask

    def flags(self, word: str) -> tuple[str, ...]:
        if word.lower() in FLAGS:
            return (word.lower(),)
        if word.lower() in WORDED:
            self.notes.append(f"'{word}' is no flag of -m; read as asking for that kind of file")
            return WORDED[word.lower()]
        raise click.UsageError(
            f"'{word}' is no flag of -m, and a file name has its place behind -i or -o; "
            f"flags are {', '.join(FLAGS)}"
        )

    def take_layer_or_log(self, option: str) -> None:
        """Read ``-l``: the layer of the ``-o`` before it, otherwise the log file."""
        behind_output = bool(self.groups) and self.before == "-o"
        following = self.words[self.at : self.at + 1]
        if behind_output and following and re.fullmatch(r"-\d+", following[0]):
            raise click.UsageError(f"-l behind -o takes a layer: N, c or x; got '{following[0]}'")
        word = self.one(option)
        if not self.groups or not (word in LAYERS or re.fullmatch("[0-9]{1,9}", word)):
            if behind_output and re.fullmatch(r"\d+|.", word):
                raise click.UsageError(f"-l behind -o takes a layer: N, c or x; got '{word}'")
            self.set_file(option, word)
            return
        group = self.groups[-1]
        if group.layer is not None:
            raise click.UsageError(f"'{group.paths[0]}' has two layers (-l); keep one")
        group.layer = LAYERS[word] if word in LAYERS else int(word)

    def take_project_outputs(self, option: str) -> None:
        for word in self.several(option):
            path = Path(word)
            if path.suffix.lower() != WRITTEN_PROJECT:
                path = Path(f"{word}{WRITTEN_PROJECT}")
                self.notes.append(f"the project is written as {path}")
            self.projects.append(ProjectOutput(path))
        if self.at < len(self.words) and self.words[self.at] == "-x":
            self.at += 1
            self.projects[-1] = replace(self.projects[-1], overwrite=True)

    def take_file(self, option: str) -> None:
        self.set_file(option, self.one(option))

    def set_file(self, option: str, word: str) -> None:
        if option in self.files:
            raise click.UsageError(f"{option} is given twice, '{self.files[option]}' and '{word}'")
        self.files[option] = Path(word)

    def job(self) -> Job:
        outputs = [
            Output(path, layer, frozenset(group.mask | self.of_all))
            for group in self.groups
            for path, layer in _with_layers(group)
        ]
        projects = list(self.projects)
        for output in [one for one in outputs if one.path.suffix.lower() == WRITTEN_PROJECT]:
            outputs.remove(output)
            projects.append(ProjectOutput(output.path))
        return Job(
            loads=tuple(self.loads),
            scripts=tuple(self.scripts),
            outputs=tuple(outputs),
            projects=tuple(projects),
            log=self.files.get("-l"),
            dump=self.files.get("-d"),
            report=self.files.get("--json"),
            notes=tuple(self.notes),
            **dict.fromkeys(self.switches, True),
        )


def parse(words: Sequence[str]) -> Job:
    """Read a command line of ``meshlabserver``.

    Options stand in any order. ``-l`` behind an ``-o`` is its layer, elsewhere the log file.
    ``-m`` belongs to the ``-o`` before it; a single ``-om``, or a ``-m`` before all of them, to
    every output. Several files behind one ``-o`` are the first layers, one each.

    Parameters
    ----------
    words : sequence of str
        Without the name of the program.

    Returns
    -------
    Job

    Raises
    ------
    click.UsageError
        An unknown option or flag, a missing value, two layers for one output, ``--strict`` with
        ``--lenient``, nothing to do, or something to save and nothing that makes it.
    """
    job = _Reader(words).read()
    if job.help or job.version:
        return job
    if job.strict and job.lenient:
        raise click.UsageError("--strict and --lenient exclude each other; keep one")
    if not (job.loads or job.scripts or job.dump or job.list_filters):
        if job.outputs or job.projects:
            raise click.UsageError("there is nothing to save: give a mesh (-i), a project (-p) "
                                   "or a script (-s) that makes one")  # fmt: skip
        raise click.UsageError("there is nothing to do; 'symrecon-server --help' shows the options")
    return job


def _load(word: str) -> Load:
    path = Path(word)
    return Load(path, path.suffix.lower() in PROJECTS)


def _with_layers(group: _Group) -> list[tuple[Path, int | str]]:
    if len(group.paths) == 1:
        layer = CURRENT if group.layer is None else group.layer
        return [(group.paths[0], layer)]
    if group.layer is not None:
        raise click.UsageError(
            f"-l names one layer, and {len(group.paths)} files stand behind its -o; "
            "write one -o for each"
        )
    return [(path, number) for number, path in enumerate(group.paths)]


def _unknown(option: str) -> click.UsageError:
    if option == "-x":
        return click.UsageError("-x has its place behind -w PROJECT.mlp")
    if not option.startswith("-"):
        return click.UsageError(f"'{option}' stands behind no option; write -i or -o before a file")
    known = ", ".join(OPTIONS)
    return click.UsageError(f"there is no option {option}; options are {known}")
