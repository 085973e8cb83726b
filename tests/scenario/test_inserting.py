"""A part that lands on the wall of a compartment with 3 mm of play, on an arm that feels; the truth judges."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest
from manipulation import CAMPAIGNS
from manipulation_stage import Stage

from skiros_py.config import ONTOLOGIES
from skiros_py.devices.force_torque import ForceTorqueSpec
from skiros_py.geometry import Pose

pytestmark = pytest.mark.physics


@pytest.mark.parametrize("unplugged", [False, True], ids=["by feel", "sensor unplugged"])
def test_a_kit_that_is_pushed_while_the_part_comes_down_is_filled_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, unplugged: bool
) -> None:
    monkeypatch.setenv(ONTOLOGIES, os.environ.get(ONTOLOGIES, ""))  # set back, whatever the stage makes of it
    stage = Stage(CAMPAIGNS["compartments"].scene(21), tmp_path)
    board, said = stage.session.cycle.board, list[str]()
    (sensor,) = stage.session.spec.of(ForceTorqueSpec)

    def push() -> None:
        inside = [body for body, place in stage.truth.placements().items() if place.startswith("kit_1")]
        stage.shift([*inside, "kit_1"], "kit_1", Pose((0.005 * math.cos(0.7), 0.005 * math.sin(0.7), 0.0)))
        if unplugged:
            stage.later(0.3, lambda: board.guard.switch_off(sensor, "it does not answer"))

    stage.after("put_down", "coming down", push)
    stage.session.monitor.subscribe(lambda event: said.append(event.text) if event.module == "put_down" else None)
    report = stage.pursue(stage.scene.goals[:1])
    stage.session.close()

    assert [(one.believed, one.true) for one in report.conditions] == [(True, True)]
    assert (said.count("coming down") == 1) is not unplugged, "it found the way in without lifting"
    assert any("feeling the way" in text for text in said) is not unplugged
    assert any("the joints of arm_1 feel contact" in text for text in said) is unplugged, said
