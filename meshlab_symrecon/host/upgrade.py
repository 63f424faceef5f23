"""An old script in today's names: each step as MeshLab writes it now, below what changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from meshlab_symrecon.host.findings import ERROR, IGNORE, Finding, check_findings
from meshlab_symrecon.host.mlx import Script, Step
from meshlab_symrecon.host.old_names import NOTHING
from meshlab_symrecon.host.resolution import Matching, ResolvedStep, matched
from meshlab_symrecon.host.step_of_today import steps_today
from meshlab_symrecon.plugin import Filter

__all__ = ["Upgrade", "checked", "comments_of", "upgraded"]


@dataclass(frozen=True, slots=True)
class Upgrade:
    """A script of today.

    Attributes
    ----------
    steps : tuple of Step
    comments : mapping of int to texts
        What stands above the step at a position; after the last one at one more than its position.
    unchanged : bool
        The old script says the same already, word for word.
    """

    steps: tuple[Step, ...]
    comments: Mapping[int, tuple[str, ...]]
    unchanged: bool


def upgraded(script: Script, matching: Matching) -> Upgrade:
    """Write every step that can run under its name of today.

    Run by ``run_script``, the new script does what the old one does. What cannot run, and what
    MeshLab does by itself today, is left out; a comment says so.

    Parameters
    ----------
    script : Script
    matching : Matching
        Of that script. Its own comments stay above the steps they stand above.
    """
    before = script.comments
    steps: list[Step] = []
    kept: dict[int, tuple[str, ...]] = {}
    for number, (old, resolved) in enumerate(zip(script.steps, matching.steps, strict=True)):
        own = tuple(before.get(number, ()))
        new, following = (None, None) if resolved is None else steps_today(resolved)
        said = _changes(old, resolved, new, comments_of(matching.findings, number))
        fresh = tuple(f" {words} " for words in said if not _is_said(words, own))
        if own or fresh:
            kept[len(steps)] = (*kept.get(len(steps), ()), *own, *fresh)
        if new is not None:
            steps.append(new)
        if following is not None:
            kept[len(steps)] = (f" {_follows(old, following)} ",)
            steps.append(following)
    last = tuple(before.get(len(script.steps), ()))
    if last:
        kept[len(steps)] = (*kept.get(len(steps), ()), *last)
    added = sum(map(len, kept.values())) > sum(map(len, before.values()))
    return Upgrade(tuple(steps), kept, tuple(steps) == script.steps and not added)


def checked(script: Script, *, lenient: bool = False) -> Matching:
    """Match a script with what is there today, and refuse it for its mistakes.

    Raises
    ------
    ScriptError
        All mistakes, one a line; with ``lenient`` only those that nothing can be left out for.
    """
    matching = matched(script)
    check_findings(matching.findings, lenient=lenient)
    return matching


def comments_of(findings: Sequence[Finding], number: int) -> tuple[tuple[int, str], ...]:
    """Return line and words of what was found about one step, in one line each."""
    return tuple(
        (finding.line, _one_line(finding)) for finding in findings if finding.step == number
    )


def _one_line(finding: Finding) -> str:
    words = " ".join(finding.message.split())
    what = "" if finding.remedy == IGNORE else "this step was "
    return f"{what}left out: {words}" if finding.severity == ERROR else words


def _is_said(words: str, comments: Sequence[str]) -> bool:
    """Say whether a comment of an earlier upgrade has these words, whatever line it names."""
    sentence = words.partition(": ")[2] if words.startswith("line ") else words
    return any(sentence in comment for comment in comments)


def _follows(old: Step, following: Step) -> str:
    where = f"line {old.line}: " if old.line else ""
    words = f"'{old.name.strip()}' did this by itself; leave '{following.name}' out for clouds"
    return f"{where}{words}"


def _changes(
    old: Step,
    resolved: ResolvedStep | None,
    new: Step | None,
    found: Sequence[tuple[int, str]],
) -> list[str]:
    """Return in words what is different about a step, with the lines of the old script."""
    said = list(found)
    name = old.name.strip()
    if resolved is not None and resolved.filter == NOTHING:
        said = [(line, f"'{name}' left out: {words}") for line, words in said]
    elif new is not None:
        if old.name != new.name and not any(f"'{name}' is '" in words for _, words in said):
            said.insert(0, (old.line, f"was '{old.name}'"))
        if old.from_xml_plugin:
            said.insert(0, (old.line, "was an <xmlfilter>"))
        said += _changed_types(old, new)
        said += _filled_in(old, resolved, new)
    return [f"line {line}: {words}" if line else words for line, words in said]


def _changed_types(old: Step, new: Step) -> list[tuple[int, str]]:
    today = {param.name.lower(): param.rich_type for param in new.parameters}
    return [
        (param.line, f"parameter '{param.name}' was a {param.rich_type}")
        for param in old.parameters
        if param.rich_type not in ("", today.get(param.name.strip().lower(), param.rich_type))
    ]


def _filled_in(old: Step, resolved: ResolvedStep | None, new: Step) -> list[tuple[int, str]]:
    if resolved is None or not isinstance(resolved.filter, Filter):
        return []
    absent = [param.name for param in new.parameters if param.name not in resolved.values]
    if not absent:
        return []
    return [(old.line, f"written with their defaults: {', '.join(absent)}")]
