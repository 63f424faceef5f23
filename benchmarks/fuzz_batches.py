"""Odd command lines of batches, projects, and of the options that long commands share."""

from __future__ import annotations

import random

from fuzz_inputs import (
    ODD,
    OURS,
    WORDS,
    Input,
    cloud,
    damaged_bytes,
    extension,
    files,
    mesh,
    script,
    scripts,
    shape_names,
)

__all__ = ["of_batch", "of_long_work", "of_project"]

ELSEWHERE = ("/",)  # walked, or written to, it would be the machine's
TEMPLATES = (
    "{stem}.ply", "{stem}.{extension}", "{number:04}.obj", "{number:4000}.ply", "{number:x}.ply",
    "{folder}/{stem}.ply", "{parent}/{stem}.off", "x.ply", "{stem}", "{}", "{0}.ply",
    "{stem!r}.ply", "{stem.x}.ply", "{stem[0]}.ply", "{{stem}}.ply", "{", "}", "../{stem}.ply",
    "{script}.ply", ".{stem}.ply", "{stem}.mlp", "{stem}.PLY", "a/../{stem}.ply", "{number:c}.ply",
    "{number:n}.ply", "{number:99999999999}.ply", "{number:\n}.ply",
    "{stem}/.ply", "~/{stem}.ply", "{stem}.ply/", "{stem:>100000}.ply", "{number:100000}.ply",
    "con.ply", "batch.jsonl", "{stem}.json",
)  # fmt: skip
PATTERNS = (
    "*.ply", "**/*", "[", "[a-", "[!a].ply", "*", "?.ply", "**", "scans/*", "scans/**/*.ply",
    "*.nothing", "scans", "scans/deep", ".", "a.ply", "b.off", "./a.ply", "link.ply", "broken.ply",
    "fifo.ply", "s.mlx", "none.ply", "scans/../a.ply", "dir.ply",
)  # fmt: skip
LIMITS = ("1", "0.001", "1e308", "nan", "inf", "5", "100000000000")
SIZES = ("1", "1K", "100M", "4G", "9999999T", "1e9", "0", "-1", "9" * 400 + "G", "4 GiB")
SCHEDULERS = ("", "x", "tcp://", "tcp://127.0.0.1:1", "http://[", "127.0.0.1:99999", "inproc://x",
              "tcp://127.0.0.1:port", "ucx://a", "\n", "tls://127.0.0.1:1")  # fmt: skip
LOGS = ("log.txt", "a.ply", "out.ply", "s.mlx", ".", "none/log.txt", "/dev/null", "fifo.ply",
        "link.ply", "broken.ply", "", "out.json", "log.ply")  # fmt: skip
COUNTS = ("0", "1", "2", "-1", "1000000", "9" * 30, "1.5", "x", "99", "100", "150")
SPECIAL = {"fifo.ply": "fifo", "dir.ply": "folder", "link.ply": "a.ply", "broken.ply": "nowhere"}


def odd(rng: random.Random) -> str:
    return rng.choice([word for word in ODD if word not in ELSEWHERE])


def of_batch(rng: random.Random) -> Input:
    """A batch of two to five small scans, in folders and patterns, with odd options."""
    words = ["batch", rng.choice(["s.mlx", "s.mlx", "reconstruct"])]
    words += rng.choices(PATTERNS, k=rng.choice([1, 1, 2, 3]))
    words += ["-d", rng.choice(["out"] * 6 + ["scans", ".", "a.ply", "out/deep", "fifo.ply", ""])]
    if rng.random() < 0.6:
        words += ["--name", rng.choice(TEMPLATES) if rng.random() < 0.8 else odd(rng)]
    choices = {
        "--jobs": COUNTS[:4], "--threads": COUNTS, "--time-limit": LIMITS, "--memory-limit": SIZES,
        "--max-points": COUNTS, "--scheduler": SCHEDULERS, "--log": LOGS, "--json": LOGS,
        "--seed": COUNTS,
    }  # fmt: skip
    for option in rng.sample(sorted(choices), rng.choice([0, 1, 1, 2])):
        words += [option, rng.choice(choices[option]) if rng.random() < 0.8 else odd(rng)]
    flags = ["--recursive", "--retry", "--again", "--strict", "--lenient", "--paint", "-q"]
    words += rng.sample(flags, rng.choice([0, 0, 1, 2]))
    there = files(rng) | {"s.mlx": rng.choice([script, lambda _: rng.choice(scripts())])(rng)}
    there |= {"scans/a.ply": cloud(rng), "scans/deep/b.off": mesh(rng)}
    there["scans/c.ply"] = damaged_bytes(cloud(rng), rng)
    return Input(tuple(words), there, made=dict(SPECIAL))


