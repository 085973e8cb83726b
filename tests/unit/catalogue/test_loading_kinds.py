"""What an entry point of each group must name; anything else is refused with what would be right."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from skiros_py.catalogue import KINDS
from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.plugins.installation import GROUPS
from skiros_py.plugins.plugin import Plugin
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.signals import Signal
from skiros_py.skills.primitive import Primitive
from skiros_py.testing import CONDITIONS, SKILLS
from skiros_py.world.reasoners.registry import Reasoner
from skiros_py.world.reasoners.sizes import SizeReasoner

SKILL = SKILLS[0]
CONDITION = next(iter(CONDITIONS.values()))


class Wave(Primitive[Any]):
    name = "it"

    @dataclass(frozen=True)
    class Params:
        pass

    def execute(self) -> Any:
        yield


class Unfinished(Primitive[Any]):
    name = "it"
    Params = Wave.Params


class Bare(Wave):
    Params = None  # type: ignore[assignment]


class Called(Wave):
    name = "that"


class Nameless(Primitive[Any]):
    def execute(self) -> Any:
        yield


def problem(kind: str, value: Any) -> str | None:
    group = f"skiros.{kind}"
    return KINDS[group].problem(Plugin(group, "it", "some 1.0", value))


def test_there_is_a_row_for_every_group() -> None:
    assert set(KINDS) == set(GROUPS)


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("skills", SKILL),
        ("skills", [SKILL, SKILL]),
        ("skills", (SKILL,)),
        ("primitives", Wave),
        ("conditions", CONDITION),
        ("reasoners", SizeReasoner),
        ("planners", dict),
        ("drivers", lambda spec, seed: None),
        ("ontologies", Path()),
        ("robots", Path()),
        ("scenes", Path()),
    ],
)
def test_a_valid_object_of_each_kind_has_no_problem(kind: str, value: Any) -> None:
    assert problem(kind, value) is None


@pytest.mark.parametrize(
    ("kind", "value", "says"),
    [
        (
            "skills",
            SKILL.description,
            "it is a SkillDescription, nothing for skills: name a Skill, or a sequence of th",
        ),
        ("skills", (), "it is a tuple, nothing for skills"),
        ("skills", [SKILL, 5], "it is a list, nothing for skills"),
        ("skills", "drive", "it is a str, nothing for skills"),
        ("skills", replace(SKILL, label=5), "its label is 5, not a text"),  # type: ignore[arg-type]
        ("primitives", SKILL, "it is a Skill, nothing for primitives: name a subclass of Primitive"),
        ("primitives", int, "it is a type, nothing for primitives"),
        ("primitives", Called, "its name is 'that': compositions find it as 'it', so both must be the same"),
        ("primitives", Nameless, "it has no name: compositions find it as 'it'"),
        ("primitives", Unfinished, "it does not define execute"),
        ("primitives", Bare, "it has no Params: a frozen dataclass, empty where it takes nothing"),
        ("conditions", CONDITION("a", "b"), "it is a Condition, nothing for conditions: name a ConditionType"),
        ("conditions", replace(CONDITION, name=["a"]), "its name is ['a'], not a word"),
        ("conditions", replace(CONDITION, name="Is Near"), "no goal can say its name 'Is Near'"),
        ("conditions", replace(CONDITION, name="not"), "no goal can say its name 'not'"),
        ("conditions", replace(CONDITION, name="2Near"), "no goal can say its name '2Near'"),
        ("reasoners", Reasoner.answer, "it is a function, nothing for reasoners: name a subclass of Reasoner"),
        ("planners", "fast", "it is a str, nothing for planners: name what makes a Planner when it is called"),
        ("drivers", type("Empty", (), {"read": None}), "it is no CellDriver: it has no exchange, no halt, no release"),
        ("drivers", 5, "it is a int, nothing for drivers: name what makes a CellDriver when it is called"),
        ("scenes", "kitting.ttl", "it is a str, nothing for scenes: name a package with scene files, or a Path"),
    ],
)
def test_a_fault_is_reported_with_the_valid_choices(kind: str, value: Any, says: str) -> None:
    assert (problem(kind, value) or "nothing").startswith(says)


class Fine:
    """A signal provider."""

    name = "fine"
    provides = (Signal("fine"),)
    requests = ()
    every_cycle = False

    def compute(self, inputs: Any, time: float) -> Any:
        return {"fine": 1.0}


class Half:
    """A signal provider that lacks its computation."""

    name = "half"
    provides = (Signal("half"),)
    requests = ()


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (None, "'NoneType' object is not iterable"),
        ([3, "x"], "3 is no SignalProvider: its name is missing or wrong"),
        ([Half()], "its compute is missing or wrong"),
    ],
)
def test_invalid_signal_providers_are_left_out_and_named(made: Any, why: str) -> None:
    catalogue = Catalogue({}, {}, {}, {}, {"signals/odd": "lab 1.0"}, signals={"odd": lambda _cell: made})

    made, (fault,) = catalogue.signal_providers(CellSpec((), ()))

    assert made == []
    assert fault.reason.startswith("signals 'odd' of lab 1.0: ")
    assert why in fault.reason


def test_signal_factories_that_hang_are_interrupted_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def hangs(_cell: CellSpec) -> list[Any]:
        while True:
            pass

    monkeypatch.setattr("skiros_py.catalogue.catalogue._LONGEST", 0.2)
    sources = {"signals/odd": "lab 1.0", "signals/fine": "hut 2.0"}
    catalogue = Catalogue({}, {}, {}, {}, sources, signals={"odd": hangs, "fine": lambda _cell: [Fine()]})

    ((provider, source),), (fault,) = catalogue.signal_providers(CellSpec((), ()))

    assert (provider.name, source) == ("fine", "hut 2.0")
    assert "signals 'odd' of lab 1.0 did not end within 0.2 s" in fault.reason
