"""The module command takes configuration, which is read before anything starts, and a pace, as the run command does."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner, Result

from skiros_py.cli.main import cli
from skiros_py.errors import UsageError


def module_run(*arguments: str) -> Result:
    command = ["module", "run", "drive", "--param", "Location=pallet_a", "--fake", *arguments]
    return CliRunner().invoke(cli, command, standalone_mode=False)


@pytest.mark.parametrize(
    ("config", "told"),
    [
        ("mve_arm.speed=1", "Did you mean 'move_arm'?"),
        ("move_arm.sped=1", "unknown configuration parameter 'sped' of move_arm"),
        ("move_arm=1", "--config takes MODULE.KEY=VALUE"),
    ],
)
def test_a_slip_in_the_configuration_is_refused_before_anything_starts(config: str, told: str) -> None:
    result = module_run("--config", config)

    assert isinstance(result.exception, UsageError)
    assert told in str(result.exception)
    assert not result.output


def test_a_module_can_be_run_at_a_pace() -> None:
    result = module_run("--pace", "1000", "--json")

    assert json.loads(result.output)["runs"][0]["success"]
