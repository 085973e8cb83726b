"""What is not a number is found wherever it stands in what a device says; the infinite may have a meaning."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.geometry import Pose
from skiros_py.ports.device_faults import has_nan

NAN = math.nan


@dataclass(frozen=True)
class State:
    value: Any


@pytest.mark.parametrize(
    "value",
    [
        NAN,
        np.float64(NAN),
        (1.0, NAN),
        [1.0, math.inf, NAN],
        (1, "a", NAN),
        ((1.0, 2.0), (3.0, NAN)),
        np.array([[1.0], [NAN]]),
        (np.zeros(3), np.array([NAN, 1.0, 2.0])),
        {"a": NAN},
        ({0: NAN}, {1: 2.0}),
        (((0.0,), (NAN,)),),
        Pose((0.0, NAN, 0.0)),
        (Pose(), Pose((0.0, 0.0, NAN))),
    ],
)
def test_what_is_not_a_number_is_found(value: Any) -> None:
    assert has_nan(value)
    assert has_nan(State(value))


@pytest.mark.parametrize(
    "value",
    [
        None,
        True,
        3,
        "nan",
        math.inf,
        (math.inf, -math.inf),
        (),
        ((), ()),
        b"ab",
        np.array(["nan"]),
        {"nan": 1.0},
        Pose(),
    ],
)
def test_all_else_is_none(value: Any) -> None:
    assert not has_nan(value)
    assert not has_nan(State(value))


numbers = st.floats(allow_nan=True, allow_infinity=True)
values = st.recursive(
    numbers | st.integers() | st.booleans() | st.none() | st.text(max_size=3),
    lambda inner: st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(numbers.filter(math.isfinite), inner),
    max_leaves=12,
)


@given(values)
def test_it_is_found_exactly_where_it_is(value: Any) -> None:
    def holds(one: Any) -> bool:
        if isinstance(one, dict):
            return any(map(holds, one.values()))
        if isinstance(one, list | tuple):
            return any(map(holds, one))
        return isinstance(one, float) and math.isnan(one)

    assert has_nan(value) == holds(value)
