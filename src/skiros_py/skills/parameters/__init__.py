"""Parameters of skills and primitives: typed, with a help text, and of one of the paper's kinds (§5.2)."""

from skiros_py.skills.parameters.fields import check_params, param, params_of
from skiros_py.skills.parameters.param import IT, Access, Cost, Kind, Output, Param
from skiros_py.skills.parameters.values import Arguments, missing, read_arguments

__all__ = [
    "IT",
    "Access",
    "Arguments",
    "Cost",
    "Kind",
    "Output",
    "Param",
    "check_params",
    "missing",
    "param",
    "params_of",
    "read_arguments",
]
