"""Which skiros-py a distribution is made for."""

from __future__ import annotations

import re
from functools import lru_cache
from importlib.metadata import version

from skiros_py.plugins.installation import canonical
from skiros_py.plugins.plugin import Distribution

__all__ = ["OWN_NAME", "misfit"]

OWN_NAME = "skiros-py"
"""Name of the distribution that this is."""
_NAME = re.compile(r"\s*([A-Za-z0-9][A-Za-z0-9._-]*)(.*)", re.DOTALL)


@lru_cache(maxsize=1024)  # asked for each entry point of a distribution
def misfit(distribution: Distribution, own_version: str | None = None) -> str | None:
    """Returns why a distribution does not go with this skiros-py, or None where it does, or does not say.

    Args:
        distribution: What may say in its metadata ``Requires-Dist: skiros-py>=0.1,<0.2``.
        own_version: Version to compare with; that of the installed skiros-py where left out.
    """
    for text in distribution.requires:
        match = _NAME.fullmatch(text)
        # Most say nothing but the name; the library that reads the rest takes a while to import.
        if match and canonical(match[1]) == OWN_NAME and match[2].strip():
            problem = _problem(text, own_version or _own_version())
            if problem:
                return f"{problem}; install a release of {distribution.name} that fits, or such a {OWN_NAME}"
    return None


@lru_cache(maxsize=1)
def _own_version() -> str:
    return version(OWN_NAME)


def _problem(text: str, own_version: str) -> str | None:
    from packaging.requirements import InvalidRequirement, Requirement

    try:
        requirement = Requirement(text)
    except InvalidRequirement:
        return f"its metadata require '{text}', which is no requirement (such as '{OWN_NAME}>=0.1,<0.2')"
    if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
        return None
    if requirement.specifier.contains(own_version, prereleases=True):
        return None
    return f"it is made for {OWN_NAME}{requirement.specifier}, and this is {OWN_NAME} {own_version}"
