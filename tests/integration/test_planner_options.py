from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from skiros_py.cli.main import cli
from skiros_py.errors import UsageError
from skiros_py.station.session import Options, Session

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "planner.md"
COMMANDS = [line[2:] for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("$ ")]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: re.split(r"[ ']+", command)[-3])
def test_the_documented_commands_work_with_every_planner(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    status = cli.main(args=shlex.split(command)[1:], standalone_mode=False)

    assert status == 0
    assert re.search(r"place\(|goal reached", capsys.readouterr().out)


def test_an_unknown_planner_is_answered_with_the_available_ones() -> None:
    with pytest.raises(UsageError, match=r"unknown planner 'fast-backward'. Did you mean 'fast-downward'\?"):
        Session("kitting", Options(fake=True, planner="fast-backward"))


def test_a_planner_name_and_a_command_line_together_are_refused() -> None:
    with pytest.raises(UsageError, match="give its name or its command line, not both"):
        Options(planner="kairos", planner_command="it {domain} {problem}")


def test_an_invalid_planner_command_line_is_refused_at_once() -> None:
    with pytest.raises(UsageError, match=r"it must name {problem}"):
        Session("kitting", Options(fake=True, planner_command="popf {domain}"))
