from __future__ import annotations

import subprocess
import sys
from pathlib import Path

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "planning_threads.py"


def test_goals_from_eight_threads_each_get_a_correct_plan_and_leave_nothing_behind() -> None:
    command = [sys.executable, str(BENCHMARK), "--goals", "48"]

    done = subprocess.run(command, capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stdout + done.stderr
    assert "all bars hold" in done.stdout
