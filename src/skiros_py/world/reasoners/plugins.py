"""The reasoners of plug-ins (entry-point group ``skiros.reasoners``); the built-in ones come that way too."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from skiros_py.errors import UsageError
from skiros_py.plugins import Plugin, PluginFault, attempt, load_plugins
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.reasoner import Reasoner
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import COMPUTED

GROUP = "skiros.reasoners"
"""Entry points of this group name subclasses of :class:`~skiros_py.world.reasoners.reasoner.Reasoner`."""

_OWN = "skiros-py "


def load_reasoners(ontology: Ontology | None = None) -> tuple[Reasoners, tuple[PluginFault, ...]]:
    """Loads all reasoners, in the order of their entry points' names, the built-in ones first.

    Args:
        ontology: What must declare the relations that they compute; None if that does not matter.

    Returns:
        Those that can be used together; and the faults of the others, which are left out: what did not load, is no
        reasoner, has the name of an earlier one, computes what an earlier one computes or what the ontology does not
        declare as computed.
    """
    plugins, broken = load_plugins(GROUP)
    good: list[Reasoner] = []
    faults = list(broken)
    for plugin in sorted(plugins, key=lambda plugin: not plugin.distribution.startswith(_OWN)):
        made = attempt(plugin, partial(_usable, plugin, good, ontology))
        if isinstance(made, PluginFault):
            faults.append(made)
        else:
            good.append(made)
    return Reasoners(good), tuple(faults)


def _usable(plugin: Plugin, others: Sequence[Reasoner], ontology: Ontology | None) -> Reasoner | PluginFault:
    """Returns the reasoner of a plug-in, or why it cannot be used beside the others."""
    class_ = plugin.value
    if not isinstance(class_, type) or not issubclass(class_, Reasoner):
        return plugin.fault(f"it is a {type(class_).__name__}, nothing for reasoners: name a subclass of Reasoner")
    reasoner = class_()
    problem = _problem(reasoner, others) or _undeclared(reasoner, ontology)
    return reasoner if problem is None else plugin.fault(problem)


def _problem(reasoner: Reasoner, others: Sequence[Reasoner]) -> str | None:
    if not isinstance(getattr(reasoner, "name", None), str) or not reasoner.name:
        return "it has no name"
    if any(reasoner.name == other.name for other in others):
        return f"there is a reasoner '{reasoner.name}' already"
    try:
        Reasoners([*others, reasoner])
    except UsageError as error:
        return str(error)
    return None


def _undeclared(reasoner: Reasoner, ontology: Ontology | None) -> str | None:
    if ontology is None:
        return None
    computed = {name for name, relation in ontology.relations.items() if relation.family is Family.COMPUTED}
    unknown = sorted(reasoner.relations - computed)
    return f"no ontology declares {', '.join(unknown)} below {COMPUTED}" if unknown else None
