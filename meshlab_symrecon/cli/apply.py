"""``symrecon apply FILTER``: one filter, with options derived from its declaration."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from meshlab_symrecon.cli.file_path import FilePath
from meshlab_symrecon.cli.long_work import LONG_NAMES, LongWork, long_options, max_points, working
from meshlab_symrecon.cli.threads import asked_threads, limited_threads
from meshlab_symrecon.errors import ParameterError

__all__ = ["apply"]

RESERVED = ("output", "json", "help", "quiet", "log", "threads", "max-points")
MAKES_FROM_NOTHING = "create_"  # native filters that need no input


class FilterGroup(click.Group):
    """A group whose commands are the filters, by any of their names.

    The options that every filter has may stand before its name; they are the filter's all the same.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the words with those before the filter's name put behind it."""
        try:
            _, named, _ = self.make_parser(ctx).parse_args(list(args))
        except click.NoSuchOption as error:
            message = (
                f"there is no option '{error.option_name}' before FILTER; the filter's own options "
                "stand behind its name"
            )
            raise click.UsageError(message, ctx) from error
        before = args[: len(args) - len(named)]
        if before[-1:] == ["--"]:
            before = before[:-1]
        parsed = super().parse_args(ctx, [*named[:1], *before, *named[1:]])
        if not named and not ctx.resilient_parsing:
            raise click.UsageError("give a FILTER; 'symrecon filters' lists them", ctx)
        return parsed

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a filter; raise our own error for an unknown one."""
        from meshlab_symrecon.errors import UnknownFilterError
        from meshlab_symrecon.host.resolution import find_any

        try:
            return _command_of(find_any(cmd_name), cmd_name)
        except UnknownFilterError:
            if ctx.resilient_parsing:  # the shell completes the line
                return None
            raise

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Return the Python names and aliases that begin so, and options as for any command."""
        from meshlab_symrecon.host.native_filters import native_filters
        from meshlab_symrecon.host.registration import registry

        own = [name for item in registry() for name in (item.python_name, *item.aliases)]
        names = [name for name in (*own, *native_filters()) if name.startswith(incomplete)]
        return [CompletionItem(name) for name in names] + super().shell_complete(ctx, incomplete)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the filter, for which libraries are loaded, with the number of threads known."""
        ctx.with_resource(limited_threads(asked_threads(args)))
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return nothing: ``symrecon filters`` lists them."""
        return []


@click.group(
    cls=FilterGroup,
    subcommand_metavar="FILTER IN... -o OUT [--PARAMETER VALUE ...]",
    no_args_is_help=True,
)
def apply(**shared: Any) -> None:
    """Run one filter, ours or MeshLab's, by any of its names.

    FILTER is a Python name, an alias or a menu name; 'symrecon apply FILTER --help' shows its own
    parameters, 'symrecon filters' lists the filters. Several inputs become layers in their order;
    the last one is the current one.

    The options below are those of every filter, before or after its name.
    """


def _shared_options(thinned: bool = True) -> list[click.Parameter]:
    path = FilePath()
    return [
        click.Option(["-o", "--output"], type=path, metavar="OUT", help="File of the result."),
        click.Option(
            ["--json"],
            type=path,
            metavar="R.json",
            help="File of the measures, parameters and versions.",
        ),
        *([max_points()] if thinned else ()),
        *long_options(),
    ]


apply.params += _shared_options()


class ParameterType(click.ParamType):  # type: ignore[type-arg]  # generic in newer clicks only
    """The type of a declared parameter."""

    def __init__(self, name: str, parse: Callable[[str], Any]) -> None:
        self.name = name
        self.parse = parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the value that a text stands for."""
        try:
            return self.parse(value)
        except ParameterError as error:
            self.fail(str(error), param, ctx)


def _command_of(item: Any, written: str) -> click.Command:
    from meshlab_symrecon.plugin import Filter

    ours = isinstance(item, Filter)
    context = {"token_normalize_func": lambda token: token.lower().replace("_", "-")}
    inputs_needed = not item.python_name.startswith(MAKES_FROM_NOTHING)
    path = FilePath()
    parameters: list[click.Parameter] = [
        click.Argument(["inputs"], nargs=-1, required=inputs_needed, type=path, metavar="IN..."),
        *_shared_options(thinned=inputs_needed),
        *(_options_of_ours(item) if ours else _options_of_native(item)),
    ]

    def run(
        inputs: tuple[Path, ...], output: Path | None, json: Path | None, **values: Any
    ) -> None:
        asked = {name: values.pop(name) for name in LONG_NAMES}
        given = {name: value for name, value in values.items() if value is not None}
        with working(asked) as work:
            _run(item, Files(inputs, output, json, given.pop("max_points", None)), given, work)

    summary = item.summary if ours else f"MeshLab's own '{item.menu_name}'."
    return click.Command(
        written, context, run, parameters, help=f"{summary}\n\nPython name: {item.python_name}"
    )


def _options_of_ours(item: Any) -> list[click.Option]:
    return [
        click.Option(
            _flags(parameter.name),
            type=ParameterType(parameter.kind.name.lower(), parameter.parse),
            metavar="VALUE",
            help=f"{parameter.label}: {parameter.tooltip} [{parameter.range_words}; "
            f"default: {parameter.default}]",
        )
        for parameter in item.parameters.declared()
    ]


