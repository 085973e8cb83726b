"""The small version of ``benchmarks/arm_motion.py``: motions in shelves, judged by Coal alone."""

from __future__ import annotations

import numpy as np
from chance import Chance
from shelves import Judge, problems

from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import MotionPlan


def test_ways_from_cell_to_cell_of_a_shelf_touch_nothing(robot: RobotSpec) -> None:
    motion, judge = ArmMotion(robot), Judge(robot)
    drawn = [one for seed in (1, 22) for one in problems(robot, range(seed, seed + 1))]
    # in shelf 22, the first postures that are found for the goal touch a board

    answers = [motion.plan(problem.request("arm")) for problem in drawn]

    assert [problem.kind for problem in drawn] == ["joint", "pose"]
    for problem, answer in zip(drawn, answers, strict=True):
        assert isinstance(answer, MotionPlan), answer
        assert judge.first_contact(answer.legs[0].positions[::4], problem.obstacles) == ""


def test_the_judge_sees_what_a_straight_way_would_touch(robot: RobotSpec) -> None:
    (problem,) = problems(robot, range(1, 2))
    straight = np.linspace(problem.start, problem.goal, 40)

    touched = Judge(robot).first_contact(straight, problem.obstacles)

    assert "touches side_" in touched or "touches board_" in touched


def test_odd_and_even_seeds_draw_from_different_halves_of_a_range() -> None:
    odd, even = ([Chance(seed).within(0.0, 1.0) for seed in seeds] for seeds in (range(1, 40, 2), range(0, 40, 2)))

    assert max(odd) <= 0.5 <= min(even)
