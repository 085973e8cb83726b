"""A hand grasps from straight above; it leans where that is out of reach, here or where the part goes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import pytest
from support.stepping import run

from skiros_primitives import grasp
from skiros_primitives.grasp import Grasp
from skiros_py.geometry import Pose
from skiros_py.ports.motion import MotionPlan, NoMotion
from skiros_py.skills.primitive import Execution

STRAIGHT, LEANING = range(2), range(2, 6)


class Grasping(Grasp):
    """One that plans nothing in fact.

    Args:
        possible: The numbers of the grasps that are within reach.
    """

    robot: Any = None
    arm: Any = type("Arm", (), {"spec": None})
    world: Any = type("World", (), {"placement": staticmethod(lambda _: None)})
    params: Any = type("Params", (), {"part": "part_1"})

    def __init__(self, possible: Iterable[int]) -> None:
        self._possible = frozenset(possible)
        self.asked: list[range] = []

    def plan_fresh(
        self, choice: str, tools: Sequence[Pose], touching: Iterable[str], among: Sequence[int]
    ) -> Execution[tuple[int, MotionPlan | NoMotion]]:
        assert (choice, len(tools), set(touching)) == ("grasp", 6, {"part_1"})
        assert isinstance(among, range)
        self.asked.append(among)
        yield
        found = next((number for number in among if number in self._possible), None)
        return (0, NoMotion.because("reach", "out of reach")) if found is None else (found, MotionPlan(0, ()))


@pytest.mark.parametrize(
    ("possible", "delivers", "chosen", "asked"),
    [
        ({0, 3}, True, 0, [STRAIGHT]),
        ({0, 3}, False, 3, [STRAIGHT, LEANING]),  # where it goes, the hand has to lean
        ({0}, False, 0, [STRAIGHT, LEANING]),  # here it cannot
        ({3}, True, 3, [STRAIGHT, LEANING]),
        (set(), True, None, [STRAIGHT, LEANING]),
    ],
)
def test_a_hand_leans_only_where_it_has_to(
    monkeypatch: pytest.MonkeyPatch, possible: set[int], delivers: bool, chosen: int | None, asked: list[range]
) -> None:
    def can_put_down(*_: Any) -> Execution[bool]:
        yield
        yield
        return delivers

    monkeypatch.setattr(grasp, "can_put_down", can_put_down)
    primitive = Grasping(possible)

    number, plan = run(primitive._plan(Pose(), [Pose()] * 6, 2))

    assert primitive.asked == asked
    assert isinstance(plan, NoMotion if chosen is None else MotionPlan)
    assert chosen is None or number == chosen