def _options_of_native(item: Any) -> list[click.Option]:
    from meshlab_symrecon.host.native_values import parse_native

    return [
        click.Option(
            _flags(parameter.name),
            type=ParameterType(parameter.rich_type, partial(parse_native, parameter)),
            metavar="VALUE",
            help=parameter.rich_type.removeprefix("Rich")
            + (f" [one of {', '.join(parameter.words)}]" if parameter.words else ""),
        )
        for parameter in item.parameters
    ]


def _flags(name: str) -> list[str]:
    """Return the option's spellings and the name of its value."""
    plain = name.lower().replace("_", "-").strip("-")
    flags = [f"--parameter-{plain}" if plain in RESERVED else f"--{plain}"]
    if name == "randomseed":
        flags.append("--seed")
    return [*flags, name]


@dataclass(frozen=True, slots=True)
class Files:
    """What is read, and where the results go."""

    inputs: tuple[Path, ...]
    output: Path | None
    report: Path | None
    most: int | None  # points to which the current layer is thinned out


def _run(item: Any, files: Files, values: Mapping[str, Any], work: LongWork) -> None:
    from meshlab_symrecon.cli import reports
    from meshlab_symrecon.host.atomic import together
    from meshlab_symrecon.host.files import load, new_document, save_current
    from meshlab_symrecon.host.interruption import telling
    from meshlab_symrecon.host.paths import check_input
    from meshlab_symrecon.host.records import record_of
    from meshlab_symrecon.host.registration import apply_filter
    from meshlab_symrecon.host.run_values import noted_steps, values_of_run
    from meshlab_symrecon.host.size import check_memory
    from meshlab_symrecon.host.thinning import thin_current

    _check_files(files)
    for path in files.inputs:
        check_input(path)
    check_memory(files.inputs, most=files.most, steps=(item.python_name,), work="this filter")
    mesh_set = new_document()
    with together(), work.progress(item.menu_name) as progress:
        for path in files.inputs:
            progress(0.0, f"reading {path}")
            load(path, mesh_set)
        if files.most is not None and mesh_set.current_mesh().vertex_number() > files.most:
            progress(0.0, "thinning out")
            thin_current(mesh_set, files.most)
        before = {int(mesh.id()) for mesh in mesh_set}
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            named = telling(progress, item.menu_name)
            noted = noted_steps(mesh_set)
            measures = apply_filter(mesh_set, item.python_name, progress=named, **values)
            parameters = values_of_run(mesh_set, item, values, noted)
        made = _result_layer(mesh_set, item, before)
        if files.output is not None and made is not None:
            progress(1.0, f"writing {files.output}")
            mesh_set.set_current_mesh(made)
            record = record_of(mesh_set, files.inputs, _settings(files))
            save_current(mesh_set, files.output, record)
        if files.report is not None:
            reports.write_json(files.report, _report(item, measures, parameters, files))
    for line in reports.measures_in_words(measures):
        work.say(line)
    for sentence in _sentences(item, caught, None if made is not None else files.output):
        work.warn(sentence)


def _report(
    item: Any, measures: Mapping[str, Any], parameters: Mapping[str, Any], files: Files
) -> dict[str, Any]:
    """Return what was measured, and beside it what it was measured with."""
    from meshlab_symrecon.cli import reports
    from meshlab_symrecon.host.records import versions

    found = reports.detection(measures) if reports.is_detection(measures) else dict(measures)
    made = {"filter": item.python_name, "parameters": parameters, "versions": versions()}
    beside = made | _settings(files)
    return found | {name: value for name, value in beside.items() if name not in found}


def _settings(files: Files) -> dict[str, int]:
    """Return what the result depends on besides the filter's parameters."""
    return {} if files.most is None else {"max_points": files.most}


def _check_files(files: Files) -> None:
    """Refuse every bad output path before the work starts."""
    from meshlab_symrecon.host.paths import check_output

    outputs = [] if files.output is None else [files.output]
    if not outputs and files.report is None:
        raise click.UsageError("give -o OUT, or --json R.json, or both")
    for path in outputs:
        check_output(path, files.inputs)
    if files.report is not None:
        check_output(files.report, [*files.inputs, *outputs], ())


def _sentences(
    item: Any, caught: Sequence[warnings.WarningMessage], unwritten: Path | None
) -> list[str]:
    """Return what the filter warned of, with the file that was not written in the last one."""
    sentences = [str(warning.message) for warning in caught]
    if unwritten is not None:
        last = sentences.pop() if sentences else f"'{item.menu_name}' made no layer"
        sentences.append(f"{last}; {unwritten} was not written")
    return sentences


def _result_layer(mesh_set: Any, item: Any, before: set[int]) -> int | None:
    """Return the layer to save: a new one, or else the current one; None for nothing.

    Among several new layers it is the one that became current, or else the last.
    """
    from meshlab_symrecon.host.meshset import current_identifier

    current = current_identifier(mesh_set)
    made = [int(mesh.id()) for mesh in mesh_set if int(mesh.id()) not in before]
    if made:
        return current if current in made else made[-1]
    return None if getattr(item, "creates", ()) else current
