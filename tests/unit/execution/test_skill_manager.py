from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import Do
from skiros_py.errors import UnknownName
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import SKILLS, Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, pretend


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(tiny_world()) as made:
        yield made


def test_each_subsystem_offers_the_skills_of_its_class(bench: Bench) -> None:
    assert {agent: sorted(m.descriptions) for agent, m in bench.managers.items()} == {
        "arm_1": ["pick", "place"],
        "base_1": ["drive"],
    }


def test_the_offered_modules_are_written_into_the_world(bench: Bench) -> None:
    skills = bench.world.objects("arm_1", "sk:hasSkill")

    assert sorted(bench.world.element(skill).label for skill in skills) == ["pick", "place"]
    assert bench.world.changes[-1].reason == "registers what it can do"


def test_a_fake_robot_uses_the_fake_implementations() -> None:
    real = Skill(replace(DRIVE, help="The real one."), Do.of("drive_base"))

    with Bench(tiny_world(), (real, *SKILLS)) as bench:
        assert bench.managers["base_1"].descriptions["drive"].help == DRIVE.help


def test_the_first_of_two_implementations_is_used() -> None:
    first, second = pretend(replace(DRIVE, help="first")), pretend(replace(DRIVE, help="second"))

    with Bench(tiny_world(), (first, second)) as bench:
        assert bench.managers["base_1"].descriptions["drive"].help == "first"


def test_a_manager_without_modules_writes_nothing() -> None:
    world = tiny_world()
    before = world.version

    with Bench(world, ()) as bench:
        assert bench.tasks.capabilities == ()
    assert world.version == before


def test_a_skill_that_a_manager_does_not_offer_is_refused_with_the_offered_ones(bench: Bench) -> None:
    with pytest.raises(UnknownName, match=r"unknown module 'pik' of arm_1.*mean 'pick'"):
        bench.managers["arm_1"].start("pik", {})


class Watch(Primitive[Any]):
    name: ClassVar[str] = "watch"
    watches: ClassVar[str | None] = "sk:Gripper"
    watched: ClassVar[list[str]] = []

    @dataclass(frozen=True, slots=True)
    class Params:
        device: str = param("sk:Device", "What to watch.")

    def execute(self) -> Execution[Outcome]:
        while True:
            self.watched.append(self.params.device)
            yield


def test_watchers_run_in_the_background_for_each_device_of_their_class() -> None:
    with Bench(tiny_world(robots=2), SKILLS, (Watch,)) as bench:
        for manager in bench.managers.values():
            manager.watch()
        bench.cycle.step()

    assert sorted(Watch.watched) == ["gripper_1", "gripper_2"]
