"""Text of others, shown on a terminal."""

from __future__ import annotations

_STACKS = ('\n  File "', "\nTraceback (most recent call last):")
"""How stacks begin that follow a text."""


def escaped(text: str) -> str:
    r"""Returns a line in which everything that cannot be printed is written out, as in ``\x1b`` or ``\n``.

    Labels, authors and reasons come from anywhere; what they say must not steer the terminal or look like more lines.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def brief(text: str) -> str:
    """Returns a text without the stack that follows it; in its place stands the author's line where that is from."""
    from skiros_py.plugins.origin import authors_line  # help is there at once, without all that

    start = min((at for stack in _STACKS if (at := text.find(stack)) >= 0), default=-1)
    if start < 0:
        return text
    head, frame = text[:start], authors_line(text[start:])
    return head if frame is None else f"{head} ({frame[0]}:{frame[1]} in {frame[2]})"
