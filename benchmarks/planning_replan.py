"""The time from a pick that drops its part to the next step of the new plan, on a fake robot."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from typing import Any, ClassVar

from planning_worlds import kitting_world

from skiros_py.behaviours import AssertEffects, Do, P, Sequence
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import Bench
from skiros_py.world.element import Placement
from skiros_py.world.vocabulary import IN, ON
from skiros_py.world.world import World
from skiros_skills import kitting
from skiros_skills.conditions import OBJECT_AT_LOCATION
from skiros_skills.drive import DESCRIPTION as DRIVE
from skiros_skills.pick import DESCRIPTION as PICK
from skiros_skills.place import PLACE_FAKE

_GOAL = ("ObjectAtLocation(Starter, kit_1_a)", "ObjectAtLocation(compressor_1, kit_1_b)")


class Slip(Primitive[Any]):
    """Drops the first picked part; later it only records its start."""

    name: ClassVar[str] = "slip"
    world: ClassVar[World]
    failed: ClassVar[float | None] = None
    times: ClassVar[list[float]] = []

    @dataclass(frozen=True, slots=True)
    class Params:
        """Description."""

        what: str = param("sk:SpatialThing", "What it is about.")

    def execute(self) -> Execution[Outcome]:
        """Fails, or records the time since the failure [s]."""
        if Slip.failed is not None:
            Slip.times.append(time.perf_counter() - Slip.failed)
        elif self.params.what in Slip.world.instances(kitting.PART):
            with Slip.world.transaction("slip", "seen to fall") as tx:
                tx.place(self.params.what, ON, "floor")
            Slip.failed = time.perf_counter()
            return Failure(f"{self.params.what} fell down")
        yield
        return Success()


_DRIVE = Skill(DRIVE, Sequence.of(Do.of("slip", what=P("Location")), AssertEffects(0.02)), driver="fake")
_PICK = Skill(PICK, Sequence.of(Do.of("slip", what=P("Object")), AssertEffects(0.02)), driver="fake")


def replanning_times(runs: int) -> tuple[float, ...]:
    """Returns, for each run, the wall time from the failure to the start of the next step [s].

    Raises:
        SystemExit: The goal was not reached, or not by another plan.
    """
    found = []
    for _ in range(runs):
        Slip.failed = None
        Slip.times.clear()
        Slip.world = kitting_world()
        with Slip.world.transaction("benchmark", "a second one") as tx:
            tx.add(kitting.STARTER, placement=Placement(IN, "pallet_b"))
        words = {OBJECT_AT_LOCATION.name: OBJECT_AT_LOCATION}
        with Bench(Slip.world, (_DRIVE, _PICK, PLACE_FAKE), (Slip,), conditions=words) as bench:
            if not bench.pursue(*_GOAL).reached or len(bench.plans) < 2:
                raise SystemExit("the goal was not reached by another plan after a part had fallen down")
        found.append(Slip.times[0])
    return tuple(found)


if __name__ == "__main__":
    print(f"{statistics.median(replanning_times(5)) * 1e3:.0f} ms")
