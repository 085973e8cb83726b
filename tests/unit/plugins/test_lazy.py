"""Plug-ins are loaded one by one, when they are asked for; a broken one is then not there."""

from __future__ import annotations

import logging
import sys
from typing import Any

import pytest

from skiros_py.plugins.installation import installation
from skiros_py.plugins.loading import LazyPlugins
from skiros_py.plugins.plugin import Plugin

FILES = {
    "sk_lazy_a.py": "X = 1",
    "sk_lazy_b.py": "X = 2",
    "sk_lazy_c.py": "raise SystemExit",
    "sk_lazy_d.py": "class Odd:\n    @property\n    def __class__(self): raise OSError('hands off')\nX = Odd()",
    "sk_lazy_e.py": "X = 'text'",
}
POINTS = {"testing_only": {name: f"sk_lazy_{name}:X" for name in "abcde"}}


def _problem(plugin: Plugin) -> str | None:
    return None if isinstance(plugin.value, int) else f"it is a {type(plugin.value).__name__}"


@pytest.fixture
def lazy(site: Any) -> LazyPlugins[int]:
    for module in FILES:
        sys.modules.pop(module.removesuffix(".py"), None)
    site.install("sk-lazy", POINTS, FILES)
    return LazyPlugins(installation().of("skiros.testing_only"), _problem)


def test_listing_names_loads_no_plug_in(lazy: LazyPlugins[int]) -> None:
    assert lazy.names == ("a", "b", "c", "d", "e")
    assert not {name for name in sys.modules if name.startswith("sk_lazy")}


def test_requesting_a_plug_in_loads_only_that_one(lazy: LazyPlugins[int]) -> None:
    assert lazy["b"] == 2
    assert [name for name in sys.modules if name.startswith("sk_lazy")] == ["sk_lazy_b"]
    assert lazy.faults == ()


def test_iteration_yields_only_usable_plug_ins(lazy: LazyPlugins[int]) -> None:
    assert dict(lazy) == {"a": 1, "b": 2}
    assert len(lazy) == 2
    assert {fault.name: fault.reason for fault in lazy.faults} == {
        "c": "SystemExit: ",
        "d": "OSError: hands off",
        "e": "it is a str",
    }


def test_a_broken_plug_in_is_logged_once_and_requesting_it_gives_the_reason(
    lazy: LazyPlugins[int], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        assert "e" not in lazy
        assert lazy.get("e", 7) == 7

    assert [record.getMessage() for record in caplog.records] == ["plug-in e of sk-lazy 0.3 did not load: it is a str"]
    assert lazy.why_not("e") == "plug-in e of sk-lazy 0.3 did not load: it is a str"
    assert lazy.why_not("a") is None
    assert lazy.why_not("nobody") is None
    with pytest.raises(KeyError, match="it is a str"):
        lazy["e"]
    with pytest.raises(KeyError):
        lazy["nobody"]
