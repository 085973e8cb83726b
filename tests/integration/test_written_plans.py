"""What ``skiros plan --write`` leaves is standard: another planning library reads it and finds the plan valid."""

from __future__ import annotations

import pytest
import unified_planning.shortcuts as up
from unified_planning.engines import SequentialPlanValidator, ValidationResultStatus
from unified_planning.io import PDDLReader

from skiros_py.cli.main import cli


@pytest.mark.parametrize("scene", ["kitting", "kitting_carried"])
def test_an_external_validator_accepts_the_written_plan(scene, tmp_path):
    status = cli.main(args=["plan", scene, "--write", str(tmp_path)], standalone_mode=False)

    assert status == 0
    up.get_environment().credits_stream = None
    reader = PDDLReader()
    problem = reader.parse_problem(str(tmp_path / "domain.pddl"), str(tmp_path / "problem.pddl"))
    plan = reader.parse_plan(problem, str(tmp_path / "plan"))
    result = SequentialPlanValidator().validate(problem, plan)
    assert result.status is ValidationResultStatus.VALID
    assert any(action.action.name == "place" or action.action.name.startswith("place") for action in plan.actions)
