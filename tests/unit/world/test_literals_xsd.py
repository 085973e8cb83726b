from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.geometry import Pose
from skiros_py.world.element import Value
from skiros_py.world.literals import DATATYPES, LONGEST_TEXT, any_value, format_value, literal_type, parse_value

GOOD = [
    ("xsd:integer", "-12", -12),
    ("xsd:int", "7", 7),
    ("xsd:unsignedByte", "255", 255),
    ("xsd:unsignedLong", str(2**64 - 1), 2**64 - 1),
    ("xsd:nonNegativeInteger", "0", 0),
    ("xsd:float", "1.5e3", 1500.0),
    ("xsd:double", ".5", 0.5),
    ("owl:real", "2", 2.0),
    ("xsd:dateTime", "2025-01-31T14:05:00.25Z", "2025-01-31T14:05:00.25Z"),
    ("xsd:date", "2025-01-31+01:00", "2025-01-31+01:00"),
    ("xsd:time", "14:05:00", "14:05:00"),
    ("xsd:duration", "-P1DT2H30M0.5S", "-P1DT2H30M0.5S"),
    ("xsd:gYear", "2025", "2025"),
    ("xsd:anyURI", "https://example.org/a?b=c#d", "https://example.org/a?b=c#d"),
    ("xsd:token", "two words", "two words"),
    ("xsd:normalizedString", " two  words", " two  words"),
    ("xsd:language", "en-GB", "en-GB"),
    ("xsd:hexBinary", "00fF", "00fF"),
    ("rdf:langString", "Hammer", "Hammer"),
    ("rdf:PlainLiteral", "Hammer", "Hammer"),
    ("rdf:XMLLiteral", "<b>Hammer</b>", "<b>Hammer</b>"),
]

BAD = [
    ("xsd:byte", "128"),
    ("xsd:unsignedInt", "-1"),
    ("xsd:positiveInteger", "0"),
    ("xsd:integer", str(2**63)),
    ("xsd:integer", "1_000"),
    ("xsd:integer", "9" * 10_000),
    ("xsd:integer", "1.0"),
    ("xsd:float", "INF"),
    ("xsd:float", "NaN"),
    ("xsd:double", "1_0"),
    ("xsd:double", "1e999"),
    ("xsd:dateTime", "2025-01-31"),
    ("xsd:dateTime", "2025-13-31T00:00:00"),
    ("xsd:dateTimeStamp", "2025-01-31T14:05:00"),
    ("xsd:date", "31.1.2025"),
    ("xsd:time", "25:00:00"),
    ("xsd:duration", "P"),
    ("xsd:duration", "P1DT"),
    ("xsd:anyURI", "two words"),
    ("xsd:token", " a"),
    ("xsd:normalizedString", "a\nb"),
    ("xsd:hexBinary", "f"),
    ("rdf:JSON", "[" * 10_000),
]


@pytest.mark.parametrize(("type_", "text", "value"), GOOD)
def test_a_value_of_a_standard_type_is_read_and_written(type_: str, text: str, value: Value) -> None:
    read = parse_value(text, type_, type_)

    assert (read, type(read)) == (value, type(value))
    assert parse_value(format_value(read), literal_type(read, type_), type_) == value


@pytest.mark.parametrize(("type_", "text"), BAD)
def test_an_invalid_value_of_an_xsd_type_is_refused_with_a_short_message(type_: str, text: str) -> None:
    with pytest.raises(ValueError, match=r"^needs ") as caught:
        parse_value(text, type_, type_)

    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("range_", ["xsd:int", "xsd:unsignedShort", "xsd:integer"])
def test_turtle_integers_fit_every_integer_type(range_: str) -> None:
    assert parse_value("5", "xsd:integer", range_) == 5


@given(st.integers())
def test_a_whole_number_is_taken_exactly_where_its_type_allows_it(number: int) -> None:
    for type_, least, most in (("xsd:short", -(2**15), 2**15 - 1), ("xsd:unsignedByte", 0, 255)):
        try:
            assert DATATYPES[type_].check(number) == number
            taken = True
        except ValueError:
            taken = False
        assert taken == (least <= number <= most)


@given(
    st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.booleans()
    | st.text(max_size=50)
)
def test_any_literal_keeps_its_value_and_type(value: Value) -> None:
    range_ = "rdfs:Literal"
    checked = DATATYPES[range_].check(value)
    again = parse_value(format_value(checked), literal_type(checked, range_), range_)

    assert (again, type(again)) == (value, type(value))


@pytest.mark.parametrize("value", [None, [1], math.nan, object()])
def test_a_value_that_is_not_a_literal_is_refused_even_for_rdfs_literal(value: object) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  whoever asks words it
        DATATYPES["rdfs:Literal"].check(value)


def test_a_text_may_be_as_long_as_declared_and_no_longer() -> None:
    assert parse_value("x" * LONGEST_TEXT, "xsd:string", "xsd:string")
    for range_ in ("xsd:string", "rdfs:Literal"):
        with pytest.raises(ValueError, match=f"{LONGEST_TEXT} characters, and this has {LONGEST_TEXT + 1}"):
            parse_value("x" * (LONGEST_TEXT + 1), "xsd:string", range_)


def test_the_longest_vector_is_short_enough_to_be_read_again() -> None:
    longest = DATATYPES["sk:vectorLiteral"].check((-1.2345678901234567e-300,) * 2048)

    assert len(format_value(longest)) <= LONGEST_TEXT
    with pytest.raises(ValueError, match="2048 numbers, and this has 2049"):
        DATATYPES["sk:vectorLiteral"].check((0.0,) * 2049)


def test_a_wrong_literal_found_in_a_graph_is_shown_as_its_text() -> None:
    assert any_value("yesterday", "xsd:date") == "yesterday"
    assert any_value("5", "xsd:byte") == 5
    assert any_value("5", "mine:strange") == "5"
    assert any_value("0 0 0 0 0 0", "sk:poseLiteral") == Pose.of(0, 0, 0)


@pytest.mark.parametrize("range_", sorted(DATATYPES))
def test_every_datatype_describes_its_values(range_: str) -> None:
    assert DATATYPES[range_].says
    assert range_ in DATATYPES[range_].accepts or range_ == "rdfs:Literal"
