"""Programs that some tests need, and pip cannot install."""

from __future__ import annotations

import os

import pytest

REQUIRED = os.environ.get("SKIROS_TESTS") == "required"
"""Whether a missing program is a failure: .ci/run installs all of them."""


def needs(found: object, reason: str) -> pytest.MarkDecorator:
    """Returns a mark that skips tests where a program is not found; where all are required, they run and fail."""
    return pytest.mark.skipif(not found and not REQUIRED, reason=reason)
