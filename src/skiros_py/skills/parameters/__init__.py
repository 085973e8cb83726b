"""Parameters of skills and primitives: typed, with a help text, and of one of the paper's kinds (§5.2)."""

from skiros_py.skills.parameters.fields import check_params, param, params_of
from skiros_py.skills.parameters.param import IT, Access, Cost, Kind, Output, Param
from skiros_py.skills.parameters.values import (
    SAMPLES,
    Arguments,
    as_json,
    as_shown,
    as_text,
    missing,
    read_arguments,
    read_constant,
    read_value,
    sample_of_range,
    schema,
)

__all__ = [
    "IT",
    "SAMPLES",
    "Access",
    "Arguments",
    "Cost",
    "Kind",
    "Output",
    "Param",
    "as_json",
    "as_shown",
    "as_text",
    "check_params",
    "missing",
    "param",
    "params_of",
    "read_arguments",
    "read_constant",
    "read_value",
    "sample_of_range",
    "schema",
]
