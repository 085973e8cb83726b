"""What follows from the classes of things alone: being of one, and being related as one to another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from skiros_py.skills.conditions.pattern import Binding
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.names import local_name
from skiros_py.world.terms import Filler
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class IsA:
    """An element is of a class, or of one below it."""

    subject: str
    class_: str

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks it up."""
        subject = binding[self.subject]
        type_ = view.element(subject).type
        holds = view.ontology.is_a(type_, self.class_)
        wanted = "" if holds else f", not a {local_name(self.class_)}"
        return Verdict(holds, f"{subject} is a {local_name(type_)}{wanted}")

    def rename(self, names: Mapping[str, str]) -> IsA:
        """Returns the same pattern with other variable names."""
        return IsA(names.get(self.subject, self.subject), self.class_)


@dataclass(frozen=True, slots=True)
class ClassRelated:
    """The ontology says of the first one's class that its things are related to things like the second one.

    It says so by a restriction on the class or one above it: ``someValuesFrom`` or ``allValuesFrom`` a class of which
    the second one is, or ``hasValue`` the second one itself. Whether the two are related in the scene is not asked.
    """

    relation: str
    subject: str
    object: str

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Looks for what the classes say."""
        subject, object_ = binding[self.subject], binding[self.object]
        type_ = view.element(subject).type
        below = view.ontology.sub_relations(self.relation)
        said = [filler for filler in view.ontology.fillers(type_) if filler.relation in below]
        verb = local_name(self.relation)
        for filler in said:
            if _meets(view, object_, filler):
                return Verdict(True, f"a {local_name(type_)} {verb} a {local_name(filler.of)}, as {object_} is one")
        known = ", ".join(local_name(filler.of) for filler in said) or "nothing that is said"
        kind = local_name(view.element(object_).type)
        return Verdict(False, f"a {local_name(type_)} {verb} {known}, and {object_} is a {kind}")

    def rename(self, names: Mapping[str, str]) -> ClassRelated:
        """Returns the same pattern with other variable names."""
        return ClassRelated(self.relation, names.get(self.subject, self.subject), names.get(self.object, self.object))


def _meets(view: WorldView, element: str, filler: Filler) -> bool:
    if not filler.is_class:
        return element == filler.of
    if filler.of not in view.ontology.classes:  # owl:Thing: anything will do; what OWL alone knows, nothing
        return filler.of == "owl:Thing"
    return view.ontology.is_a(view.element(element).type, filler.of)
