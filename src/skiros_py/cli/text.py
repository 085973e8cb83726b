"""Text of others, shown on a terminal."""

from __future__ import annotations

__all__ = ["escaped"]


def escaped(text: str) -> str:
    r"""Returns a line in which everything that cannot be printed is written out, as in ``\x1b`` or ``\n``.

    Labels, authors and reasons come from anywhere; what they say must not steer the terminal or look like more lines.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
