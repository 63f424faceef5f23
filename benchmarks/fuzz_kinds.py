"""All kinds of broken, odd and malicious command lines; each a function of a seed and a number."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

from fuzz_batches import of_batch, of_long_work, of_project
from fuzz_inputs import (
    Input,
    of_file,
    of_filter,
    of_native,
    of_script,
    of_server,
    of_words,
)

__all__ = ["NAMES", "drawn"]

KINDS: tuple[tuple[Callable[[random.Random], Input], int], ...] = (
    (of_filter, 15), (of_native, 15), (of_script, 22), (of_file, 10), (of_words, 8), (of_server, 8),
    (of_batch, 10), (of_project, 6), (of_long_work, 6),
)  # fmt: skip


NAMES = tuple(maker.__name__.removeprefix("of_") for maker, _ in KINDS)


def drawn(seed: int, number: int, only: Sequence[str] = ()) -> Input:
    """Return the command line of that number, of all kinds or of some."""
    rng = random.Random(f"{seed} {number}")
    chosen = [kind for name, kind in zip(NAMES, KINDS, strict=True) if not only or name in only]
    makers, weights = zip(*chosen, strict=True)
    return rng.choices(makers, weights)[0](rng)
