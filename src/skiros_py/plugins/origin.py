"""Where code lies: the file of a module without running it, and the author's line in a stack."""

from __future__ import annotations

import re
import sysconfig
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path


def locate(module: str) -> ModuleSpec | None:
    """Returns what the import system knows of a module, or None where there is none.

    Unlike ``importlib.util.find_spec`` it does not import the packages around it.
    """
    top, *inner = module.split(".")
    try:
        spec = find_spec(top)
        for part in inner:
            if spec is None or spec.submodule_search_locations is None:
                return None
            # Under its full name, a folder without code is found only once the package around it is imported.
            spec = PathFinder.find_spec(part, list(spec.submodule_search_locations))
    except (ImportError, ValueError, AttributeError):  # find_spec raises for what was imported half
        return None
    return spec


def origin_of(module: str) -> str:
    """Returns the file of a module, of a package without code its folder; empty where there is none."""
    spec = locate(module) if module else None
    if spec is None:
        return ""
    if spec.origin and Path(spec.origin).exists():
        return spec.origin
    return next(iter(spec.submodule_search_locations or ()), "")


# ---------------------------------------------------------------- stacks


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
