"""The world: elements, the ontology, queries, what was taught, locks, and scenes."""

# mypy: disable-error-code="empty-body"
# An operation is declared by its signature alone.

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api import ontology, queries, scenes, transactions, world
from skiros_py.api.view import WorldView
from skiros_py.client.operation import C, Topic, call, operation, tag
from skiros_py.client.request import Call


class World(Topic[C]):
    """The world as a whole."""

    @operation("GET /world")
    def get(self) -> world.WorldInfo:
        """Returns the world's version and element counts."""

    @operation("GET /view", elements="element")
    def view(self, elements: Sequence[str] | None = None) -> WorldView:
        """Returns the believed poses and the shapes of all elements.

        Args:
            elements: Only these, with what moves or disappears with them, at most 100; by default everything.
        """

    @operation("GET /tree")
    def tree(
        self, root: str | None = None, *, depth: int | None = None, limit: int | None = None, cursor: str | None = None
    ) -> world.TreeNode:
        """Returns the tree of placements and parts.

        Args:
            root: The root element; by default, the root of the world.
            depth: How many levels below it.
            limit: Maximum number of children per node.
            cursor: ``next`` of the root from an earlier call.
        """

    @operation("GET /world/changes")
    def changes(
        self,
        since: int | None = None,
        *,
        newest_first: bool | None = None,
        limit: int | None = None,
        cursor: str | None = None,
    ) -> world.ChangePage:
        """Returns changes with their authors and reasons.

        Args:
            since: Only changes after this number.
            newest_first: True to go back in time from the latest.
            limit: How many at most.
            cursor: ``next`` of the previous page.
        """

    @operation("GET /world/changes/{number}")
    def change(self, number: int, *, limit: int | None = None, cursor: str | None = None) -> world.Change:
        """Returns a change with its edits.

        Args:
            number: Its number.
            limit: How many edits at most.
            cursor: ``next`` of an earlier call.
        """

    @operation("POST /world/transactions", once=True)
    def write(self, order: transactions.TransactionOrder, *, version: int | None = None) -> world.Written:
        """Applies several writes as one change, all or none.

        Args:
            order: The writes, and the expected versions of elements.
            version: The version of the world that was seen; None for whatever it is now.
        """

    @operation("POST /world/undo", once=True)
    def undo(self, change: int | None = None) -> world.Change:
        """Undoes the last edit made by a user.

        Args:
            change: Only if it is this one.
        """

    @operation("POST /world/redo", once=True)
    def redo(self, change: int | None = None) -> world.Change:
        """Reverts the last undo, as long as no user has made another edit since.

        Args:
            change: Only if it is this undo.
        """


class Elements(Topic[C]):
    """The elements of the world and their relations."""

    @operation("GET /elements")
    def list(
        self,
        *,
        class_: str | None = None,
        label: str | None = None,
        text: str | None = None,
        place: str | None = None,
        abstract: bool | None = None,
        limit: int | None = None,
        cursor: str | None = None,
    ) -> world.ElementPage:
        """Lists elements in the order of their ids.

        Args:
            class_: Only of this class or a subclass.
            label: Only with exactly this label.
            text: Only with this text in id, label or class.
            place: Only those placed directly here.
            abstract: True for elements described by the ontology or learned.
            limit: How many at most.
            cursor: ``next`` of the previous page.
        """

    @operation("GET /elements/{element}")
    def get(self, element: str, *, computed: Sequence[str] = ()) -> world.ElementDetails:
        """Returns an element.

        Args:
            element: Its id.
            computed: Computed relations to evaluate; "all" for all.
        """

    @operation("GET /elements/{element}/relations")
    def relations(
        self, element: str, *, relation: str | None = None, limit: int | None = None, cursor: str | None = None
    ) -> world.RelationPage:
        """Lists the relations of an element, in both directions.

        Args:
            element: Its id.
            relation: Only this relation or its sub-relations; may be a computed one.
            limit: How many at most.
            cursor: ``next`` of the previous page.
        """

    @operation("GET /elements/{element}/history")
    def history(
        self, element: str, *, newest_first: bool = True, limit: int | None = None, cursor: str | None = None
    ) -> world.ChangePage:
        """Returns the changes that affected an element, which may have been removed.

        Args:
            element: Its id.
            newest_first: Whether to go back in time.
            limit: How many at most.
            cursor: ``next`` of the previous page.
        """

    @operation("POST /elements", once=True)
    def add(self, new: world.NewElement) -> world.ElementDetails:
        """Adds an element with its values, its place and its relations."""

    @operation("PATCH /elements/{element}")
    def edit(self, element: str, patch: world.ElementPatch, *, version: int | None = None) -> world.ElementDetails:
        """Changes label, values and place of an element.

        Args:
            element: Its id.
            patch: The changes.
            version: The version that was seen; None for whatever it is now.
        """

    @operation("DELETE /elements/{element}", once=True)
    def remove(self, element: str, *, version: int | None = None, reason: str | None = None) -> world.Written:
        """Removes an element with its parts.

        Args:
            element: Its id.
            version: The version that was seen; None for whatever it is now.
            reason: Why.
        """

    @operation("PUT /elements/{element}/relations/{relation}/{other}?reason")
    def relate(
        self, element: str, relation: str, other: str, *, version: int | None = None, reason: str | None = None
    ) -> world.Written:
        """States that the first element has the relation to the second; a placement moves its element.

        Args:
            element: The subject.
            relation: The relation.
            other: The object.
            version: The version of the subject that was seen; None for whatever it is now.
            reason: Why.
        """

    @operation("DELETE /elements/{element}/relations/{relation}/{other}", once=True)
    def unrelate(
        self, element: str, relation: str, other: str, *, version: int | None = None, reason: str | None = None
    ) -> world.Written:
        """Removes a stated relation; arguments as for :meth:`relate`."""


