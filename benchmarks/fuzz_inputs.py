"""Broken, odd and malicious command lines of single jobs."""

from __future__ import annotations

import random
import re
import subprocess
import sys
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
OURS = (
    "generate_reflection_planes",
    "generate_mirror_completed_points",
    "generate_surface_reconstruction_power_crust",
    "generate_simplified_points",
    "compute_scalar_by_mirror_symmetry_per_vertex",
)
ODD = (
    "", " ", "0", "-1", "1", "0.5", "1e308", "-1e308", "1e-320", "nan", "inf", "-inf", "2147483648",
    "-2147483649", "9" * 400, "0x10", "1_000", "\uff11", "1,5", "true", "False", "None",
    "-", "--", "--help", "/dev/null", "/dev/zero", ".", "..", "/", "a\nb", "\u202e",
    "%s%n", "$(id)", "*", "'", '"', "\\",
    "x > 0", "1/0", "x" * 5000, "\udcff", "[1 2 3]", "1 2 3", "255 0 0 255",
)  # fmt: skip
WORDS = re.compile(rb'"[^"]*"|[<>/=]|[A-Za-z]+|[-+.\d]+')


@dataclass(frozen=True)
class Input:
    """A command line, and the files that are there before it runs.

    Attributes
    ----------
    words : tuple of str
    files : mapping
    server : bool
        Whether it is meshlabserver's.
    made : mapping
        What else is there: ``fifo``, ``folder``, or where a link leads to.
    """

    words: tuple[str, ...]
    files: dict[str, bytes] = field(default_factory=dict)
    server: bool = False
    made: dict[str, str] = field(default_factory=dict)


