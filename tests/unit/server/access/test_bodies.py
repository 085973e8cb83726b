"""Bodies of requests, as they are checked at the door."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.server.access.bodies import check_json
from skiros_py.server.problems import Problem

_TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\0"))
_SOUND = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | _TEXT,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(_TEXT, inner, max_size=5),
    max_leaves=20,
)


@given(_SOUND, st.booleans())
def test_valid_json_passes_the_check(value: Any, ascii_only: bool) -> None:
    check_json(json.dumps(value, ensure_ascii=ascii_only).encode())


@given(st.binary(max_size=200))
def test_invalid_json_is_refused_here_or_by_the_parser(body: bytes) -> None:
    with suppress(Problem):
        check_json(body)


@pytest.mark.parametrize(
    "body",
    [
        b"[" * 1_000_000,
        b"[" * 65 + b"]" * 65,
        b'{"a":' * 65 + b"1" + b"}" * 65,
        b'{"a":' * 200_000,
        b'["x",' * 200_000,
        b'{"a": NaN}',
        b"[Infinity, -Infinity]",
        b"[1e999]",
        b"[-1E+400]",
        b"[" + b"9" * 5000 + b"]",
        b"[9223372036854775808]",
        rb'{"a": "\u0000"}',
        rb'{"\ud800": 1}',
        rb'["\uDFFF\ud800"]',
        b'["\xed\xa0\x80"]',
        '{"a": 1}'.encode("utf-16"),
        '{"a": 1}'.encode("utf-32"),
    ],
    ids=lambda body: repr(body[:20]),
)
def test_json_that_no_part_of_the_platform_accepts_is_refused(body: bytes) -> None:
    with pytest.raises(Problem) as caught:
        check_json(body)

    assert caught.value.status == 400


@pytest.mark.parametrize(
    "body",
    [
        b'{"a": "NaN, Infinity and 1e999 as words"}',
        rb'["\ud83d\ude00", "\\u0000", "\\ud800"]',
        ('["' + "[{" * 500 + '"]').encode(),
        (r'["' + r"\\" * 400_000 + '"]' + "[" * 70).encode()[:100],
        b"[" + b"[]," * 500 + b"1]",
        b"[" * 64 + b"]" * 64,
        b'[{"a":' * 32 + b"1" + b"}]" * 32,
        str(2**63 - 1).encode(),
        str(-(2**63)).encode(),
        json.dumps(math.nextafter(math.inf, 0)).encode(),
    ],
    ids=lambda body: repr(body[:20]),
)
def test_text_that_only_resembles_refused_json_passes(body: bytes) -> None:
    check_json(body)


def test_a_very_long_unclosed_string_is_scanned_only_once() -> None:
    """Seen as a pattern that starts anew at each quote, this would take hours."""
    with pytest.raises(Problem, match="not closed"):
        check_json(b'["' + b"[" * 100 + b'\\"' * 400_000)
