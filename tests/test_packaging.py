"""What is declared about versions, wheels and releases is true and told alike everywhere."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

import meshlab_symrecon
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.versions import versions_of_results
from meshlab_symrecon.meshlab_scripts import script_names, script_path
from meshlab_symrecon.meshlab_scripts.__main__ import main as print_paths

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]


def text(name):
    return ROOT.joinpath(name).read_text(encoding="utf-8")


PYPROJECT = tomllib.loads(text("pyproject.toml"))
PROJECT = PYPROJECT["project"]
WHEELS = PYPROJECT["tool"]["cibuildwheel"]
EXTRAS = {name: needs for name, needs in PROJECT["optional-dependencies"].items() if name != "dev"}
PYTHONS = [
    line.rpartition(" ")[2] for line in PROJECT["classifiers"]
    if re.search(r"Python :: 3\.\d+$", line)
]  # fmt: skip


def oldest(needs):
    """Return the lower bound of each requirement; it must have one, and nothing else."""
    bounds = {}
    for requirement in map(Requirement, needs):
        (bound,) = requirement.specifier
        assert bound.operator == ">=", requirement
        bounds[requirement.name] = Version(bound.version)
    return bounds


def test_the_oldest_versions_that_are_tested_are_those_that_are_declared():
    lines = [line for line in text("tests/oldest_versions.txt").splitlines() if "==" in line]
    pinned = {name: Version(version) for name, version in (line.split("==") for line in lines)}
    assert len(pinned) == len(lines)
    declared = oldest(
        [*PROJECT["dependencies"], *(need for needs in EXTRAS.values() for need in needs)]
    )
    assert pinned == declared


def test_every_extra_is_installed_where_the_oldest_versions_are_tested():
    (line,) = [line for line in text("Makefile").splitlines() if "oldest_versions.txt" in line]
    installed = re.search(r'"\.\[(.*)\]"', line)
    assert installed is not None
    assert set(installed[1].split(",")) == {"dev", *EXTRAS}


def test_the_same_extra_means_the_same_for_developers():
    ours = {Requirement(need).name: need for need in PROJECT["optional-dependencies"]["dev"]}
    for need in EXTRAS["report"]:
        assert ours[Requirement(need).name] == need


def test_what_is_installed_is_what_is_declared():
    """Fails after a change of pyproject.toml until the package is installed again."""
    needed = {Requirement(need) for need in metadata.requires("meshlab-symrecon")}
    assert {Requirement(need) for need in PROJECT["dependencies"]} <= needed
    installed = metadata.distribution("meshlab-symrecon").entry_points
    declared = {
        **{("console_scripts", name): value for name, value in PROJECT["scripts"].items()},
        **{(group, name): value for group, entries in PROJECT["entry-points"].items()
           for name, value in entries.items()},
    }  # fmt: skip
    assert {(entry.group, entry.name): entry.value for entry in installed} == declared
    for entry in installed:
        assert callable(entry.load()) or entry.group != "console_scripts"


def test_no_sources_of_the_kernel_and_no_tests_are_installed():
    names = [str(path) for path in metadata.files("meshlab-symrecon")]
    assert "meshlab_symrecon/../" not in "".join(names)
    assert not [name for name in names if re.search(r"\.[ch]pp$|CMakeLists|(^|/)test", name)]


def test_every_licence_is_installed_with_what_is_compiled():
    installed = [path for path in metadata.files("meshlab-symrecon") if "licenses" in path.parts]
    assert {path.name for path in installed} == set(PROJECT["license-files"])
    for path in installed:
        assert path.read_text(encoding="utf-8") == text(path.name)
    linked = re.findall(r"^Copyright \(c\) \d+ (\w+ \w+)", text("THIRD_PARTY.txt"), re.MULTILINE)
    assert linked == ["Wenzel Jakob", "Hudson River", "Thibaut Goetghebuer"]


def test_one_wheel_serves_every_python_with_a_stable_interface():
    (override,) = PYPROJECT["tool"]["scikit-build"]["overrides"]
    assert override["if"] == {"python-version": ">=3.12"}
    assert override["wheel"] == {"py-api": "cp312"}
    assert "STABLE_ABI" in text("meshlab_symrecon/native/CMakeLists.txt")


def test_wheels_are_built_and_tested_for_every_python_that_is_declared():
    assert PROJECT["requires-python"] == f">={PYTHONS[0]}"
    built = [re.fullmatch(r"cp3(\d+)-\*", selector)[1] for selector in WHEELS["build"]]
    assert built[: len(PYTHONS)] == [python.removeprefix("3.") for python in PYTHONS]
    workflow = text(".github/workflows/wheels.yml")
    tested = re.search(r"python: \[(.*)\]", workflow)
    assert tested is not None
    assert tested[1] == ", ".join(f'"3.{minor}"' for minor in built)


def test_wheels_are_for_what_pymeshlab_has_wheels_for():
    assert WHEELS["skip"] == ["*-musllinux_*"]
    assert WHEELS["linux"]["archs"] == ["auto64"]
    assert WHEELS["windows"]["archs"] == ["AMD64"]
    assert WHEELS["macos"]["environment"] == {"MACOSX_DEPLOYMENT_TARGET": "11.0"}


@pytest.mark.parametrize("name", ["pyproject.toml", "Makefile", ".github/workflows/wheels.yml"])
def test_the_tests_that_a_wheel_is_given_exist_and_need_only_themselves(name):
    told = re.sub(r"KERNEL_TESTS := (.*\\\n)*.*", "", text(name))  # those of make sanitize
    given = set(re.findall(r"tests/test_\w+\.py", told))
    assert given == {"tests/test_installed.py", "tests/test_arrays.py"}
    for test in given:
        assert "ROOT" not in text(test)
        assert "__file__" not in text(test)


def test_the_targets_that_the_workflow_makes_exist():
    targets = re.findall(r"run: make ([\w-]+)", text(".github/workflows/wheels.yml"))
    assert set(targets) == {"sdist", "test-oldest"}
    for target in (*targets, "wheel"):
        assert re.search(rf"^{target}:", text("Makefile"), re.MULTILINE), target


def test_the_workflow_runs_actions_that_nobody_can_exchange():
    uses = re.findall(r"uses: (.*)", text(".github/workflows/wheels.yml"))
    assert uses
    for action in uses:
        assert re.fullmatch(r"[\w/-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", action), action


def test_the_changelog_keeps_its_form():
    versions = re.findall(r"^## (.*)$", text("CHANGELOG.md"), re.MULTILINE)
    if versions[0] == "Unreleased":
        del versions[0]
    numbers = [Version(heading.split(" - ")[0]) for heading in versions]
    assert numbers[0] == Version(meshlab_symrecon.__version__)
    assert numbers == sorted(set(numbers), reverse=True)
    groups = re.findall(r"^### (.*)$", text("CHANGELOG.md"), re.MULTILINE)
    assert groups
    assert set(groups) <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


def test_the_citation_is_of_this_version_and_licence():
    fields = dict(re.findall(r"^([\w-]+): *(.*)$", text("CITATION.cff"), re.MULTILINE))
    assert {"cff-version", "message", "title", "authors"} <= set(fields)  # what the format demands
    assert fields["cff-version"] == "1.2.0"
    assert fields["version"] == meshlab_symrecon.__version__
    assert fields["license"] == PROJECT["license"]
    assert fields["title"] == PROJECT["name"].replace("-", "_")


INSTALL = text("docs/install.md")


def test_the_page_on_installing_names_the_versions():
    table = re.findall(r"^\| ([a-z, -]+) \| ([\w., ]*\d) \|", INSTALL, re.MULTILINE)
    told = {
        name: Version(version)
        for names, versions in table
        for name, version in zip(names.split(", "), versions.split(", "), strict=True)
    }
    assert told == oldest(PROJECT["dependencies"])
    assert f"CPython {', '.join(PYTHONS)} " in INSTALL
    for extra in EXTRAS:
        assert f"meshlab-symrecon[{extra}]" in INSTALL
    numbers = re.findall(r"meshlab_symrecon-([\d.]+\d)", INSTALL)
    assert set(numbers) == {meshlab_symrecon.__version__}


def test_the_versions_that_make_a_result_are_told_in_one_place():
    told = re.search(r"^Equal versions are those of (.*)\.$", text("docs/reproducible.md"), re.M)
    assert told is not None
    assert re.findall(r"`([\w-]+)`", told[1]) == list(versions_of_results())
    assert "](reproducible.md#what-is-promised)" in INSTALL
    assert "\n## What is promised\n" in text("docs/reproducible.md")


def test_the_example_of_the_page_on_installing_prints_what_it_says():
    code = re.search(r"```python\n(.*?)```", INSTALL, re.DOTALL)
    assert code is not None
    done = subprocess.run(
        [sys.executable, "-c", code[1]], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == code[1].rpartition("# ")[2]


def test_the_scripts_that_come_along_are_those_of_the_folder():
    assert script_names() == sorted(p.stem for p in ROOT.joinpath("meshlab_scripts").glob("*.mlx"))
    for name in script_names():
        path = script_path(name)
        assert path == script_path(f"{name}.mlx")
        assert path.read_bytes() == ROOT.joinpath("meshlab_scripts", path.name).read_bytes()


def test_scripts_that_are_not_there_are_told_with_those_that_are(capsys):
    with pytest.raises(FileError, match=r"named 'statue'; say complete, .*scan_to_solid"):
        script_path("statue")
    assert print_paths(["detect", "statue"]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("no script that comes with us")
    assert print_paths([]) == 0
    assert capsys.readouterr().out.split() == [str(script_path(name)) for name in script_names()]
