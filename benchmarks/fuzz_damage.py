"""Ways in which a file is damaged, and what may become of it then."""

from __future__ import annotations

import gzip
import re
from collections.abc import Callable

import numpy as np

__all__ = ["DAMAGES", "TRUNCATIONS"]

Damage = Callable[[bytes, np.random.Generator], bytes]
NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
STRANGE = (
    b"-1", b"0", b"-2147483648", b"2147483647", b"4294967296", b"9223372036854775808", b"1e9",
    b"nan", b"inf", b"-inf", b"1e300", b"1e-320", b"x", b"", b"0x10", b"1,5", b"--1", b"1e",
    b"99999999999999999999999", b"3.5", b"\xff", b"\0", b"#", b"1" * 5000,
)  # fmt: skip
LARGE = (
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\x7f\xff\xff\xff",
    b"\0\0\0\x80",
    b"\0\0\xc0\x7f",
)


def cut(content: bytes, generator: np.random.Generator) -> bytes:
    return content[: int(generator.integers(1, len(content)))]


def cut_a_little(content: bytes, generator: np.random.Generator) -> bytes:
    return content[: -int(generator.integers(1, min(40, len(content))))]


def cut_at_a_line(content: bytes, generator: np.random.Generator) -> bytes:
    lines = content.splitlines(keepends=True)
    return b"".join(lines[: int(generator.integers(1, max(2, len(lines))))])


def flip_a_bit(content: bytes, generator: np.random.Generator) -> bytes:
    return flip(content, generator, 1)


def flip_bits(content: bytes, generator: np.random.Generator) -> bytes:
    return flip(content, generator, int(generator.integers(2, 30)))


def flip(content: bytes, generator: np.random.Generator, count: int) -> bytes:
    changed = bytearray(content)
    for _ in range(count):
        changed[int(generator.integers(len(changed)))] ^= 1 << int(generator.integers(8))
    return bytes(changed)


def strange_numbers(content: bytes, generator: np.random.Generator) -> bytes:
    """Replace numbers of a text, among the first ones more often than among the others."""
    places = list(NUMBER.finditer(content))
    for _ in range(int(generator.integers(1, 4))):
        if not places:
            break
        limit = min(12, len(places)) if generator.random() < 0.5 else len(places)
        match = places.pop(int(generator.integers(limit)))
        word = STRANGE[int(generator.integers(len(STRANGE)))]
        content = content[: match.start()] + word + content[match.end() :]
        places = [place for place in places if place.end() < match.start()]
    return content


def large_words(content: bytes, generator: np.random.Generator) -> bytes:
    """Write large, negative or undefined numbers over four bytes."""
    at = int(generator.integers(max(1, len(content) - 4)))
    word = LARGE[int(generator.integers(len(LARGE)))]
    return content[:at] + word + content[at + 4 :]


def without_a_piece(content: bytes, generator: np.random.Generator) -> bytes:
    first = int(generator.integers(len(content)))
    return content[:first] + content[first + int(generator.integers(1, 100)) :]


def twice_a_piece(content: bytes, generator: np.random.Generator) -> bytes:
    first = int(generator.integers(len(content)))
    last = first + int(generator.integers(1, 200))
    return content[:last] + content[first:last] * int(generator.integers(1, 30)) + content[last:]


def swapped_lines(content: bytes, generator: np.random.Generator) -> bytes:
    lines = content.splitlines(keepends=True)
    one, other = generator.integers(len(lines), size=2)
    lines[one], lines[other] = lines[other], lines[one]
    return b"".join(lines)


def zeros(content: bytes, generator: np.random.Generator) -> bytes:
    first = int(generator.integers(len(content)))
    count = int(generator.integers(1, 4000))
    return content[:first] + b"\0" * count + content[first + count :]


def wide(content: bytes, generator: np.random.Generator) -> bytes:
    return content.decode("latin-1").encode("utf-16")


def packed(content: bytes, generator: np.random.Generator) -> bytes:
    return gzip.compress(content)


def marked(content: bytes, generator: np.random.Generator) -> bytes:
    return b"\xef\xbb\xbf" + content


def old_line_ends(content: bytes, generator: np.random.Generator) -> bytes:
    return content.replace(b"\n", b"\r")


def long_line(content: bytes, generator: np.random.Generator) -> bytes:
    lines = content.splitlines(keepends=True)
    at = int(generator.integers(len(lines)))
    filler = (b"x", b"1 ", b" ", b"#")[int(generator.integers(4))]
    return b"".join(lines[:at]) + filler * 200_000 + b"\n" + b"".join(lines[at:])


TRUNCATIONS = (cut, cut_a_little, cut_at_a_line)
DAMAGES: tuple[Damage, ...] = (
    *TRUNCATIONS, flip_a_bit, flip_bits, strange_numbers, strange_numbers, large_words,
    without_a_piece, twice_a_piece, swapped_lines, zeros, wide, packed, marked, old_line_ends,
    long_line,
)  # fmt: skip