class Ontology(Topic[C]):
    """The classes, relations and properties of the world.

    ``language`` is that of labels and comments: tags as in ``Accept-Language`` ("de", "fr, de;q=0.5"). Terms without it
    are answered in English.
    """

    @operation("GET /ontology/classes")
    def classes(
        self, root: str | None = None, *, depth: int | None = None, language: str | None = None
    ) -> ontology.ClassNode:
        """Returns the tree of classes.

        Args:
            root: The root class.
            depth: How many levels below it.
            language: Languages of labels and comments, best first.
        """

    @operation("GET /ontology/classes/{name}")
    def get(self, name: str, *, language: str | None = None) -> ontology.ClassDetails:
        """Returns a class."""

    @operation("GET /ontology/relations")
    def relations(
        self, *, limit: int | None = None, cursor: str | None = None, language: str | None = None
    ) -> ontology.RelationInfoPage:
        """Lists the relations by name."""

    @operation("GET /ontology/properties")
    def properties(
        self, *, limit: int | None = None, cursor: str | None = None, language: str | None = None
    ) -> ontology.PropertyPage:
        """Lists the properties by name."""

    @operation("GET /ontology/placements")
    def placements(
        self,
        *,
        class_: str | None = None,
        element: str | None = None,
        relation: str | None = None,
        limit: int | None = None,
        cursor: str | None = None,
        language: str | None = None,
    ) -> ontology.PlacementOptions:
        """Returns where something may be placed.

        Args:
            class_: The class of a new thing.
            element: Or an existing element.
            relation: Only this placement relation.
            limit: Maximum number of places per relation.
            cursor: ``next`` of an earlier option, together with its relation.
            language: Languages of the labels, best first.
        """


class Queries(Topic[C]):
    """SPARQL queries."""

    @operation("POST /queries")
    def ask(self, question: queries.Query) -> queries.QueryAnswer:
        """Runs a SELECT, ASK or CONSTRUCT query."""


