"""``symrecon batch``: what it prints, writes and answers."""

from __future__ import annotations

import json
import os
from dataclasses import replace

import pytest

from meshlab_symrecon.batch import BatchReport, ScanReport
from meshlab_symrecon.batch.log import opened_log
from meshlab_symrecon.cli.batch_display import _warned, print_table

SCRIPT = """<FilterScript>
 <filter name="Transform: Scale, Normalize">
  <Param type="RichFloat" name="axisX" value="0.5"/>
 </filter>
 <filter name="Compute Geometric Measures"/>
</FilterScript>
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "halve.mlx").write_text(SCRIPT)
    (tmp_path / "in").mkdir()
    for name, size in (("a", 1), ("b", 2)):
        rows = f"0 0 0\n{size} 0 0\n0 {size} 0\n0 0 {size}\n"
        faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
        (tmp_path / "in" / f"{name}.off").write_text(f"OFF\n4 4 0\n{rows}{faces}")
    return tmp_path


def test_a_batch_from_its_first_to_its_second_run(place, run):
    options = ("batch", "halve.mlx", "in", "-d", "out", "--jobs", 1, "--json", "r.json")
    done = run(*options)
    assert done.exit_code == 0, done.stderr
    assert "[2/2] done in/b.off" in done.stderr
    table = done.stdout.splitlines()
    assert table[0].split() == ["scan", "status", "seconds", "memory", "found"]
    assert table[1].startswith("in/a.off  done")
    assert table[-1].startswith("2 scans: 2 done in ")
    summary = json.loads((place / "r.json").read_text())
    log = [json.loads(line) for line in (place / "out/batch.jsonl").read_text().splitlines()]
    assert (summary["total"], summary["done"], summary["failed"]) == (2, 2, 0)
    assert [one["scan"] for one in summary["scans"]] == ["in/a.off", "in/b.off"]
    assert summary["scans"][1]["measures"]["mesh_volume"] == pytest.approx(8 / 6 / 8)
    assert {line["scan"]: line["output_sha256"] for line in log} == {
        one["scan"]: one["output_sha256"] for one in summary["scans"]
    }
    once = run("run", "halve.mlx", "in/a.off", "-o", "a.ply")
    assert once.exit_code == 0, once.stderr
    assert (place / "a.ply").read_bytes() == (place / "out/a.ply").read_bytes()
    (place / "in/c.off").write_text("OFF\nbroken")
    again = run(*options)
    assert again.exit_code == 1
    assert again.stderr.splitlines()[-1].startswith("error: 1 of 3 scans have no result (1 failed)")
    assert again.stderr.endswith(
        "; out/batch.jsonl says why, and the same command goes on once that is mended; "
        "--retry tries even what is as it was\n"
    )
    assert "[3/3] failed in/c.off" in again.stderr
    assert "3 scans: 2 done, 1 failed (2 from an earlier run)" in again.stdout
    quiet = run("batch", "halve.mlx", "in", "-d", "out", "--quiet")
    assert quiet.exit_code == 1
    assert quiet.stdout == ""
    assert len(quiet.stderr.splitlines()) == 1


def test_warnings_are_told_and_counted(place, run):
    rows = "0 0 0\n1 0 0\n0 1 0\n0 0 1\nnan 0 0\n"
    (place / "in/a.off").write_text(f"OFF\n5 2 0\n{rows}3 0 2 1\n3 0 1 3\n")
    options = ("batch", "halve.mlx", "in", "-d", "out", "--jobs", 1)
    done = run(*options)
    assert done.exit_code == 0, done.stderr
    log = [json.loads(line) for line in (place / "out/batch.jsonl").read_text().splitlines()]
    (sentence,) = log[0]["warnings"]
    assert "coordinates that are not numbers" in sentence
    told = done.stderr.splitlines()
    assert [line.partition(": ")[0] for line in told] == [
        "[1/2] done in/a.off", "  warning", "[2/2] done in/b.off"
    ]  # fmt: skip
    assert told[1] == f"  warning: {sentence}"
    assert "2 scans: 2 done, 1 with warnings in " in done.stdout
    again = run(*options)
    assert again.stderr == ""
    assert "2 done, 1 with warnings (2 from an earlier run) in " in again.stdout
    quiet = run(*options, "--again", "--quiet")
    assert (quiet.stdout, quiet.stderr) == ("", "")


def test_of_many_warnings_the_first_are_shown():
    report = ScanReport("a.ply", "b.ply", "b.ply", "done", warnings=list("abcde"))
    shown = [f"warning: {letter}" for letter in "abc"]
    assert _warned(report) == [*shown, "and 2 more in the log"]
    assert _warned(replace(report, warnings=["a", "b", "c"])) == shown
    assert _warned(replace(report, warnings=["two\nlines"])) == ["warning: two\\nlines"]


ODD = (None, True, -1, 10**400, 1e308, float("nan"), "", "word\n\0", [], [[]], {}, {"a": [1]})


def everywhere(data, odd):
    """Yield copies of plain data, in each of which another part is odd."""
    yield odd
    if isinstance(data, (dict, list)):
        for key, part in data.items() if isinstance(data, dict) else enumerate(data):
            for other in everywhere(part, odd):
                copy = data.copy()
                copy[key] = other
                yield copy


def test_whatever_is_in_a_log_there_is_a_table(tmp_path, capsys):
    planes = [{"plane": [1.0, 0.0, 0.0, 0.5], "support": 0.9, "confidence": 0.98}] * 2
    whole = ScanReport(
        "a.ply", "out/a.ply", "a.ply", "done", work_sha256="w", seconds=1.5, warnings=["odd"],
        measures={
            "planes": planes, "mirrored": 7, "surface": {"closed": True, "genus": 0, "faces": 9}
        },
        steps=[{"step": "x", "status": "skipped"}], peak_memory_bytes=1 << 20, limits={"memory": 1},
    ).as_data()  # fmt: skip
    lines = [whole] + [copy for odd in ODD for copy in everywhere(whole, odd)]
    path = tmp_path / "batch.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    with opened_log(path) as log:
        reports, passed_over = log.reports, log.passed_over
    assert 0 < passed_over < len(lines) - 100
    assert len(reports) + passed_over == len(lines)
    print_table(BatchReport(reports, str(path), 1.0))
    table = capsys.readouterr().out.splitlines()
    assert len(table) == len(reports) + 2
    found = "2 planes, first a mirror plane of confidence 0.98, 7 points mirrored, closed, genus 0"
    assert table[1].endswith(f"{found}, 9 faces")


def test_what_is_too_large_is_not_to_be_tried_as_it_is(place, run):
    cloud = "ply\nformat ascii 1.0\nelement vertex 4000000\nproperty float x\nproperty float y\n"
    path = place / "in/a.ply"
    path.write_text(f"{cloud}property float z\nend_header\n")
    with path.open("ab") as file:
        file.truncate(6 * 4_000_000 + 1000)  # what so many points take at least
    done = run("batch", "reconstruct", path, "-d", "out", "--jobs", 1, "--memory-limit", "4G")
    assert done.exit_code == 1
    assert "or raise the limit (--memory-limit is 4 GiB)" in done.stderr
    assert done.stderr.endswith("says why, and the same command goes on once that is mended\n")


def test_reconstruct_is_the_whole_method(place, statue, run):
    done = run("batch", "reconstruct", statue, "-d", "out", "--seed", 3, "--jobs", 1)
    assert done.exit_code == 0, done.stderr
    assert "closed, genus 0" in done.stdout
    (line,) = (place / "out/batch.jsonl").read_text().splitlines()
    found = json.loads(line)
    alone = run("reconstruct", statue, "-o", "alone.ply", "--json", "r.json", "--seed", 3)
    assert alone.exit_code == 0, alone.stderr
    assert (place / "alone.ply").read_bytes() == next((place / "out").glob("*.ply")).read_bytes()
    expected = json.loads((place / "r.json").read_text())
    for one in (found["measures"], expected):
        del one["surface"]["seconds"]
    for key in ("planes", "converged", "measured", "mirrored", "completion", "surface"):
        assert found["measures"][key] == expected[key]
    for key, value in expected["parameters"].items():
        assert found["parameters"][key] == value


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        ((), 2, "Missing"),
        (("halve.mlx", "in"), 2, "Missing option '-d'"),
        (("halve.mlx", "in", "-d", "out", "--jobs", "0"), 2, "--jobs"),
        (("halve.mlx", "in", "-d", "out", "--time-limit", "0"), 2, "--time-limit"),
        (("halve.mlx", "in", "-d", "out", "--time-limit", "nan"), 2, "number above zero; got nan"),
        (("halve.mlx", "in", "-d", "out", "--time-limit", "inf"), 2, "number above zero; got inf"),
        (("halve.mlx", "in", "-d", ""), 1, "error: the folder of the results has no name"),
        (("in", "in", "-d", "out"), 1, "error: script in cannot be read: Is a directory"),
        (("halve.mlx", "in", "-d", "out", "--memory-limit", "much"), 2, "is no size of memory"),
        (("halve.mlx", "in", "-d", "out", "--seed", "1"), 2, "are for reconstruct"),
        (("reconstruct", "in", "-d", "out", "--strict"), 2, "are for scripts"),
        (("halve.mlx", "in", "-d", "out", "--strict", "--lenient"), 2, "contradict"),
        (("halve.mlx", "in", "-d", "o", "--jobs", "2", "--scheduler", "tcp://a:1"), 2, "--jobs is"),
        (("halve.mlx", "nowhere", "-d", "out"), 1, "error: nowhere cannot be read: no such file"),
        (("none.mlx", "in", "-d", "out"), 1, "error: script none.mlx cannot be read"),
        (("halve.mlx", "in", "-d", "in"), 1, "error: the results would lie among the scans"),
        (("halve.mlx", "in", "-d", "out", "--name", "x.ply"), 1, "would both become x.ply"),
        (("halve.mlx", "in", "-d", "out", "--json", "halve.mlx"), 1, "would overwrite"),
        (("halve.mlx", "in", "-d", "out", "--json", "in/b.off"), 1, "would overwrite a file"),
        (("halve.mlx", "in", "-d", "out", "--log", "in/b.off"), 1, "would overwrite a file"),
        (("halve.mlx", "in/*", "-d", "out", "--json", "in/b.off"), 1, "would overwrite"),
        (("halve.mlx", "in", "-d", "out", "--log", "r.json", "--json", "r.json"), 1, "overwrite"),
        (("halve.mlx", "", "-d", "out"), 1, "error: an input has no name"),
        (("halve.mlx", "in", "-d", "out", "--memory-limit", "9" * 400), 2, "is no size of memory"),
    ],
)
def test_mistakes(place, run, words, code, sentence):
    done = run("batch", *words)
    assert done.exit_code == code, done.stderr
    assert sentence in done.stderr
    assert not (place / "out").exists()


def test_names_that_no_line_can_show(place, run):
    """A line feed is written out; a name that is not UTF-8 is told, since MeshLab needs that."""
    (place / "in/b.off").rename(place / "in/b\nof\x1b[31m.off")
    odd = os.fsdecode(b"in/\xff.off")
    (place / odd).write_bytes((place / "in/a.off").read_bytes())
    done = run("batch", "halve.mlx", "in", "-d", "out", "--name", "{number}.ply", "--jobs", 1)
    assert done.exit_code == 1
    assert sorted(path.name for path in (place / "out").iterdir()) == [
        "1.ply", "2.ply", "batch.jsonl"
    ]  # fmt: skip
    assert "[2/3] done in/b\\nof\\x1b[31m.off: " in done.stderr
    sentence = "in/\\udcff.off cannot be read: its name is not UTF-8, and MeshLab takes no other"
    assert f"[3/3] failed {sentence}; rename it" in done.stderr
    assert len(done.stderr.splitlines()) == 4
    rows = done.stdout.splitlines()
    assert [row.split()[0] for row in rows] == [
        "scan", "in/a.off", "in/b\\nof\\x1b[31m.off", "in/\\udcff.off", "3",
    ]  # fmt: skip
    log = [json.loads(line) for line in (place / "out/batch.jsonl").read_text().splitlines()]
    assert [line["scan"] for line in log] == ["in/a.off", "in/b\nof\x1b[31m.off", odd]
    again = run("batch", "halve.mlx", "in", "-d", "out", "--name", "{number}.ply", "--jobs", 1)
    assert "(3 from an earlier run)" in again.stdout


def test_the_options_before_the_command_count_too(place, run):
    done = run("--quiet", "batch", "halve.mlx", "in/a.off", "-d", "out", "--jobs", 1)
    assert done.exit_code == 0
    assert (done.stdout, done.stderr) == ("", "")
    wrong = run("--log", "work.log", "batch", "halve.mlx", "in/a.off", "-d", "out")
    assert wrong.exit_code == 2
    assert "give --log FILE.jsonl behind it" in wrong.stderr
    assert not (place / "work.log").exists()


@pytest.mark.parametrize("name", ["a.ply", "batch.jsonl"])
def test_a_summary_does_not_take_the_place_of_a_result_or_of_the_log(place, run, name):
    assert run("batch", "halve.mlx", "in", "-d", "out", "--jobs", 1).exit_code == 0
    before = {path: path.read_bytes() for path in (place / "out").iterdir()}
    done = run("batch", "halve.mlx", "in", "-d", "out", "--jobs", 1, "--json", f"out/{name}")
    assert done.exit_code == 1
    assert f"out/{name} would overwrite a file of the batch" in done.stderr
    assert {path: path.read_bytes() for path in (place / "out").iterdir()} == before


def test_a_log_is_not_written_to_another_file(place, run):
    (place / "notes.txt").write_text("precious\n\0\0")
    done = run("batch", "halve.mlx", "in", "-d", "out", "--jobs", 1, "--log", "notes.txt")
    assert done.exit_code == 1
    assert "notes.txt holds something else than the log of a batch" in done.stderr
    assert (place / "notes.txt").read_text() == "precious\n\0\0"
