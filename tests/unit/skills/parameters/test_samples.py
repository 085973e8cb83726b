"""Examples of values: for trials and generated scenes."""

from __future__ import annotations

import pytest

from skiros_py.skills.parameters.values import SAMPLES, VALUE_TYPES, sample_of_range
from skiros_py.world.literals import DATATYPES


@pytest.mark.parametrize("type_", VALUE_TYPES)
def test_every_type_of_a_parameter_has_a_valid_example(type_: str) -> None:
    assert VALUE_TYPES[type_].check(SAMPLES[type_]) is not None


@pytest.mark.parametrize("range_", DATATYPES)
def test_an_example_fits_the_range_of_its_property(range_: str) -> None:
    sample = sample_of_range(range_)

    assert sample is None or DATATYPES[range_].fits(sample)


@pytest.mark.parametrize(
    ("range_", "sample"),
    [("xsd:boolean", True), ("xsd:integer", 1), ("sk:className", "sk:Element"), ("rdf:JSON", "[]")],
)
def test_the_example_of_a_common_range_is_the_obvious_one(range_: str, sample: object) -> None:
    assert sample_of_range(range_) == sample
