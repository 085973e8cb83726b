"""The ontology: which classes, relations and properties there are, and how they depend on each other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from skiros_py.errors import FileError, UnknownName, UsageError
from skiros_py.plugins.installation import installation
from skiros_py.plugins.loading import fault_of, files_of
from skiros_py.plugins.plugin import Entry, PluginFault
from skiros_py.world.element import Placement, Value
from skiros_py.world.names import Names, local_name
from skiros_py.world.ontology.declarations import Declarations, read_declarations
from skiros_py.world.ontology.documents import Document, common_names, rdf_files, read_document
from skiros_py.world.ontology.imports import with_imports
from skiros_py.world.ontology.ownership import Owners
from skiros_py.world.terms import Cardinality, Class, End, Family, Filler, Property, Relation, closure, inverse


class Ontology:
    """Classes, relations and properties by CURIE; never changed once loaded.

    "Ancestors", "subclasses" and "sub-relations" always include the term itself, first.

    Attributes:
        classes: Every class.
        relations: Every relation between elements.
        properties: Every property of elements; ``rdfs:comment`` is always among them.
        individuals: CURIEs of the individuals that its files describe, sorted; a scene's are not among them.
        languages: Language tags of the labels and comments of its terms, sorted after English, which any may lack.
        names: The prefix table.
        sources: The files it was read from. Scene individuals in them belong to scenes that import the file.
    """

    def __init__(self, declarations: Declarations, names: Names, sources: Sequence[Document]) -> None:
        self.classes: Mapping[str, Class] = MappingProxyType(dict(declarations.classes))
        self.relations: Mapping[str, Relation] = MappingProxyType(dict(declarations.relations))
        self.properties: Mapping[str, Property] = MappingProxyType(dict(declarations.properties))
        terms = (*self.classes.values(), *self.relations.values(), *self.properties.values())
        self.languages = ("en", *sorted({tag for term in terms for tag in (*term.labels, *term.comments)}))
        self.names = names
        self.sources = tuple(sources)
        self.individuals = declarations.individuals
        self._declarations = declarations
        above = {name: (*class_.parents, *class_.equivalents) for name, class_ in self.classes.items()}
        self._ancestors = {name: closure(above, name) for name in above}
        self._above = {name: frozenset(line) for name, line in self._ancestors.items()}
        self._subclasses = inverse(self._ancestors)
        given = declarations.class_values  # a class's own values count before those of the nearest above it
        self._class_values = {
            name: {property_: value for above in reversed(line) for property_, value in given[above].items()}
            for name, line in self._ancestors.items()
        }
        relations = {name: relation.parents for name, relation in self.relations.items()}
        self._sub_relations = inverse({name: closure(relations, name) for name in relations})

    @classmethod
    def load(cls, paths: Sequence[Path]) -> Ontology:
        """Reads ontology files (of a folder: all below it) with those that they import, and merges them.

        Imports are looked up among these files and in local folders; nothing is fetched from anywhere.

        Raises:
            FileError: A file is missing or in none of the languages, uses a term that no file declares, or two files
                collide.
        """
        return cls.of(with_imports(read_document(path) for path in rdf_files(paths)))

    @classmethod
    def of(cls, files: Sequence[Document]) -> Ontology:
        """Merges files that were read before.

        Raises:
            FileError: One uses a term that no file declares, or two collide.
        """
        by_iri: dict[str, Document] = {}
        for file in files:
            if by_iri.setdefault(file.iri, file) is not file:
                raise FileError(file.path, f"declares ontology <{file.iri}>, as {by_iri[file.iri].path} does")
        names = common_names(files)
        return cls(read_declarations(files, names), names, files)

    # ------------------------------------------------------------ classes

    def is_a(self, class_: str, ancestor: str) -> bool:
        """Returns True when the class is the ancestor or a subclass of it.

        Raises:
            UnknownName: Either is not a class.
        """
        self._known_class(class_)
        self._known_class(ancestor)
        return ancestor in self._above[class_]

    def ancestors(self, class_: str) -> tuple[str, ...]:
        """Returns the class and everything above it, the line of primary parents first.

        Raises:
            UnknownName: It is not a class.
        """
        self._known_class(class_)
        return self._ancestors[class_]

    def subclasses(self, class_: str) -> tuple[str, ...]:
        """Returns the class and everything below it, sorted after the first.

        Raises:
            UnknownName: It is not a class.
        """
        self._known_class(class_)
        return self._subclasses[class_]

    def overlap(self, one: str, other: str) -> bool:
        """Returns whether something may be of both classes; anything may be of an unknown class."""
        if one not in self.classes or other not in self.classes:
            return True
        return not set(self._subclasses[one]).isdisjoint(self._subclasses[other])

    def class_value(self, class_: str, property_: str) -> Value | None:
        """Returns what the class, else its nearest ancestor, gives as the value of a property, or None.

        Raises:
            UnknownName: It is not a class.
        """
        self._known_class(class_)
        return self._class_values[class_].get(property_)

    def cardinalities(self, class_: str) -> tuple[Cardinality, ...]:
        """Returns how many things individuals of a class have, as it and the classes above it say.

        Raises:
            UnknownName: It is not a class.
        """
        said = (number for above in self.ancestors(class_) for number in self.classes[above].cardinalities)
        return tuple(dict.fromkeys(said))

    def fillers(self, class_: str) -> tuple[Filler, ...]:
        """Returns what individuals of a class are related to, as it and the classes above it say.

        Raises:
            UnknownName: It is not a class.
        """
        said = (filler for above in self.ancestors(class_) for filler in self.classes[above].fillers)
        return tuple(dict.fromkeys(said))

    def missed_end(self, class_: str, end: End) -> tuple[str, ...]:
        """Returns the first group of classes of which a class is none, though an end asks for one; nothing if it fits.

        Raises:
            UnknownName: It is not a class.
        """
        self._known_class(class_)
        return next((group for group in end if self._above[class_].isdisjoint(group)), ())

    # ------------------------------------------------------------ relations

    def relation(self, relation: str) -> Relation:
        """Returns one relation.

        Raises:
            UnknownName: There is none of that CURIE.
        """
        if relation not in self.relations:
            raise UnknownName("relation", relation, self.relations)
        return self.relations[relation]

    def family(self, relation: str) -> Family:
        """Returns what the relation is for.

        Raises:
            UnknownName: There is none of that CURIE.
        """
        return self.relation(relation).family

    def is_placement(self, relation: str) -> bool:
        """Returns True when the relation says where something is.

        Raises:
            UnknownName: There is none of that CURIE.
        """
        return self.family(relation) is Family.PLACEMENT

    def sub_relations(self, relation: str) -> tuple[str, ...]:
        """Returns the relation and everything below it, sorted after the first.

        Raises:
            UnknownName: There is none of that CURIE.
        """
        self.relation(relation)
        return self._sub_relations[relation]

    def placement_statement(self, element: str, placement: Placement) -> tuple[str, str, str]:
        """Returns the statement (subject, relation, object) that an element has a placement."""
        relation, place = placement.relation, placement.place
        place_is_object = self.relation(relation).place_end == "object"
        return (element, relation, place) if place_is_object else (place, relation, element)

    def placed(self, subject: str, relation: str, object_: str) -> tuple[str, Placement]:
        """Returns which element a placement statement places, and where."""
        if self.relation(relation).place_end == "object":
            return subject, Placement(relation, object_)
        return object_, Placement(relation, subject)

    # ------------------------------------------------------------ names as people write them

    def resolve_class(self, name: str) -> str:
        """Returns the CURIE of a class given by CURIE or by its bare name ("Starter").

        Raises:
            UnknownName: There is none; with the nearest.
            UsageError: Several ontologies have one of that bare name.
        """
        return _resolve("class", name, self.classes)

    def resolve_relation(self, name: str) -> str:
        """Returns the CURIE of a relation given by CURIE or by its bare name ("heldBy").

        Raises:
            UnknownName: There is none; with the nearest.
            UsageError: Several ontologies have one of that bare name.
        """
        return _resolve("relation", name, self.relations)

    def __reduce__(self) -> tuple[type[Ontology], tuple[Declarations, Names, tuple[Document, ...]]]:
        return Ontology, (self._declarations, self.names, self.sources)

    def _known_class(self, class_: str) -> None:
        if class_ not in self.classes:
            raise UnknownName("class", class_, self.classes)


def _resolve(kind: str, name: str, known: Iterable[str]) -> str:
    curies = set(known)
    if name in curies:
        return name
    if ":" in name:
        raise UnknownName(kind, name, curies)
    found = sorted(curie for curie in curies if local_name(curie) == name)
    if len(found) > 1:
        raise UsageError(f"'{name}' may be any of {', '.join(found)}: write one of these")
    if not found:
        raise UnknownName(kind, name, {local_name(curie) for curie in curies})
    return found[0]


# ---------------------------------------------------------------- the ontology as installed


_GROUP = "skiros.ontologies"


def load_installed(paths: Sequence[Path]) -> tuple[Ontology, tuple[PluginFault, ...]]:
    """Loads the files of some paths and those that plug-ins of the group ``skiros.ontologies`` bring.

    An entry point names a package, a module in a package, or a ``pathlib.Path``: all ontology files below its folder
    (below the folder ``ontologies`` in it, where there is one) are taken. A plug-in whose files cannot be read, do
    not go with the others, or state something about terms of others, is left out and reported; the rest is as if it
    were not installed.

    Args:
        paths: Files or folders that must be right.

    Returns:
        The ontology, and the faults of plug-ins.

    Raises:
        FileError: A file of the paths is wrong.
    """
    base = rdf_files(paths)
    files, broken = plugin_files(base)
    faults = list(broken)
    documents = [read_document(path) for path in base]
    own: dict[Entry, list[Document]] = {}
    for entry, found in files.items():
        try:
            own[entry] = [read_document(path) for path in found]
        except FileError as error:
            faults.append(fault_of(entry, str(error)))
    documents = with_imports(documents, (file for group in own.values() for file in group))
    for entry, group in list(own.items()):
        others = (file for one in (documents, *own.values()) for file in one)
        try:
            own[entry] = with_imports(group, others)
        except FileError as error:
            faults.append(fault_of(entry, str(error)))
            del own[entry]
    owners = Owners([*documents, *(file for group in own.values() for file in group)])
    for entry, group in list(own.items()):
        if (foreign := owners.fault(group)) is not None:
            faults.append(fault_of(entry, str(foreign)))
            del own[entry]
    while True:
        try:
            ontology = Ontology.of([*documents, *(file for group in own.values() for file in group)])
            return ontology, tuple(faults)
        except FileError as error:
            culprit = next((entry for entry, group in own.items() if any(f.path == error.path for f in group)), None)
            if culprit is None:
                raise
            del own[culprit]
            faults.append(fault_of(culprit, str(error)))


def plugin_files(base: Sequence[Path] = ()) -> tuple[dict[Entry, list[Path]], list[PluginFault]]:
    """Finds the ontology files of every plug-in.

    Args:
        base: Files that belong to the installation, and to no plug-in.

    Returns:
        The files in the order of the plug-ins' names; and the faults of the others.
    """
    files: dict[Entry, list[Path]] = {}
    broken: list[PluginFault] = []
    taken = {path.resolve() for path in base}
    for entry in installation().of(_GROUP):
        paths = files_of(entry)
        if isinstance(paths, PluginFault):
            broken.append(paths)
        elif own := rdf_files(paths):
            files[entry] = [path for path in own if path.resolve() not in taken]
            taken.update(path.resolve() for path in own)
        else:
            broken.append(fault_of(entry, f"there is no ontology file below {paths[0]}"))
    return files, broken
