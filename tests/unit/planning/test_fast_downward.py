from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.fast_downward import FastDownward
from skiros_py.planning.planner import Solved, Unsolvable
from skiros_py.testing import tiny_pddl, tiny_world
from skiros_py.testing.tiny_skills import IN_CONTAINER

PARTS = "".join(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_a . " for n in range(2, 5))


def test_eight_solves_at_once_each_get_their_own_right_plan() -> None:
    world = tiny_world(PARTS)
    wanted = [(f"ball_{n}", slot) for n, slot in product(range(1, 5), ("slot_1", "slot_2"))]
    texts = [tiny_pddl(world, IN_CONTAINER(*pair)) for pair in wanted]
    planner = FastDownward()

    pending = [planner.solve(t.domain, t.problem) for t in texts]
    answers = [p.result() for p in pending]
    planner.close()

    assert all(isinstance(answer, Solved) for answer in answers)
    placed = [next(s[4:6] for s in a.steps if s[0] == "place") for a in answers if isinstance(a, Solved)]
    assert placed == wanted


def test_no_plan_is_an_answer() -> None:
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("ball_1", "slot_2"))
    planner = FastDownward()

    answer = planner.solve(texts.domain, texts.problem).result()
    planner.close()

    assert answer == Unsolvable()


def test_a_goal_that_holds_has_an_empty_plan() -> None:
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "box_a"))
    planner = FastDownward()

    answer = planner.solve(texts.domain, texts.problem).result()
    planner.close()

    assert answer == Solved(())


def test_texts_that_are_not_pddl_break_the_planner_with_its_own_last_words() -> None:
    planner = FastDownward()

    with pytest.raises(PlanningError, match=r"Fast Downward ended with code \d+"):
        planner.solve("(define (domain nonsense", "(define").result()
    planner.close()


def test_nothing_is_left_in_the_folder_where_it_was_called(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"))
    planner = FastDownward()

    planner.solve(texts.domain, texts.problem).result()
    planner.close()

    assert list(tmp_path.iterdir()) == []
