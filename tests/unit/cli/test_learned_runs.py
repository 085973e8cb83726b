"""``skiros world learned``: costs learned from runs are listed and forgotten."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner

from skiros_py.cli.main import cli
from skiros_py.planning.experience import observe
from skiros_py.station.worlds import open_data
from skiros_py.testing.tiny import DRIVE


def _asked(*arguments: str) -> str:
    found = CliRunner().invoke(cli, ["world", *arguments], catch_exceptions=False)
    assert found.exit_code == 0, found.output
    return found.output


def test_what_was_learned_is_listed_forgotten_and_restored(tmp_path: Path) -> None:
    with open_data(tmp_path / "data", "kitting") as data:
        for place in ("pallet_a", "kit_1"):
            observe(data.world, DRIVE, "base_1", {"Base": "base_1", "Location": place}, 8.0, is_success=False)
    where = ("--data", str(tmp_path / "data"))
    listed = _asked("learned", "list", *where)
    _asked("learned", "forget-runs", "--place", "pallet_a", *where)
    left = _asked("learned", "list", *where)
    _asked("undo", *where)

    assert "drive by robot_1 at pallet_a', about sk:Base: 0.0 of 1.0 succeed, 12.6 s until it succeeds" in listed
    assert "pallet_a" not in left
    assert "kit_1" in left
    assert _asked("learned", "list", *where) == listed
