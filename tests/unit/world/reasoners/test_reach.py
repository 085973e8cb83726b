"""At which locations a robot works that nothing moves."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.geometry import Pose
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.reach import ReachReasoner
from skiros_py.world.reasoners.registry import Answer, Reasoners
from skiros_py.world.world import World

ONTOLOGY = Ontology.load([Path(__file__).parents[4] / "ontologies"])
REACH = ReachReasoner()


def answer(*, at: Pose | None, reach: float | None = 1.0, base: bool = False, class_: str = "kitting:Kit") -> Answer:
    """Returns whether a robot at (0.1, 0) reaches a place of a class."""
    world = World(ONTOLOGY, reasoners=Reasoners((REACH,)))
    with world.transaction("test", "things") as tx:
        tx.add("sk:Floor", id="floor")
        for robot_part in ("sk:Robot", "sk:Arm", *(["sk:Base"] if base else [])):
            name = robot_part.removeprefix("sk:").lower()
            tx.add(robot_part, id=name, placement=Placement("sk:on", "floor") if name == "robot" else None)
            if name != "robot":
                tx.relate("robot", "sk:hasA", name)
        tx.set("robot", "sk:pose", Pose((0.1, 0.0, 0.0)))
        tx.set("arm", "sk:reach", reach)
        tx.add(class_, id="place", properties={"sk:pose": at} if at else {}, placement=Placement("sk:on", "floor"))
    return REACH.answer(world, "robot", "sk:reaches", "place")


@pytest.mark.parametrize(("x", "holds"), [(1.09, True), (1.11, False), (-0.89, True), (-0.91, False)])
def test_a_place_is_reached_within_the_reach_of_an_arm_seen_from_above(x: float, holds: bool) -> None:
    found = answer(at=Pose((x, 0.0, 0.7)))

    assert found.holds is holds
    assert found.value == pytest.approx(1.0 - abs(x - 0.1))
    assert f"{abs(x - 0.1):.2f} m from robot" in found.reason


def test_of_a_storage_place_the_area_counts_on_which_things_lie() -> None:
    assert answer(at=Pose((1.16, 0.0, 0.0)), class_="kitting:Pallet").holds, "its area is 0.07 m nearer"
    assert not answer(at=Pose((1.18, 0.0, 0.0)), class_="kitting:Pallet").holds


def test_a_robot_with_a_base_drives_instead() -> None:
    found = answer(at=Pose((0.5, 0.0, 0.0)), base=True)

    assert not found.holds
    assert found.reason == "robot drives to where it works"


@pytest.mark.parametrize("unknown", [{"at": None}, {"at": Pose(), "reach": None}])
def test_nothing_is_reached_where_a_pose_or_the_reach_is_unknown(unknown: dict[str, None]) -> None:
    assert not answer(**unknown).holds  # type: ignore[arg-type]
