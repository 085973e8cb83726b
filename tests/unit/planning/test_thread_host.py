from __future__ import annotations

import subprocess
import sys

PROFILED = """
import sys
from skiros_py.testing import Bench, tiny_world

with Bench(tiny_world()) as bench:
    bench.plan("In(ball_1, slot_1)")
    sys.setprofile(lambda *_: None)
    for _ in range(10_000):
        str.format("{}", 1)
        (lambda: None)()
    print("goes on")
"""


def test_a_program_that_is_profiled_goes_on_after_a_plan() -> None:
    done = subprocess.run([sys.executable, "-c", PROFILED], capture_output=True, text=True, timeout=60, check=False)

    assert done.stdout == "goes on\n", done.stderr
