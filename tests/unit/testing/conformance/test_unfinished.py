"""A suite that its author has not finished names what is missing."""

from __future__ import annotations

from typing import Any

import pytest

from skiros_py.testing import conformance


@pytest.mark.parametrize(
    "suite", [value for name, value in vars(conformance).items() if name.endswith("Contract")], ids=lambda s: s.__name__
)
def test_a_suite_without_its_subject_cannot_be_used_and_says_which_method_it_lacks(suite: Any) -> None:
    with pytest.raises(TypeError, match=r"abstract method '?(make|device)"):
        suite()
