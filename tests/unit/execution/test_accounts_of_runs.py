"""What a run tells of itself afterwards: with what, which conditions were looked at, what it changed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from skiros_py.behaviours import Do, P
from skiros_py.execution.monitor import Status
from skiros_py.execution.running import RunningModule
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.testing import SKILLS, Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, HAS_PART, REACHABLE
from skiros_py.world.change import Writer


class Wander(Primitive["Wander.Params"]):
    """Goes somewhere in two steps."""

    name: ClassVar[str] = "wander"

    @dataclass(frozen=True, slots=True)
    class Params:
        goes: str = param("sk:Location", "Where to.")

    def execute(self) -> Execution[Outcome]:
        for place in ("floor", self.params.goes):
            with self.world.transaction("wander", "goes on") as tx:
                tx.place("robot_1", "sk:at", place)
            yield
        return Success()


def wandering(description: SkillDescription) -> Skill:
    return Skill(description, Do.of("wander", goes=P("Location")), driver="fake")


def ended(bench: Bench, **arguments: Any) -> RunningModule:
    running = bench.start("drive", **arguments)
    bench.until(lambda: running.done)
    return running


def found(running: RunningModule) -> list[tuple[str, bool]]:
    return [(row["kind"], row["holds"]) for row in running.account["conditions"]]


def test_a_run_account_contains_given_and_inferred_parameters() -> None:
    with Bench(tiny_world(), SKILLS) as bench:
        running = ended(bench, Location="box_a")
    assert running.account["inputs"] == {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}


def test_a_run_account_contains_pre_hold_and_postconditions() -> None:
    watched = replace(DRIVE, pre=(REACHABLE("Location"),), hold=(HAS_PART("Robot", "Base"),))
    with Bench(tiny_world(), (wandering(watched),), (Wander,)) as bench:
        running = ended(bench, Location="box_a")
    assert found(running) == [("pre", True), ("hold", True), ("post", True)]


def test_a_failed_postcondition_is_in_the_account_with_its_reason() -> None:
    idle = Skill(replace(DRIVE, pre=()), Do.of("wander", goes="box_b"), driver="fake")
    with Bench(tiny_world(), (idle,), (Wander,)) as bench:
        running = ended(bench, Location="box_a")
    row = running.account["conditions"][-1]
    assert (row["kind"], row["holds"]) == ("post", False)
    assert "robot_1" in " ".join(row["why"])


def test_the_account_and_events_name_the_implementation_tried_last() -> None:
    free = replace(DRIVE, pre=())
    ways = (
        Skill(free, Do.of("wander", goes="box_b"), driver="fake", label="astray", order=1),
        Skill(free, Do.of("wander", goes=P("Location")), driver="fake", label="there", order=2),
    )
    with Bench(tiny_world(), ways, (Wander,)) as bench:
        running = ended(bench, Location="box_a")
        told = [event.implementation for event in bench.events if event.module == "drive"]
        parts = {event.implementation for event in bench.events if event.module == "wander"}
    assert running.account["implementation"] == "there"
    assert (told[0], told[-1], parts) == ("astray", "there", {None})


def test_a_run_with_unresolved_parameters_has_no_implementation_in_its_account() -> None:
    with Bench(tiny_world(), SKILLS) as bench:
        running = ended(bench, Robot="robot_1", Location="nowhere")
    assert running.account["implementation"] is None


def test_events_of_a_module_and_its_parts_name_their_task() -> None:
    with Bench(tiny_world(), (wandering(replace(DRIVE, pre=())),), (Wander,)) as bench:
        running = bench.managers["base_1"].start("drive", {"Location": "box_a"}, task="kit-17")
        bench.until(lambda: running.done)
        ended(bench, Location="box_b")
    named = [(event.module, event.task) for event in bench.events if event.status is Status.TERMINATED]
    assert named == [("wander", "kit-17"), ("drive", "kit-17"), ("wander", ""), ("drive", "")]


def test_an_account_has_the_numbers_of_the_changes_that_the_run_made_and_no_others() -> None:
    with Bench(tiny_world(), (wandering(replace(DRIVE, pre=())),), (Wander,)) as bench:
        before = bench.world.version
        running = bench.start("drive", Location="box_a")
        bench.advance(0.005)
        with bench.world.transaction("anna", "moves it meanwhile", writer=Writer.PERSON) as tx:
            tx.set("box_b", "rdfs:label", "other box")
        bench.until(lambda: running.done)
        own = [change.number for change in bench.world.changes_since(before) if change.author == "wander"]
    assert len(own) == 2
    assert running.account["changes"] == own
