"""Contract tests in physics: the simulator has the last word."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import Do
from skiros_py.catalogue import Catalogue, load_catalogue
from skiros_py.checking.contract import Contract, check_simulated, is_simulable
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import DRIVE as TINY_DRIVE
from skiros_py.testing.tiny import pretend


class Boast(Primitive["Boast.Params"]):
    """Says that it is where it shall be, and moves nothing."""

    name: ClassVar[str] = "boast"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        yield
        self.assert_effects(reason="it feels so")
        return Success()


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    found = load_catalogue()
    return replace(found, primitives={**{name: found.primitives[name] for name in found.primitives}, "boast": Boast})


def real_drive(catalogue: Catalogue) -> Skill:
    return catalogue.skills["drive"]


def texts(contract: Contract) -> Sequence[str]:
    return [found.text for found in contract.findings]


def test_only_skills_for_any_driver_or_the_simulation_are_simulable() -> None:
    skill: Any = pretend(TINY_DRIVE)

    assert [is_simulable(replace(skill, driver=driver)) for driver in (None, "pybullet", "fake", "ur5")] == [
        True,
        True,
        False,
        False,
    ]


@pytest.mark.physics
def test_a_skill_that_does_what_it_declares_passes(catalogue: Catalogue) -> None:
    contract = check_simulated(real_drive(catalogue), "kitting", catalogue)

    assert (texts(contract), contract.where) == ([], "kitting, simulated")
    assert isinstance(contract.outcome, Success)


@pytest.mark.physics
def test_an_effect_that_is_believed_but_not_true_is_found(catalogue: Catalogue) -> None:
    contract = check_simulated(replace(real_drive(catalogue), body=Do.of("boast")), "kitting", catalogue)

    (text,) = texts(contract)
    assert isinstance(contract.outcome, Success)
    assert "is believed, and is not so" in text
