"""All that can be found without reasoning: every finding, not only the first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain

from skiros_py.world.ontology.check.cycles import cycles
from skiros_py.world.ontology.check.depth import depths
from skiros_py.world.ontology.check.ends import bad_ends
from skiros_py.world.ontology.check.families import house_rules
from skiros_py.world.ontology.check.findings import Finding
from skiros_py.world.ontology.check.individuals import misfits
from skiros_py.world.ontology.check.material import Material
from skiros_py.world.ontology.check.undeclared import undeclared_terms

__all__ = ["structural_findings"]

_CHECKS: tuple[Callable[[Material], Iterator[Finding]], ...] = (
    undeclared_terms,
    bad_ends,
    cycles,
    depths,
    house_rules,
    misfits,
)


def structural_findings(material: Material) -> list[Finding]:
    """Returns what is wrong with the declarations and statements of the files as they stand."""
    return list(chain.from_iterable(check(material) for check in _CHECKS))
