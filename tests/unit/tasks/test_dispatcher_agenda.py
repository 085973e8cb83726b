from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.planning.plan import Step
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.tasks.dispatcher import Active, Agenda
from skiros_py.tasks.trace import StepRun


class Run:
    """A skill that runs, and says nothing about it."""

    id = ""
    done = False
    result: Outcome = Success()
    account: Mapping[str, Any] = {}

    def cancel(self, reason: str) -> None: ...

    def pause(self) -> None: ...

    def resume(self) -> None: ...

    def step(self) -> None: ...

    def stop(self) -> None: ...


def active(step: Step, number: int = 1) -> Active:
    return Active(StepRun(number, step, "arm_1", 0.0), "robot_1", Run())


def start(agenda: Agenda, index: int) -> None:
    agenda.running[index] = active(agenda.steps[index])


def steps(number: int) -> list[Step]:
    return [Step(f"s{n}", {}) for n in range(number)]


@st.composite
def orders(draw: st.DrawFn) -> list[set[int]]:
    number = draw(st.integers(0, 12))
    return [draw(st.sets(st.integers(0, max(0, n - 1)), max_size=3)) if n else set() for n in range(number)]


def run_all(agenda: Agenda, pick: st.DataObject) -> list[int]:
    """Starts and ends steps in some order that the agenda allows; returns the order in which they started."""
    started: list[int] = []
    while not agenda.done:
        choices = [("start", i) for i in agenda.ready] + [("end", i) for i in agenda.running]
        what, index = pick.draw(st.sampled_from(choices))
        if what == "start":
            start(agenda, index)
            started.append(index)
        else:
            agenda.end(index)
    return started


@given(orders(), st.data())
def test_every_step_comes_once_and_after_those_it_waits_for(after: list[set[int]], data: st.DataObject) -> None:
    started = run_all(Agenda(steps(len(after)), after), data)

    assert sorted(started) == list(range(len(after)))
    assert all(started.index(before) < started.index(i) for i, own in enumerate(after) for before in own)


def test_steps_that_wait_for_nothing_are_ready_together() -> None:
    agenda = Agenda(steps(3), [set(), set(), {0, 1}])

    assert agenda.ready == (0, 1)
    start(agenda, 0)
    agenda.end(0)
    assert agenda.ready == (1,)
    start(agenda, 1)
    assert agenda.ready == ()
    agenda.end(1)
    assert agenda.ready == (2,)


def test_what_is_to_be_done_once_more_is_waiting_again_in_its_place() -> None:
    agenda = Agenda(steps(3), [set(), {0}, {1}])
    start(agenda, 0)
    del agenda.running[0]

    assert agenda.waiting == (0, 1, 2)
    assert agenda.ready == (0,)


def test_leading_to_goes_over_any_number_of_steps() -> None:
    agenda = Agenda(steps(4), [set(), {0}, set(), {1}])

    assert agenda.leads_to(0, 3)
    assert not agenda.leads_to(2, 3)
    assert not agenda.leads_to(3, 0)


def test_what_runs_of_another_plan_comes_first_for_those_only_that_share_something_with_it() -> None:
    agenda = Agenda(steps(2), [set(), set()]).with_running([active(Step("old", {}))], {(0, 1)})

    assert [step.skill for step in agenda.steps] == ["old", "s0", "s1"]
    assert ([*agenda.running], agenda.ready) == ([0], (1,))
    agenda.end(0)
    assert agenda.ready == (1, 2)


def test_leading_to_is_soon_known_where_there_are_very_many_ways_from_one_step_to_another() -> None:
    after: list[set[int]] = [set(), set()]
    for n in range(2, 82, 2):
        after += [{n - 2, n - 1}] * 2
    agenda = Agenda(steps(len(after) + 1), [set(), *({i + 1 for i in before} for before in after)])

    assert agenda.leads_to(1, len(after))
    assert not agenda.leads_to(0, len(after))
