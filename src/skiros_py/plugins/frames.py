"""Stacks of code, written out as text, made short: the last line that is neither ours nor Python's."""

from __future__ import annotations

import re
import sysconfig
from pathlib import Path

__all__ = ["authors_line"]

_FRAME = re.compile(r'File "([^"<]+)", line (\d+)(?:, in (\S+))?')
_PLATFORM = Path(__file__).parents[1]
_STANDARD = Path(sysconfig.get_path("stdlib"))


def authors_line(stack: str) -> tuple[Path, int, str] | None:
    """Returns file, line and function of the innermost frame that is an author's; None where there is none."""
    frames = [(Path(file), int(line), function) for file, line, function in _FRAME.findall(stack)]
    own = [frame for frame in frames if not _is_foreign(frame[0])]
    return own[-1] if own else None


def _is_foreign(file: Path) -> bool:
    is_standard = _STANDARD in file.parents and "site-packages" not in file.parts
    return is_standard or _PLATFORM in file.parents or "importlib" in file.parts