def cloud(rng: random.Random) -> bytes:
    """A small cloud as a PLY file: a body with a mirror plane, or a degenerate one."""
    many = np.random.default_rng(rng.randrange(2**31))
    count = rng.choice([1, 2, 3, 4, 5, 8, 30, 200, 500])
    points = many.normal(size=(count, 3)) * [1.0, 2.0, 3.0]
    kind = rng.randrange(9)
    if kind == 0:
        points[:] = points[0]
    elif kind == 1:
        points[:, 2] = 0.0
    elif kind == 2:
        points[:, 1:] = 0.0
    elif kind == 3:
        points = np.round(points)
    elif kind == 4:
        points = points * 1e-30 if rng.random() < 0.5 else points * 1e30
    elif kind == 5:
        points = points + 1e7
    elif kind > 6:
        points = np.concatenate([points, points * [-1.0, 1.0, 1.0]])
    header = (
        f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\n"
        "property float y\nproperty float z\nelement face 0\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    return (header + "".join(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points)).encode()


def mesh(rng: random.Random) -> bytes:
    """A tetrahedron, a torus of squares or two touching cubes, as an OFF file."""
    size = rng.choice([3, 4, 7, 12])
    angles = 2 * np.pi * np.arange(size) / size
    u, v = (part.ravel() for part in np.meshgrid(angles, angles))
    rows = np.stack([(2 + np.cos(v)) * np.cos(u), (2 + np.cos(v)) * np.sin(u), np.sin(v)], axis=1)
    faces = []
    for i in range(size):
        for j in range(size):
            a, b = i * size + j, i * size + (j + 1) % size
            c, d = ((i + 1) % size) * size + (j + 1) % size, ((i + 1) % size) * size + j
            faces += [(a, b, c), (a, c, d)]
    if rng.random() < 0.3:
        faces = faces[:: rng.choice([2, 3])]
    lines = [f"OFF\n{len(rows)} {len(faces)} 0"]
    lines += [f"{x:.7g} {y:.7g} {z:.7g}" for x, y, z in rows]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    return ("\n".join(lines) + "\n").encode()


def damaged_bytes(content: bytes, rng: random.Random) -> bytes:
    """Cut, repeat, flip or overwrite a few places."""
    data = bytearray(content)
    for _ in range(rng.choice([1, 1, 2, 5])):
        if not data:
            return bytes(data)
        place, kind = rng.randrange(len(data)), rng.randrange(6)
        if kind == 0:
            del data[place:]
        elif kind == 1:
            data[place] ^= 1 << rng.randrange(8)
        elif kind == 2:
            data[place:place] = data[max(0, place - 40) : place]
        elif kind == 3:
            data[place : place + 4] = rng.choice(
                [b"\0\0\0\0", b"\xff\xff\xff\xff", b"nan ", b"1e99"]
            )
        elif kind == 4:
            del data[place : place + rng.randrange(1, 60)]
        else:
            data[place:place] = rng.choice(ODD).encode("utf-8", "surrogateescape")
    return bytes(data)


@cache
def scripts() -> tuple[bytes, ...]:
    """The scripts of the repository."""
    found = sorted([*ROOT.glob("meshlab_scripts/*.mlx"), *ROOT.glob("tests/scripts/**/*.mlx")])
    return tuple(path.read_bytes() for path in found)


def script(rng: random.Random) -> bytes:
    """A script with some of its words exchanged, dropped, repeated, or its bytes damaged."""
    content = rng.choice(scripts())
    if rng.random() < 0.15:
        return damaged_bytes(content, rng)
    spans = [match.span() for match in WORDS.finditer(content)]
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        start, end = rng.choice(spans)
        if end > len(content):
            continue
        kind, word = rng.randrange(4), content[start:end]
        if kind == 0:
            other = rng.choice(spans)
            new = content[slice(*other)]
        elif kind == 1:
            quoted = rng.choice(ODD).replace('"', "").replace("<", "")
            new = f'"{quoted}"'.encode("utf-8", "surrogateescape") if word[:1] == b'"' else b""
        elif kind == 2:
            new = word + b" " + word
        else:
            new = rng.choice([b"-1", b"0", b"1e300", b"nan", b"99999999999", b"0.0001", b'""'])
        content = content[:start] + new + content[end:]
    return content


@cache
def native_names() -> tuple[str, ...]:
    """The Python names of MeshLab's filters."""
    listed = subprocess.run(
        [sys.executable, "-m", "meshlab_symrecon.cli.main", "filters", "--all"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    words = re.findall(r"\b(?:[a-z]+_)+[a-z]+\b", listed.stdout)
    return tuple(sorted({word for word in words if word.count("_") > 1}))


@cache
def options(name: str) -> tuple[str, ...]:
    """The options of a filter, read from its help."""
    helped = subprocess.run(
        [sys.executable, "-m", "meshlab_symrecon.cli.main", "apply", name, "--help"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return tuple(sorted(set(re.findall(r"--[a-z][-a-z0-9]*", helped.stdout)))) or ("--none",)


def value(rng: random.Random) -> str:
    draw = rng.random()
    if draw < 0.4:
        return rng.choice(ODD)
    if draw < 0.7:
        return str(rng.choice([0, 1, 2, 3, 5, 10, 100]))
    return f"{rng.uniform(-2, 2) * 10 ** rng.randrange(-3, 4):.6g}"


def of_filter(rng: random.Random) -> Input:
    return applied(rng, rng.choice(OURS))


def of_native(rng: random.Random) -> Input:
    return applied(rng, rng.choice(native_names()))


def applied(rng: random.Random, name: str) -> Input:
    """A filter on one or two layers, with a few of its options."""
    words = ["apply", name, *shape_names(rng)]
    for option in rng.choices(options(name), k=rng.choice([0, 1, 1, 2, 4])):
        words += [option, value(rng)]
    return Input((*words, "-o", f"out.{extension(rng)}"), files(rng))


def of_script(rng: random.Random) -> Input:
    command = rng.choice(["run", "run", "run", "check", "upgrade"])
    there = files(rng) | {"s.mlx": script(rng)}
    if command == "upgrade":
        flags = rng.choice([[], ["--explain"], ["--to-python"], ["--native-only"]])
        return Input(("upgrade", "s.mlx", *rng.choice([[], ["new.mlx"]]), *flags), there)
    flags = rng.choice([[], [], ["--strict"], ["--lenient"], ["--isolate"]])
    if command == "check":
        return Input(("check", "s.mlx", *shape_names(rng), *flags[:1]), there)
    return Input(("run", "s.mlx", *shape_names(rng), "-o", f"out.{extension(rng)}", *flags), there)


def of_file(rng: random.Random) -> Input:
    name = rng.choice(["a.ply", "b.off", "c.xyz", "d.obj"])
    content = {"a.ply": cloud, "b.off": mesh}.get(name, lambda _: text(rng))(rng)
    words = rng.choice(
        [
            ("reconstruct", name, "-o", "out.ply", "--json", "out.json"),
            ("apply", rng.choice(OURS), name, "-o", "out.ply"),
        ]
    )
    return Input(words, {name: damaged_bytes(content, rng)})


def text(rng: random.Random) -> bytes:
    rows = np.random.default_rng(rng.randrange(2**31)).normal(size=(rng.choice([3, 40]), 3))
    return "".join(f"{'v ' if rng.random() < 2 else ''}{x} {y} {z}\n" for x, y, z in rows).encode()


def of_words(rng: random.Random) -> Input:
    """A right command line in which words are exchanged, dropped or added."""
    words = list(
        rng.choice(
            [
                ["reconstruct", "a.ply", "-o", "out.ply", "--json", "out.json", "--seed", "1"],
                ["reconstruct", "a.ply", "-o", "out.ply", "--project", "p.mlp", "--paint"],
                ["apply", rng.choice(OURS), "a.ply", "-o", "out.ply", "--json", "out.json"],
                ["run", "s.mlx", "a.ply", "-o", "out.ply", "--json", "out.json", "--lenient"],
                ["batch", "s.mlx", "a.ply", "b.off", "-d", "folder"],
                ["batch", "reconstruct", ".", "-d", "folder", "--name", "{stem}.ply"],
                ["filters", rng.choice(OURS), "--json"],
                ["upgrade", "s.mlx", "new.mlx"],
            ]
        )
    )
    for _ in range(rng.choice([1, 1, 2, 3])):
        place = rng.randrange(len(words))
        kind = rng.randrange(4)
        if kind == 0:
            words[place] = rng.choice(ODD)
        elif kind == 1 and len(words) > 1:
            del words[place]
        elif kind == 2:
            words.insert(
                place, rng.choice([*ODD, "-o", "--json", "--seed", "--quiet", "--threads"])
            )
        else:
            words[place] = words[rng.randrange(len(words))]
    there = files(rng) | {"s.mlx": rng.choice(scripts())}
    if words[0] == "batch":  # results in the root of the machine, or scans
        words = ["." if word == "/" else word for word in words]
    return Input(tuple(words), there)


def of_server(rng: random.Random) -> Input:
    words = ["-i", *shape_names(rng), "-s", "s.mlx", "-o", f"out.{extension(rng)}"]
    if rng.random() < 0.7:
        words += ["-m", *rng.choices(["vc", "vn", "fc", "wt", "xx", "sa", ""], k=2)]
    for _ in range(rng.choice([0, 1, 2])):
        words.insert(
            rng.randrange(len(words)), rng.choice([*ODD, "-l", "log.txt", "-d", "-p", "-w"])
        )
    return Input(tuple(words), files(rng) | {"s.mlx": script(rng)}, server=True)


def shape_names(rng: random.Random) -> list[str]:
    return rng.choice([["a.ply"], ["a.ply"], ["b.off"], ["b.off"], ["a.ply", "b.off"]])


def files(rng: random.Random) -> dict[str, bytes]:
    return {"a.ply": cloud(rng), "b.off": mesh(rng)}


def extension(rng: random.Random) -> str:
    return rng.choice(
        ["ply", "ply", "ply", "obj", "off", "stl", "xyz", "mlp", "3ds", "x3d", "e57", "no"]
    )
