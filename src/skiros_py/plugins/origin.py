"""Where a module lies, found without running any code of a package."""

from __future__ import annotations

from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path

__all__ = ["locate", "origin_of"]


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
