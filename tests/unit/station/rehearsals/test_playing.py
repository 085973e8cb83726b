"""A plan that is carried out in a second world; here one without physics."""

from __future__ import annotations

from dataclasses import replace

from skiros_py.station.rehearsals.order import RehearsalOrder, order_from
from skiros_py.station.rehearsals.playing import rehearse
from skiros_py.station.session import Options
from skiros_py.station.worlds import open_world
from skiros_py.tasks.rehearsal import RehearsedStep, StepState


def order(*goal: str) -> RehearsalOrder:
    asked = order_from(open_world("kitting"), Options(seed=3), goal)
    return replace(asked, options=replace(asked.options, fake=True))


def test_steps_that_a_plan_repeats_are_listed_each() -> None:
    told: list[str] = []
    result = rehearse(order(), lambda event: told.append(event.text) if isinstance(event, RehearsedStep) else None)

    (play,) = result.rounds[0].plays
    assert [step.text for step in play.steps] == told
    assert told.count("drive kit_1") > 1
    assert {step.tries for step in play.steps} == {1}
    assert {step.state for step in play.steps} == {StepState.DONE}


def test_a_plan_that_takes_too_long_fails_and_shows_what_was_not_tried() -> None:
    asked = order("InKit(Starter, kit_1)")

    result = rehearse(replace(asked, limit=0.001))

    (play,) = result.rounds[0].plays
    assert not play.reached
    assert StepState.NOT_TRIED in {step.state for step in play.steps}
    assert "takes longer" in result.reason
