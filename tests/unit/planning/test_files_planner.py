"""A planner of one method, in a process of its own for each call."""

from __future__ import annotations

import os
import time
from pathlib import Path

import psutil
import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.planner import Answer, Planner, Solved, Unsolvable
from skiros_py.planning.planners.unified import FilesPlanner
from skiros_py.programs import USUAL_LIMITS, Limits
from skiros_py.testing.conformance import PlannerContract


class Pyperplan(FilesPlanner):
    name = "pyperplan"

    def solve_files(self, domain: Path, problem: Path, folder: Path) -> str | Unsolvable:
        from pyperplan.planner import HEURISTICS, SEARCHES, search_plan

        found = search_plan(str(domain), str(problem), SEARCHES["gbf"], HEURISTICS["hff"])
        return Unsolvable() if found is None else "\n".join(step.name for step in found)


class TestPyperplanAsLibrary(PlannerContract):
    def make(self) -> Planner:
        return Pyperplan()


class Acting(FilesPlanner):
    """Does what it is told to."""

    name = "acting"

    def __init__(self, what: str, limits: Limits = USUAL_LIMITS) -> None:
        super().__init__(limits)
        self.what = what

    def solve_files(self, domain: Path, problem: Path, folder: Path) -> str | Unsolvable:
        match self.what:
            case "timed":
                return "0.5: (a x) [2]\n0.0: (b) [0.5]"
            case "doubt":
                return Unsolvable("too hard", proven=False)
            case "raise":
                raise ValueError("the third wheel came off")
            case "say":
                raise PlanningError("my licence has run out")
            case "nothing":
                return None  # type: ignore[return-value]
            case "die":
                os._exit(7)
            case "folder":
                assert Path.cwd() == folder == domain.parent == problem.parent
                return ";".join(sorted(path.name for path in folder.iterdir()))
            case "eat":
                return "x" * (8 << 30)
            case _:
                time.sleep(3600.0)
                return ""


def answer_of(what: str, limits: Limits = USUAL_LIMITS) -> Answer:
    planner = Acting(what, limits)
    try:
        return planner.solve("the domain", "the problem").result()
    finally:
        planner.close()


def test_start_times_are_read_if_the_plan_has_them() -> None:
    assert answer_of("timed") == Solved((("b",), ("a", "x")), (0.0, 0.5), (0.5, 2.0))


def test_a_search_that_was_given_up_proves_nothing() -> None:
    assert answer_of("doubt") == Unsolvable("too hard", proven=False)


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ("raise", r"planner 'acting' broke: ValueError: the third wheel came off"),
        ("say", r"planner 'acting' broke: my licence has run out"),
        ("nothing", r"planner 'acting' broke: it returned None: neither the text of a plan nor Unsolvable\(\)"),
        ("die", r"planner 'acting' ended with code 7 and said nothing"),
        ("folder", r"planner 'acting' wrote a plan whose line 1 is no step: 'call'"),
        ("eat", r"planner 'acting' broke: it ran out of memory"),
    ],
)
def test_wrong_behaviour_of_a_planner_is_a_fault_with_a_message(what: str, words: str) -> None:
    with pytest.raises(PlanningError, match=words):
        answer_of(what)


def test_a_planner_that_never_returns_is_stopped_and_its_process_is_gone() -> None:
    before = set(psutil.Process().children(recursive=True))

    with pytest.raises(PlanningError, match=r"planner 'acting' found no answer in 0\.5 s"):
        answer_of("sleep", Limits(time=0.5))

    assert not set(psutil.Process().children(recursive=True)) - before
