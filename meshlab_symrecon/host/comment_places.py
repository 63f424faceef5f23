"""Where the comments of a script stand once it has a step more or less.

They are kept by the position of the step that they stand above; those after the last step at one
more than its position.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

__all__ = ["Comments", "with_step_at", "without_step_at"]

Comments = Mapping[int, Sequence[str]]


def with_step_at(comments: Comments, position: int, count: int) -> Comments:
    """Return the comments of ``count`` steps once a new one stands at a position.

    What stands after the last step stays above one that is added there.
    """
    if position == count:
        return comments
    return {place + (place >= position): texts for place, texts in comments.items()}


def without_step_at(comments: Comments, position: int) -> Comments:
    """Return the comments without those on the step at a position, which is gone.

    What stands above the first step stays: it may be about the whole script.
    """
    kept: dict[int, Sequence[str]] = {}
    for place, texts in sorted(comments.items()):
        if place != position or place == 0:
            later = place - (place > position)
            kept[later] = (*kept.get(later, ()), *texts)
    return kept
