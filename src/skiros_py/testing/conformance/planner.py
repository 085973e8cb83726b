"""What every planner of tasks must do: PDDL in, steps out."""

# ruff: noqa: D102 - the names of tests say what they claim

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path

import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.planner import Answer, Planner, Solved, Unsolvable
from skiros_py.testing.conformance.pending import check_pending

_DOMAIN = """
(define (domain doves)
  (:requirements :typing)
  (:types dove hole - object)
  (:predicates (out ?d - dove) (home ?d - dove) (free ?h - hole) (in ?d - dove ?h - hole))
  (:action enter :parameters (?d - dove ?h - hole)
    :precondition (and (out ?d) (free ?h))
    :effect (and (not (out ?d)) (home ?d) (not (free ?h)) (in ?d ?h)))
  (:action leave :parameters (?d - dove ?h - hole)
    :precondition (in ?d ?h)
    :effect (and (out ?d) (not (home ?d)) (free ?h) (not (in ?d ?h)))))
"""
_ENOUGH_TO_SEARCH = 14
"""Doves and one hole less: there is no plan, and proving that takes long."""


class PlannerContract(ABC):
    """Claims about a :class:`~skiros_py.planning.planners.planner.Planner`; every test gets one of its own."""

    @abstractmethod
    def make(self) -> Planner:
        """Returns the planner."""

    @pytest.fixture
    def planner(self) -> Iterator[Planner]:
        """A planner of its own for each test."""
        planner = self.make()
        yield planner
        planner.close()

    def test_it_has_a_name(self, planner: Planner) -> None:
        assert planner.name

    def test_it_says_which_requirements_it_takes(self, planner: Planner) -> None:
        assert {":strips", ":typing"} <= set(planner.supports)
        assert all(word.startswith(":") for word in planner.supports)

    def test_a_task_is_solved_in_the_names_of_the_task(self, planner: Planner) -> None:
        answer = self._answer(planner, "(in dove_1 hole_1)")

        assert answer == Solved((("enter", "dove_1", "hole_1"),))

    def test_a_plan_reaches_its_goal_step_by_step(self, planner: Planner) -> None:
        start = "(in dove_1 hole_1) (in dove_2 hole_2) (free hole_3)"
        problem = _problem("(and (in dove_1 hole_2) (in dove_2 hole_1))", start)

        answer = check_pending(planner.solve(_DOMAIN, problem))

        assert isinstance(answer, Solved)
        assert _replayed(answer, {("dove_1", "hole_1"), ("dove_2", "hole_2")}) == {
            ("dove_1", "hole_2"),
            ("dove_2", "hole_1"),
        }

    def test_a_goal_that_holds_has_an_empty_plan(self, planner: Planner) -> None:
        assert self._answer(planner, "(out dove_1)") == Solved(())

    def test_no_plan_is_an_answer(self, planner: Planner) -> None:
        assert self._answer(planner, "(and (in dove_1 hole_1) (in dove_2 hole_1))") == Unsolvable()

    def test_several_tasks_at_once_each_get_their_own_answer(self, planner: Planner) -> None:
        wanted = [(f"dove_{d}", f"hole_{h}") for d in (1, 2) for h in (1, 2)]

        pending = [planner.solve(_DOMAIN, _problem(f"(in {dove} {hole})")) for dove, hole in wanted]

        assert [p.result() for p in pending] == [Solved((("enter", *pair),)) for pair in wanted]

    def test_what_is_no_pddl_is_a_fault_and_no_answer(self, planner: Planner) -> None:
        with pytest.raises(PlanningError):
            planner.solve("(define (domain nonsense", "(define").result()

    def test_nothing_is_left_in_the_present_folder(
        self, planner: Planner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        self._answer(planner, "(in dove_1 hole_1)")

        assert list(tmp_path.iterdir()) == []

    def test_closing_ends_what_still_searches(self, planner: Planner) -> None:
        count = _ENOUGH_TO_SEARCH
        goal = " ".join(f"(home dove_{n})" for n in range(1, count + 1))
        pending = planner.solve(_DOMAIN, _problem(f"(and {goal})", doves=count, holes=count - 1))
        time.sleep(1.0)
        assert not pending.done(), "it answered at once: this claim needs a task that takes long"
        began = time.monotonic()

        planner.close()

        assert time.monotonic() - began < 10.0
        with pytest.raises(PlanningError):
            pending.result()

    def test_a_closed_planner_takes_nothing_more(self, planner: Planner) -> None:
        planner.close()
        planner.close()

        with pytest.raises(PlanningError):
            planner.solve(_DOMAIN, _problem("(in dove_1 hole_1)")).result()

    def _answer(self, planner: Planner, goal: str) -> Answer:
        return check_pending(planner.solve(_DOMAIN, _problem(goal)))


def _problem(goal: str, start: str = "", *, doves: int = 2, holes: int = 3) -> str:
    """Returns a problem; unless it is given, all doves are out at the start."""
    birds, places = [f"dove_{n + 1}" for n in range(doves)], [f"hole_{n + 1}" for n in range(holes)]
    outside = " ".join([*(f"(out {bird})" for bird in birds), *(f"(free {place})" for place in places)])
    return f"""
(define (problem test) (:domain doves)
  (:objects {" ".join(birds)} - dove {" ".join(places)} - hole)
  (:init {start or outside})
  (:goal {goal}))
"""


def _replayed(plan: Solved, inside: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Does the steps of a plan; each must be possible."""
    for action, dove, hole in plan.steps:
        if action == "enter":
            assert all(dove != d and hole != h for d, h in inside)
            inside = inside | {(dove, hole)}
        else:
            assert (dove, hole) in inside
            inside = inside - {(dove, hole)}
    return inside
