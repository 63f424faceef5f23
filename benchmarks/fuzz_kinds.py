"""All kinds of broken, odd and malicious command lines; each a function of a seed and a number."""

from __future__ import annotations

import random
from collections.abc import Callable

from fuzz_batches import of_batch, of_long_work, of_project
from fuzz_inputs import Input, of_file, of_filter, of_script, of_server, of_words

__all__ = ["drawn"]

KINDS: tuple[tuple[Callable[[random.Random], Input], int], ...] = (
    (of_filter, 30), (of_script, 22), (of_file, 10), (of_words, 8), (of_server, 8),
    (of_batch, 10), (of_project, 6), (of_long_work, 6),
)  # fmt: skip


def drawn(seed: int, number: int) -> Input:
    """Return the command line of that number."""
    rng = random.Random(f"{seed} {number}")
    makers, weights = zip(*KINDS, strict=True)
    return rng.choices(makers, weights)[0](rng)
