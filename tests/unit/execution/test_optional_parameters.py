"""What a skill needs of an optional parameter counts where it is given."""

from __future__ import annotations

from dataclasses import replace

import pytest

from skiros_py.behaviours import AssertEffects
from skiros_py.skills.outcome import Failure, Success
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, IN_CONTAINER

WITH_BALL = replace(
    DRIVE,
    params=(*DRIVE.params, Param("Ball", "tiny:Ball", "A ball to look for on the way.", Kind.OPTIONAL)),
    pre=(DRIVE.pre[0], IN_CONTAINER("Ball", "Location")),
    hold=(IN_CONTAINER("Ball", "Location"),),
)


@pytest.mark.parametrize(
    ("ball", "kind"), [({}, Success), ({"Ball": "ball_1"}, Success), ({"Ball": "red_ball_1"}, Failure)]
)
def test_conditions_about_an_optional_parameter_are_checked_if_it_is_given(ball: dict[str, str], kind: type) -> None:
    with Bench(tiny_world(), (Skill(WITH_BALL, AssertEffects(0.01), driver="fake"),)) as bench:
        outcome = bench.run("drive", Location="box_a", **ball)

    assert isinstance(outcome, kind), outcome
