"""Use cases of the world as a whole: its size, tree and changes; transactions and undo."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterator
from operator import itemgetter
from typing import TYPE_CHECKING

from skiros_py.api import world as api
from skiros_py.api.transactions import TransactionOrder
from skiros_py.api.view import WorldView
from skiros_py.errors import FileError, Locked, Refused, StaleVersion, UnknownName, WorldError
from skiros_py.messages import Message, joined
from skiros_py.planning.experience import forget
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, Sent, Service, addressed
from skiros_py.station.scenes.loading import shown
from skiros_py.station.world import editing
from skiros_py.station.world.values import plain
from skiros_py.station.world.view import view_of
from skiros_py.world.change import Change, SourceEdit
from skiros_py.world.element import is_learned
from skiros_py.world.index import Index
from skiros_py.world.scene.learned import import_learned, learned_names, learned_turtle
from skiros_py.world.undo import redo, undo
from skiros_py.world.vocabulary import APPLIES_TO, ELEMENT, MODULE, ROOT, SPATIAL_THING, STRUCTURE

if TYPE_CHECKING:
    from collections.abc import Sequence


MOST_NODES = 2000
"""Maximum number of nodes of one answer: those nearest to the root; clients request the others."""

_TOP = ""
"""The node above everything."""


def tree(view: Index, root: str, depth: int, limit: int, after: str = "") -> api.TreeNode:
    """Returns an element with its descendants.

    Args:
        view: The state.
        root: Its id; "" for the node above everything.
        depth: Number of levels below it.
        limit: Maximum number of children of each node.
        after: Only children of the root after this id.

    Raises:
        UnknownName: There is no such element.
    """
    if root != _TOP:
        view.element(root)
    top = _node(view, root, "")
    waiting, budget = deque([(top, depth)]), MOST_NODES
    while waiting:
        node, levels = waiting.popleft()
        found = sorted(_children(view, node.id))
        start = bisect_right(found, after, key=itemgetter(0)) if node is top else 0
        shown = found[start : start + min(limit, budget)] if levels else []
        budget -= len(shown)
        more = shown[-1][0] if shown and start + len(shown) < len(found) else None
        node.children_total, node.next = len(found), more
        node.children = [_node(view, name, relation) for name, relation in shown]
        waiting.extend((child, levels - 1) for child in node.children)
    return top


def _node(view: Index, name: str, relation: str) -> api.TreeNode:
    """Returns a node without its children."""
    element = None if name == _TOP else view.element(name)
    return api.TreeNode(
        id=name,
        class_="" if element is None else element.type,
        label="world" if element is None else element.label,
        relation=relation,
        version=view.version if element is None else view.stamp(name).change,
        children=[],
        children_total=0,
        next=None,
    )


def _children(view: Index, name: str) -> Iterator[tuple[str, str]]:
    """Yields the children of an element, each with its relation."""
    if name == _TOP:
        yield from ((child, "") for child in _roots(view))
        return
    for relation in view.ontology.sub_relations(STRUCTURE)[1:]:
        yield from ((piece, relation) for piece in view.objects(name, relation))
    for guest in view.contents(name):
        placement = view.placement(guest)
        if placement is not None:
            yield guest, placement.relation


def _roots(view: Index) -> set[str]:
    """Returns elements that are neither placed nor pieces; without modules, which are many and shown elsewhere."""
    known = view.ontology.classes
    elsewhere = {name for class_ in (SPATIAL_THING, MODULE) if class_ in known for name in view.instances(class_)}
    loose = set(view.instances(ELEMENT)) - elsewhere
    return set(view.instances(ROOT)) | {name for name in loose if not view.owners(name)}


class WorldService(Service):
    """Reads the world as a whole, and executes transactions of a person."""

    # ------------------------------------------------------------------ reading

    def info(self) -> api.WorldInfo:
        """Returns the world's version, its size, and the edit that an undo would revert."""
        world = self._world
        view = world.snapshot()
        abstract = view.abstracts(ELEMENT)
        learned = sum(map(is_learned, abstract))
        return api.WorldInfo(
            version=view.version,
            time=world.clock(),
            elements=view.count(ELEMENT),
            abstract=len(abstract) - learned,
            learned=learned,
            goals=len(view.goals),
            locks=len(world.locks.held()),
            remembered_from=world.log.first,
            undoable=editing.undoable(world),
            redoable=editing.redoable(world),
        )

    def tree(self, root: str = "", depth: int = 3, limit: int = 100, after: str = "") -> api.TreeNode:
        """Returns placements and parts of all elements as a tree.

        Args:
            root: Id of the root; the node above everything if omitted.
            depth: Number of levels below it.
            limit: Maximum number of children of each node.
            after: Only children of the root after this one.

        Raises:
            NotFound: There is no such element.
        """
        with addressed():
            return tree(self._world.snapshot(), root, depth, limit, after)

    def changes(self, beyond: int = 0, limit: int = 100, *, newest_first: bool = False) -> api.ChangePage:
        """Lists changes, with the first 100 edits of each.

        Raises:
            Refused: They are no longer kept.
        """
        return editing.change_page(self._world, beyond, limit, newest_first=newest_first)

    def change(self, number: int, start: int = 0, limit: int = 1000) -> api.Change:
        """Returns a change with its edits.

        Raises:
            Refused: There is none with this number, or it is no longer kept.
        """
        return editing.one_change(self._world, number, start, limit)

    def view_tag(self) -> str:
        """Returns a tag of the current view, which changes with every visible difference."""
        # After a restart the shapes may differ at the same version of the world.
        return f"{self._world.version}.{self._station.events.epoch}"

    def view(self, elements: Sequence[str] | None = None) -> WorldView:
        """Returns the believed poses and shapes of all elements.

        Args:
            elements: Only these elements, with those that move with them; all if omitted.
        """
        session = self._station.session
        frames = session.runtime.context.frames.at(session.cycle.board.snapshot)
        return view_of(session.world.snapshot(), elements, frames.platforms())

    # ------------------------------------------------------------------ writing

    def write(self, order: TransactionOrder, seen: Seen | None = None, author: Author = LIBRARY) -> api.Written:
        """Executes all operations as one change, or none.

        Raises:
            WorldError: The world refuses it.
            Refused: It changes elements without naming the versions that the author has seen.
        """
        world = self._world
        with editing.writing(world, author, order.reason, _expected(order, seen)) as tx:
            ids = editing.operate(tx, order.operations)
        return editing.written(world, tx, ids)

    def undo(self, order: api.UndoOrder | None = None, author: Author = LIBRARY) -> api.Change:
        """Reverts the last edit of a person that was not reverted yet.

        Raises:
            Refused: Later changes depend on it.
            StaleVersion: The last edit is not the one given.
            Locked: Another author has locked an affected element.
        """
        return self._revert(undo, "CannotUndo", order, author)

    def redo(self, order: api.UndoOrder | None = None, author: Author = LIBRARY) -> api.Change:
        """Reverts the last undo, as long as no person has made another edit since.

        Raises:
            Refused: There is none, or later changes depend on it.
            StaleVersion: The last undo is not the one given.
            Locked: Another author has locked an affected element.
        """
        return self._revert(redo, "CannotRedo", order, author)

    def _revert(
        self, how: Callable[..., Change], refusal: str, order: api.UndoOrder | None, author: Author
    ) -> api.Change:
        expects = order.change if order else None
        try:
            return editing.change_view(how(self._world, author.name, expects=expects, holder=author.holder))
        except (StaleVersion, Locked):
            raise
        except WorldError as error:
            last = self._world.log.undoable() if how is undo else None
            was_loaded = last is not None and any(isinstance(edit, SourceEdit) for edit in last.edits)
            hint = Message("load the former scene instead: PUT /scene")
            raise Refused(refusal, joined("; ", (str(error), hint)) if was_loaded else str(error)) from None

    # ------------------------------------------------------------------ learned concepts

    def learned(self, limit: int = 100, after: str = "") -> api.LearnedPage:
        """Lists the concepts taught to robots, by id."""
        view = self._world.snapshot()
        names = [name for name in learned_names(view) if name > after]
        shown = names[:limit]
        return api.LearnedPage(
            items=[_learned_view(view, name) for name in shown], next=shown[-1] if len(names) > limit else None
        )

    def forget(
        self, element: str, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY, reason: str = ""
    ) -> api.Written:
        """Deletes a learned concept with its parts; an undo restores it.

        Raises:
            NotFound: There is no such concept.
            StaleVersion: It was changed since it was seen.
        """
        self._check_learned(element)
        reason = reason or Message("forgets {element}", element=element)
        return self._station.elements.remove(element, seen, author, reason)

    def forget_costs(
        self, skill: str = "", robot: str = "", place: str = "", kind: str = "", author: Author = LIBRARY
    ) -> api.Written:
        """Deletes what was learned from runs about a skill, robot, place or class of parts; all if none is given.

        It is one change; an undo restores it.
        """
        world = self._world
        with editing.writing(world, author, Message("forgets what was learned from runs")) as tx:
            forget(tx, world.snapshot(), skill=skill, robot=robot, place=place, kind=kind)
        return editing.written(world, tx)

    def teach(self, new: api.NewElement, author: Author = LIBRARY) -> api.Written:
        """Adds a learned concept; its id is that of ``new`` in the result.

        Raises:
            UsageError: Its id is none of a learned concept.
            WorldError: The world refuses it.
        """
        world = self._world
        with editing.writing(
            world, author, new.reason or Message("teaches a {kind}", kind=new.class_ or new.like)
        ) as tx:
            element = editing.add(tx, new, learned=True)
        return editing.written(world, tx, {"new": element})

    def edit_learned(
        self, element: str, patch: api.ElementPatch, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY
    ) -> api.Written:
        """Changes a learned concept.

        Raises:
            NotFound: There is no such concept.
            StaleVersion: It was changed since it was seen.
            WorldError: The world refuses it.
        """
        self._check_learned(element)
        return self._station.elements.edit(element, patch, seen, author)

    def import_learned(
        self, sent: Sent, author: Author = LIBRARY, reason: str = "", *, replace: bool = False
    ) -> api.Written:
        """Adds the learned concepts of a file.

        Args:
            sent: The file.
            author: Who sends it.
            reason: Why.
            replace: Whether concepts that are different in the world are replaced.

        Raises:
            Refused: The file is broken, or speaks of anything else.
            WorldError: The world refuses it, or has concepts that are different and not to be replaced.
        """
        world = self._world
        try:
            reason = reason or Message("imports concepts")
            with sent.as_file("learned") as path, editing.writing(world, author, reason) as tx:
                import_learned(world, tx, path, replace=replace)
        except FileError as error:
            reason = Message("the file is refused, nothing was changed: {error}", error=shown(error))
            raise Refused("LearnedBroken", reason, line=error.line) from None
        return editing.written(world, tx)

    def _check_learned(self, element: str) -> None:
        view = self._world.snapshot()
        with addressed():
            if not (is_learned(element) and view.has(element)):
                raise UnknownName("learned concept", element, learned_names(view))

    def learned_turtle(self) -> str:
        """Returns all learned concepts as Turtle."""
        return learned_turtle(self._world.snapshot())

    # ------------------------------------------------------------------ locks

    def locks(self) -> api.LockList:
        """Lists the locks: elements, owners and times of expiry."""
        world = self._world
        return api.LockList(items=[editing.lock_view(world, lock) for lock in world.locks.held()])

    def lock(self, order: api.LockOrder, author: Author = LIBRARY) -> api.LockList:
        """Locks all given elements or none; locking again extends the lock.

        Raises:
            Locked: Another author has locked one of them.
            UsageError: There is no such element.
        """
        world = self._world
        locks = world.locks.acquire(order.elements, author.holder, order.seconds, author.name)
        return api.LockList(items=[editing.lock_view(world, lock) for lock in locks])

    def unlock(
        self, elements: Sequence[str] | None = None, author: Author = LIBRARY, owner: str | None = None
    ) -> api.LockList:
        """Releases locks, and returns the remaining ones.

        Args:
            elements: Elements to unlock; all of the owner if omitted.
            author: The author of the request.
            owner: Owner of the locks; the author if omitted.
        """
        world = self._world
        others = owner not in (None, author.name)
        holders = {lock.owner for lock in world.locks.held() if lock.shown == owner} if others else {author.holder}
        for holder in holders:
            world.locks.release(holder, elements)
        return self.locks()


def _expected(order: TransactionOrder, seen: Seen | None) -> dict[str, int]:
    if seen is not None and seen.version is not None:
        return {"": seen.version, **order.expects}
    adds_only = all(operation.op == "add" for operation in order.operations)
    if not (order.expects or adds_only or seen is not None):
        raise Refused(
            "VersionMissing", 'say what you have seen: {"expects": {"starter_1": 17}}, or the world\'s If-Match'
        )
    return order.expects


def _learned_view(view: Index, name: str) -> api.Learned:
    element = view.element(name)
    about = element.properties.get(APPLIES_TO)
    return api.Learned.view_of(
        element,
        id=name,
        class_=element.type,
        about=None if about is None else str(about),
        properties={key: plain(value) for key, value in sorted(element.properties.items())},
        version=view.stamp(name).change,
    )
