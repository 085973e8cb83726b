from __future__ import annotations

import subprocess
import sys

PROFILED = """
import sys
from skiros_py.interruptions import Interruption, cancel_pending

cancel_pending(Interruption)
sys.setprofile(lambda *_: None)
for _ in range(10_000):
    str.format("{}", 1)
    (lambda: None)()
print("goes on")
"""


def test_a_program_that_is_profiled_goes_on_after_an_exception_was_taken_back() -> None:
    done = subprocess.run([sys.executable, "-c", PROFILED], capture_output=True, text=True, timeout=60, check=False)

    assert done.stdout == "goes on\n", done.stderr
