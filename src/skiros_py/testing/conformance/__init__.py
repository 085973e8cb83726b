"""Tests that every adapter behind a port must pass: inherit a contract, say how to make the adapter, run pytest.

>>> class TestMyDriver(CellDriverContract):
...     def make(self, spec):
...         return MyDriver(spec)

``docs/how-to/driver.md`` shows how, port by port. Needs pytest.
"""

import pytest

# Before they are imported, so that a failing claim shows the values that did not fit.
for _name in ("cell_driver", "device_kind", "engine", "motion", "pending", "planner"):
    pytest.register_assert_rewrite(f"{__name__}.{_name}")

from skiros_py.testing.conformance.cell_driver import CellDriverContract  # noqa: E402
from skiros_py.testing.conformance.cells import small_cell  # noqa: E402
from skiros_py.testing.conformance.device_kind import DeviceKindContract  # noqa: E402
from skiros_py.testing.conformance.engine import EngineContract  # noqa: E402
from skiros_py.testing.conformance.motion import (  # noqa: E402
    ArmPlannerContract,
    BasePlannerContract,
    KinematicsContract,
)
from skiros_py.testing.conformance.pending import PendingContract  # noqa: E402
from skiros_py.testing.conformance.planner import PlannerContract  # noqa: E402

__all__ = [
    "ArmPlannerContract",
    "BasePlannerContract",
    "CellDriverContract",
    "DeviceKindContract",
    "EngineContract",
    "KinematicsContract",
    "PendingContract",
    "PlannerContract",
    "small_cell",
]
