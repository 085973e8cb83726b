from __future__ import annotations

import time
from itertools import product
from pathlib import Path

import psutil
import pytest
from support.planning import tiny_pddl

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Solved, Unsolvable
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import IN_CONTAINER

PARTS = "".join(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_a . " for n in range(2, 5))


def test_eight_concurrent_solves_each_get_their_own_correct_plan() -> None:
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


def test_a_search_without_a_plan_is_an_answer_and_not_a_fault() -> None:
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("ball_1", "slot_2"))
    planner = FastDownward()

    answer = planner.solve(texts.domain, texts.problem).result()
    planner.close()

    assert answer == Unsolvable()


def test_a_goal_that_already_holds_has_an_empty_plan() -> None:
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "box_a"))
    planner = FastDownward()

    answer = planner.solve(texts.domain, texts.problem).result()
    planner.close()

    assert answer == Solved(())


def test_invalid_pddl_is_a_fault_with_the_last_output_of_the_planner() -> None:
    planner = FastDownward()

    with pytest.raises(PlanningError, match=r"Fast Downward ended with code \d+"):
        planner.solve("(define (domain nonsense", "(define").result()
    planner.close()


def test_the_planner_leaves_no_files_in_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"))
    planner = FastDownward()

    planner.solve(texts.domain, texts.problem).result()
    planner.close()

    assert list(tmp_path.iterdir()) == []


# ------------------------------------------------------------------ calls that would take for ever


class Blind(FastDownward):
    """Searches blindly for the shortest plan."""

    def __init__(self, time_limit: float = 60.0) -> None:
        super().__init__("astar(blind())", time_limit)


def endless() -> PddlTexts:
    """Too many balls and slots for a blind search."""
    balls = "".join(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_{'ab'[n % 2]} . " for n in range(2, 16))
    slots = "".join(f"scene:slot_{n} a tiny:Slot ; sk:on scene:floor . " for n in range(3, 16))
    goal = [IN_CONTAINER(f"ball_{n}", f"slot_{n}") for n in range(1, 16)]
    return tiny_pddl(tiny_world(balls, slots), *goal)


def searching() -> list[psutil.Process]:
    """Returns what runs below this process: the translator's program, its runs, searches."""
    return [p for p in psutil.Process().children(recursive=True) if "downward" in words_of(p)]


def words_of(process: psutil.Process) -> str:
    try:
        return " ".join(process.cmdline())
    except psutil.Error:  # it has just ended
        return ""


def wait_for_search() -> list[psutil.Process]:
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        found = [p for p in searching() if Path(words_of(p).partition(" ")[0]).name == "downward"]
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError("the search never began")


def test_closing_kills_the_whole_search_and_its_result_says_that_it_was_stopped() -> None:
    texts = endless()
    planner = Blind()
    pending = planner.solve(texts.domain, texts.problem)
    running = wait_for_search()

    planner.close()

    assert running, "the search"
    _, alive = psutil.wait_procs(running, timeout=5.0)
    assert alive == []
    with pytest.raises(PlanningError, match="Fast Downward was stopped"):
        pending.result()


def test_a_call_that_is_closed_at_once_leaves_nothing_running() -> None:
    texts = endless()
    planner = Blind()
    pending = planner.solve(texts.domain, texts.problem)

    planner.close()

    assert searching() == []
    with pytest.raises(PlanningError, match="was stopped"):
        pending.result()


def test_after_its_time_limit_a_call_is_given_up_and_nothing_is_left_running() -> None:
    texts = endless()
    planner = Blind(time_limit=2.0)
    pending = planner.solve(texts.domain, texts.problem)
    running = wait_for_search()

    with pytest.raises(PlanningError, match="no answer in 2 s"):
        pending.result()

    _, alive = psutil.wait_procs(running, timeout=5.0)
    assert alive == []
    planner.close()


def test_the_planner_may_be_closed_twice() -> None:
    planner = FastDownward()

    planner.close()
    planner.close()
