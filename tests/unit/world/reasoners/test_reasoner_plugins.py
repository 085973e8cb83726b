"""Distributions with reasoners as pip would leave them behind, good, broken and clashing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.plugins.plugin import PluginFault
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import load_reasoners

Install = Callable[..., None]

COLOURS = """
from skiros_py.world.reasoners.registry import Answer, Reasoner

class Colours(Reasoner):
    name = "colours"
    relations = frozenset({"paint:likeColour"})

    def answer(self, view, subject, relation, object_):
        return Answer(True, "all cats are grey")

class Near(Reasoner):
    name = "nearer"
    relations = frozenset({"sk:near"})

class Silent(Reasoner):
    name = "silent"
    relations = frozenset({"paint:darkerThan"})

class Other(Colours):
    relations = frozenset()

class Nameless(Reasoner):
    pass

class Needy(Reasoner):
    name = "needy"

    def __init__(self, something):
        pass

class Odd(Reasoner):
    name = "odd"
    relations = 5

NUMBER = 5
OBJECT = Colours()
"""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Installs a distribution with entry points of the group, and one module."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(name: str, text: str, **points: str) -> None:
        info = tmp_path / f"{name}-0.3.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.3\n", encoding="utf-8")
        lines = ["[skiros.reasoners]", *(f"{key} = {name}:{value}" for key, value in points.items())]
        (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")

    return make


def loaded() -> tuple[list[str], dict[str, PluginFault]]:
    reasoners, faults = load_reasoners()
    return [reasoner.name for reasoner in reasoners], {fault.name: fault for fault in faults}


def test_built_in_reasoners_are_loaded_like_plug_ins() -> None:
    names, faults = loaded()

    assert names == ["reach", "sizes", "spatial"]
    assert faults == {}


def test_reasoners_of_plug_ins_come_after_the_built_in_reasoners(install: Install) -> None:
    install("sk_colours", COLOURS, aaa="Colours")

    assert loaded() == (["reach", "sizes", "spatial", "colours"], {})
    assert load_reasoners()[0].of("paint:likeColour").name == "colours"


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ("Near", "reasoners spatial and nearer both compute sk:near"),
        ("Silent", "reasoner 'silent' declares paint:darkerThan but has no method 'answer'"),
        ("Nameless", "it has no name"),
        ("NUMBER", "it is a int, nothing for reasoners: name a subclass of Reasoner"),
        ("OBJECT", "it is a Colours, nothing for reasoners: name a subclass of Reasoner"),
        ("Needy", "TypeError: "),
        ("Odd", "TypeError: "),
        ("Missing", "AttributeError: "),
    ],
)
def test_an_unusable_reasoner_is_reported_and_does_not_affect_others(install: Install, value: str, reason: str) -> None:
    install(f"sk_bad_{value.lower()}", COLOURS, bad=value, good="Colours")

    names, faults = loaded()
    assert names == ["reach", "sizes", "spatial", "colours"]
    assert list(faults) == ["bad"]
    assert faults["bad"].reason.startswith(reason)
    assert faults["bad"].distribution == f"sk_bad_{value.lower()} 0.3"


def test_a_reasoner_whose_relations_are_not_declared_as_computed_is_left_out(
    install: Install, ontology: Ontology
) -> None:
    install(
        "sk_undeclared",
        f"{COLOURS}\nclass On(Reasoner):\n    name = 'on'\n    relations = frozenset({{'sk:on'}})",
        a="Colours",
        b="On",
    )

    reasoners, faults = load_reasoners(ontology)

    assert [reasoner.name for reasoner in reasoners] == ["reach", "sizes", "spatial"]
    assert {fault.name: fault.reason for fault in faults} == {
        "a": "no ontology declares paint:likeColour below sk:computed",
        "b": "no ontology declares sk:on below sk:computed",
    }


def test_the_first_of_two_reasoners_with_one_name_is_used(install: Install) -> None:
    install("sk_twice", COLOURS, one="Colours", two="Other")

    names, faults = loaded()
    assert names == ["reach", "sizes", "spatial", "colours"]
    assert faults["two"].reason == "there is a reasoner 'colours' already"


def test_a_module_that_raises_on_import_does_not_affect_others(install: Install) -> None:
    install("sk_shattered", "1 / 0", bad="X")

    names, faults = loaded()
    assert names == ["reach", "sizes", "spatial"]
    assert "ZeroDivisionError" in faults["bad"].traceback