def project(rng: random.Random) -> bytes:
    """A MeshLab project of one to three layers, with words exchanged or bytes damaged."""
    matrix = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1"
    rows = "".join(
        f'<MLMesh label="{rng.choice(["a", "b", "", "&lt;", "a"])}" visible="1" '
        f'filename="{rng.choice(["a.ply", "b.off", "a.ply", "none.ply", "p.mlp", "fifo.ply"])}">'
        f"<MLMatrix44>{matrix}</MLMatrix44></MLMesh>\n"
        for _ in range(rng.choice([1, 1, 2, 3]))
    )
    content = (
        "<!DOCTYPE MeshLabDocument>\n<MeshLabProject>\n<MeshGroup>\n" + rows + "</MeshGroup>\n"
        "<RasterGroup/>\n</MeshLabProject>\n"
    ).encode()
    if rng.random() < 0.3:
        return damaged_bytes(content, rng)
    for _ in range(rng.choice([0, 1, 1, 2])):
        start, end = rng.choice([match.span() for match in WORDS.finditer(content)])
        if content[start:end][:1] == b'"':
            text = odd(rng).replace('"', "").replace("<", "").replace("&", "")
            new = b'"' + text.encode("utf-8", "surrogateescape") + b'"'
        else:
            new = rng.choice([b"-1", b"nan", b"1e300", b"", b"0", b"x", b"99999999999999999999"])
        content = content[:start] + new + content[end:]
    return content


def of_project(rng: random.Random) -> Input:
    """A project as input."""
    there = files(rng) | {"s.mlx": rng.choice(scripts()), "p.mlp": project(rng)}
    made = {"fifo.ply": "fifo"}
    output = f"out.{extension(rng)}"
    if rng.random() < 0.2:
        words = (
            "-p",
            "p.mlp",
            "-s",
            "s.mlx",
            rng.choice(["-o", "-w"]),
            rng.choice([output, "n.mlp"]),
        )
        return Input(words, there, server=True, made=made)
    words = rng.choice(
        [
            ("run", "s.mlx", "p.mlp", "-o", output),
            ("run", "s.mlx", "p.mlp", "a.ply", "-o", "n.mlp", "--lenient"),
            ("apply", rng.choice(OURS), "p.mlp", "-o", output),
            ("reconstruct", "p.mlp", "-o", "out.ply"),
            ("check", "s.mlx", "p.mlp"),
            ("batch", "s.mlx", "p.mlp", "-d", "out", "--name", "{stem}.{extension}"),
        ]
    )
    return Input(words, there, made=made)


def of_long_work(rng: random.Random) -> Input:
    """A plain job with odd values of --log, --threads, --max-points, before it or behind it."""
    scan = rng.choice([*shape_names(rng), "fifo.ply", "dir.ply", "link.ply", "broken.ply", "a.ply"])
    words = rng.choice(
        [
            ["reconstruct", scan, "-o", "out.ply", "--json", "out.json"],
            ["apply", rng.choice(OURS), scan, "-o", "out.ply"],
            ["run", "s.mlx", scan, "-o", "out.ply", "--json", "out.json"],
        ]
    )
    choices = {"--log": LOGS, "--threads": COUNTS, "--max-points": COUNTS, "--quiet": (),
               "--seed": COUNTS}  # fmt: skip
    for option in rng.choices(sorted(choices), k=rng.choice([1, 1, 2, 3])):
        given = [option]
        if choices[option]:
            given.append(rng.choice(choices[option]) if rng.random() < 0.8 else odd(rng))
        words = [*given, *words] if rng.random() < 0.2 else [*words, *given]
    there = files(rng) | {"s.mlx": rng.choice(scripts())}
    return Input(tuple(words), there, made=dict(SPECIAL))