class Learned(Topic[C]):
    """Data taught to robots."""

    @operation("GET /learned")
    def list(self, *, limit: int | None = None, cursor: str | None = None) -> world.LearnedPage:
        """Lists the data taught to robots."""

    @operation("POST /learned", once=True)
    def add(self, new: world.NewElement) -> world.Written:
        """Teaches a concept; its id is ``ids["new"]`` of the result.

        Args:
            new: Its description; ``like`` names an element of the scene.
        """

    @operation("PATCH /learned/{element}", once=True)
    def edit(self, element: str, patch: world.ElementPatch, *, version: int | None = None) -> world.Written:
        """Changes label and values of a taught element.

        Args:
            element: Its id.
            patch: The changes.
            version: The version that was seen; None for whatever it is now.
        """

    @call
    def load(
        self, text: str, *, media_type: str = "text/turtle", replace: bool = False, reason: str = ""
    ) -> Call[world.Written]:
        """Adds the taught data of a file; what exists already is left as it is.

        Args:
            text: The text of the file.
            media_type: Its format, of :data:`skiros_py.files.RDF_TYPES`.
            replace: Whether what is different is replaced.
            reason: Why.
        """
        return Call(
            "POST",
            "/learned/import",
            world.Written,
            {"replace": replace, "reason": reason},
            content=text.encode(),
            headers={"Content-Type": media_type},
            repeatable=False,
        )

    @operation("DELETE /learned/{element}", once=True)
    def forget(self, element: str, *, version: int | None = None, reason: str | None = None) -> world.Written:
        """Deletes a taught element with its parts; an undo restores it.

        Args:
            element: Its id.
            version: The version that was seen; None for whatever it is now.
            reason: Why.
        """

    @operation("POST /learned/forget", once=True)
    def forget_runs(
        self,
        *,
        skill: str | None = None,
        robot: str | None = None,
        place: str | None = None,
        kind: str | None = None,
    ) -> world.Written:
        """Deletes what was learned from runs; an undo restores it.

        Args:
            skill: Only about this skill.
            robot: Only about this robot.
            place: Only about this place.
            kind: Only about parts of this class.
        """

    @operation("GET /learned.ttl")
    def export(self) -> str:
        """Returns all learned data as Turtle text."""


class Locks(Topic[C]):
    """Edit locks on elements."""

    @operation("GET /locks")
    def list(self) -> world.LockList:
        """Returns the edit locks."""

    @operation("POST /locks")
    def lock(self, order: world.LockOrder) -> world.LockList:
        """Locks elements against edits by other users and jobs for a while; calling it again extends the lock."""

    @operation("DELETE /locks")
    def end(self, elements: Sequence[str] | None = None, *, owner: str | None = None) -> world.LockList:
        """Releases the caller's locks and returns the remaining ones.

        Args:
            elements: The elements; by default all.
            owner: Owner of the locks; only an admin may release those of others.
        """


class Scenes(Topic[C]):
    """Scenes: those that can be loaded, and the current one."""

    @operation("GET /scenes")
    def list(self, *, limit: int = 100, cursor: str | None = None) -> scenes.Scenes:
        """Lists the scenes that can be loaded, by name."""

    @operation("GET /scene")
    def get(self) -> scenes.CurrentScene:
        """Returns the current scene."""

    @operation("GET /scenes/{name}")
    def file(self, name: str) -> scenes.Scene:
        """Returns the contents of a scene without loading it."""

    @operation("GET /scene.ttl")
    def turtle(self) -> str:
        """Returns the current scene as Turtle."""

    @operation("GET /scene/diff", name="with")
    def difference(self, name: str, *, limit: int = 100, cursor: str | None = None) -> scenes.SceneDifference:
        """Returns the difference from another scene to the current one."""

    @operation("PUT /scene", once=True)
    def load(self, name: str, *, version: int | None = None) -> scenes.CurrentScene:
        """Loads a scene; returns once the station is up in it.

        Args:
            name: Its name.
            version: The version of the world the caller has seen; None for any.
        """

    @call
    def upload(
        self, text: str, *, version: int | None = None, media_type: str = "text/turtle"
    ) -> Call[scenes.CurrentScene]:
        """Loads a scene from the text of a file; see :meth:`load`.

        Args:
            text: The text.
            version: The version of the world the caller has seen; None for any.
            media_type: Its format, of :data:`skiros_py.files.RDF_TYPES`.
        """
        headers = {"If-Match": tag(version) or "*", "Content-Type": media_type}
        return Call("PUT", "/scene", scenes.CurrentScene, content=text.encode(), headers=headers, repeatable=False)

    @operation("POST /scenes", once=True)
    def save(self, name: str, *, seen: int | None = None) -> scenes.SceneEntry:
        """Saves the current scene.

        Args:
            name: The name to save it under.
            seen: The version of the saved scene that it replaces; None for a new one.
        """

    @operation("DELETE /scenes/{name}")
    def delete(self, name: str, *, seen: int | None = None) -> None:
        """Removes a saved scene; if a version is given, only that one."""
