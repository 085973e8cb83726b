"""The nodes of skills' bodies, one file each; further ones come by the entry-point group ``skiros.behaviours``."""

from skiros_py.behaviours.assert_effects import AssertEffects
from skiros_py.behaviours.check import Check
from skiros_py.behaviours.do import Do
from skiros_py.behaviours.document_kind import DocumentKind, Interface, PaletteEntry, Review
from skiros_py.behaviours.every import Every
from skiros_py.behaviours.fallback import Fallback
from skiros_py.behaviours.for_each import ForEach
from skiros_py.behaviours.guard import Guard
from skiros_py.behaviours.parallel import Parallel, Policy
from skiros_py.behaviours.repeat import Repeat
from skiros_py.behaviours.retry import Retry
from skiros_py.behaviours.sequence import Sequence
from skiros_py.behaviours.start import Start
from skiros_py.behaviours.timeout import Timeout
from skiros_py.behaviours.wait import Wait
from skiros_py.behaviours.wait_until import WaitUntil
from skiros_py.skills.behaviour import Behaviour, Call, Edge, Out, P, Scope, Uses, lines, walk

__all__ = [
    "AssertEffects",
    "Behaviour",
    "Call",
    "Check",
    "Do",
    "DocumentKind",
    "Edge",
    "Every",
    "Fallback",
    "ForEach",
    "Guard",
    "Interface",
    "Out",
    "P",
    "PaletteEntry",
    "Parallel",
    "Policy",
    "Repeat",
    "Retry",
    "Review",
    "Scope",
    "Sequence",
    "Start",
    "Timeout",
    "Uses",
    "Wait",
    "WaitUntil",
    "lines",
    "walk",
]
