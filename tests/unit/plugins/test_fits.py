"""A distribution says which skiros-py it is made for; where that is another, none of its code is run."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from skiros_py import __version__
from skiros_py.plugins.installation import misfit
from skiros_py.plugins.loading import load_plugins
from skiros_py.plugins.plugin import Distribution


def made_for(*requires: str) -> Distribution:
    return Distribution("crane", "2.0", requires)


@pytest.mark.parametrize(
    "requires",
    [
        (),
        ("numpy>=2.0",),
        ("skiros-py",),
        ("skiros_py>=0.1,<0.2",),
        ("Skiros.Py~=0.1.0",),
        ("skiros-py>=0.1.0 ; python_version >= '3.11'",),
        ("skiros-py>=9 ; python_version < '3'",),
        ("skiros-py>=9 ; extra == 'next'",),
        ("skiros-py-extras>=9",),
        ("skiros-py>=0.1", "skiros-py<0.2"),
    ],
)
def test_a_compatible_distribution_or_one_without_a_requirement_is_loaded(requires: tuple[str, ...]) -> None:
    assert misfit(made_for(*requires), "0.1.5") is None


@pytest.mark.parametrize("wanted", [">=0.2", "<0.1", "==0.1.4", "!=0.1.5", ">=0.3,<0.4"])
def test_a_distribution_for_another_version_is_refused_with_both_versions(wanted: str) -> None:
    reason = misfit(made_for(f"skiros-py{wanted}"), "0.1.5")

    assert reason is not None
    assert "and this is skiros-py 0.1.5; install a release of crane that fits" in str(reason)
    assert all(part in str(reason) for part in wanted.split(","))


def test_a_development_version_is_compared_like_any_version() -> None:
    assert misfit(made_for("skiros-py>=0.1,<0.2"), "0.1.5.dev3") is None


@pytest.mark.parametrize("text", ["skiros-py>>1", "skiros-py 1.0", "skiros-py>=x"])
def test_an_invalid_requirement_is_refused(text: str) -> None:
    reason = misfit(made_for(text), "0.1.5")

    assert reason is not None
    assert f"'{text}', which is no requirement (such as 'skiros-py>=0.1,<0.2')" in str(reason)


def test_the_requirements_of_a_distribution_are_read_once_for_all_its_entry_points() -> None:
    misfit.cache_clear()

    found = [misfit(made_for("skiros-py>=99"), "0.1.5") for _ in range(3)]

    assert (len(set(found)), misfit.cache_info().misses) == (1, 1)


def test_code_for_another_version_is_not_executed(site: Any) -> None:
    group = {"testing_only": {"new": "sk_tomorrow:X"}}
    site.install("sk-tomorrow", group, {"sk_tomorrow.py": "raise SystemExit"}, requires=["skiros-py>=99"])

    plugins, (fault,) = load_plugins("skiros.testing_only")

    assert plugins == ()
    assert fault.reason.startswith(f"it is made for skiros-py>=99, and this is skiros-py {__version__}")
    assert "sk_tomorrow" not in sys.modules
