"""Programs run within limits, and neither they nor their children survive."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from skiros_py.programs import Child, Ended, Limits, NotStarted, ProgramError, run_program


def _never() -> bool:
    return False


def _run(folder: Path, script: str, limits: Limits, stopped: Callable[[], bool] = _never) -> Ended:
    command = [sys.executable, "-c", script]
    return run_program("it", partial(Child, "it", command, folder, limits), limits, stopped)


def test_a_program_that_cannot_be_started_is_told_from_one_that_failed(tmp_path: Path) -> None:
    limits = Limits()

    with pytest.raises(NotStarted, match=r"it cannot be started: './missing': No such file"):
        run_program("it", partial(Child, "it", ["./missing"], tmp_path, limits), limits, _never)
    assert _run(tmp_path, "raise SystemExit(3)", limits).code == 3


def test_a_program_that_takes_too_long_is_killed_with_its_children(tmp_path: Path) -> None:
    script = (
        "import subprocess, time; child = subprocess.Popen(['sleep', '60']); open('child', 'w').write(str(child.pid));"
        " time.sleep(60)"
    )

    with pytest.raises(ProgramError, match=r"it found no answer in 1 s"):
        _run(tmp_path, script, Limits(time=1.0))

    child = int((tmp_path / "child").read_text(encoding="ascii"))
    deadline = time.monotonic() + 5.0
    while os.path.exists(f"/proc/{child}") and time.monotonic() < deadline:  # noqa: PTH110
        time.sleep(0.01)
    assert not Path(f"/proc/{child}").exists()


def test_of_a_long_output_start_and_end_are_kept(tmp_path: Path) -> None:
    script = "print('a' * 50 + 'b' * 50 + 'c' * 50, end='')"

    assert _run(tmp_path, script, Limits(kept=50)).output == f"{'a' * 50}\n… 50 bytes …\n{'c' * 50}"
    assert _run(tmp_path, script, Limits(kept=75)).output == "a" * 50 + "b" * 50 + "c" * 50
