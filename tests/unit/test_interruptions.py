from __future__ import annotations

import subprocess
import sys

import pytest

from skiros_py.interruptions import CycleStep, Overrun

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


class ModuleTask:
    """A module's task, as the watchdog sees it."""

    name = "pick"
    done = False
    interruptible = True

    def fail(self, fault: BaseException) -> None:
        """Does nothing."""


def test_a_program_that_is_profiled_goes_on_after_an_exception_was_taken_back() -> None:
    done = subprocess.run([sys.executable, "-c", PROFILED], capture_output=True, text=True, timeout=60, check=False)

    assert done.stdout == "goes on\n", done.stderr


@pytest.mark.parametrize(("device", "hint"), [(None, "yield more often"), ("gripper", "return at once")])
def test_the_advice_to_yield_is_given_to_modules_and_not_to_devices(device: str | None, hint: str) -> None:
    overrun = Overrun(CycleStep("pick"), tick=1, seconds=6.0, limit=5.0, module="pick", stack="", device=device)
    task = Overrun(ModuleTask(), tick=1, seconds=6.0, limit=5.0, module="pick", stack="", device=device)

    assert f"allowed: {hint}, or" in str(task)
    assert "allowed: return at once, or" in str(overrun)
