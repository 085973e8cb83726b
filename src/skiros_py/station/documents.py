"""Documents: plain data of all kinds, stored with their revisions; those with a behaviour run as modules."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

from skiros_py.api import documents as api
from skiros_py.api.alarms import AlarmKind
from skiros_py.behaviours import Behaviour, DocumentKind, Review
from skiros_py.errors import DocumentError, DocumentFault, Refused, SkirosError, UsageError, WrongState
from skiros_py.interruptions import limited
from skiros_py.messages import Message
from skiros_py.skills.behaviour import nodes_of
from skiros_py.skills.lint.checking import faults_of_document
from skiros_py.skills.lint.rule import Known
from skiros_py.skills.parameters.values import read_value
from skiros_py.skills.plain import Reader
from skiros_py.skills.skill import RunnableDocument
from skiros_py.station.document_store import Document, DocumentStore
from skiros_py.station.requests import ANY_VERSION, Seen, Service, addressed, find, require_seen
from skiros_py.station.session import Session
from skiros_py.world.view import WorldView

_PATIENCE = 10.0
"""Wall time that the code of a kind of document may take [s]."""
_MOST = 1000
"""Maximum number of documents of a kind."""
_LONGEST = 200_000
"""Maximum length of a document as JSON."""

T = TypeVar("T")
_log = logging.getLogger(__name__)


_NOT_REVIEWED = Review()


class DocumentText(NamedTuple):
    """A document as text, in one of the formats of its kind."""

    text: str
    media_type: str
    revision: int


class DocumentService(Service):
    """Stores documents of all kinds with their revisions, and offers those that have a behaviour as modules.

    Each runs as a module ``{kind}:{id}``, by any skill manager, skill or document, from its next start on; what already
    runs continues unchanged. Its revision is kept in the events of the run.
    """

    def open(self, session: Session) -> None:
        """Offers the stored documents as modules of a session, as soon as the store is open.

        A document that cannot be read any more raises an alarm; it can be read, replaced and removed.
        """
        if not hasattr(self._station, "document_store"):
            return
        self._reader = Reader(session.catalogue.behaviours, session.catalogue.conditions)
        self._kinds = session.catalogue.documents
        for kind in self._kinds:
            for document in self._store.all(kind):
                try:
                    made = self._make(self._kind(kind), document.data, _module(kind, document.name))
                except UsageError as error:
                    text = Message("{module} cannot run: {error}", module=_module(kind, document.name), error=error)
                    _log.warning("%s", text)
                    self._station.alarms.raise_(AlarmKind.MODULE, text, _module(kind, document.name))
                else:
                    self._offer(session, document, made)

    @property
    def _store(self) -> DocumentStore:
        return self._station.document_store

    # ------------------------------------------------------------------ reading

    def kinds(self) -> api.DocumentKinds:
        """Lists the kinds of documents, each with its formats and the nodes that an editor offers."""
        return api.DocumentKinds(
            items=tuple(
                api.DocumentKindInfo(
                    kind=name,
                    help=(kind.__doc__ or "").strip().partition("\n")[0],
                    formats=dict(kind.formats),
                    palette=self._palette(name),
                )
                for name, kind in sorted(self._kinds.items())
            )
        )

    def _palette(self, kind: str) -> tuple[api.PaletteNode, ...]:
        try:
            entries = _asked(f"documents of kind {kind}", lambda: self._kind(kind).palette(self._reader))
            return tuple(map(api.PaletteNode.view_of, entries))
        except Exception as error:  # noqa: BLE001 - a plug-in's palette
            _log.warning("the palette of kind %s: %s: %s", kind, type(error).__name__, error)
            return ()

    def is_for_orders(self, kind: str) -> bool:
        """Returns whether orders name documents of a kind, so that factory systems may read them.

        Raises:
            NotFound: There is no such kind.
        """
        return self._known(kind).for_orders

    def all(self, kind: str) -> api.Documents:
        """Lists the documents of a kind, by id, without comparing them with the world.

        Raises:
            NotFound: There is no such kind.
        """
        self._known(kind)
        return api.Documents(items=tuple(map(_info, self._store.all(kind))))

    def get(self, kind: str, id_: str) -> api.DocumentInfo:
        """Returns a document, and what would not work now.

        Raises:
            NotFound: There is none.
        """
        document = self._find(kind, id_)
        return _info(document, self._reviewed(document))

    def revisions(self, kind: str, id_: str) -> api.Documents:
        """Lists the kept revisions of a document, oldest first, also of a removed one.

        Raises:
            NotFound: There is no such kind.
        """
        self._known(kind)
        return api.Documents(items=tuple(map(_info, self._store.revisions(kind, id_))))

    def export(self, kind: str, id_: str, format_: str | None = None) -> DocumentText:
        """Returns a document as text.

        Args:
            kind: Its kind.
            id_: Its id.
            format_: One of the formats of its kind; None for the first one.

        Raises:
            NotFound: There is no such document.
            UsageError: There is no such format, or its kind cannot write it.
        """
        document, known = self._find(kind, id_), self._known(kind)
        format_ = next(iter(known.formats)) if format_ is None else format_
        known.require_format(format_)
        text = _asked(_module(kind, id_), lambda: known().export(document.data, format_))
        return DocumentText(text, known.formats[format_], document.version)

    # ------------------------------------------------------------------ writing

    def put(self, kind: str, id_: str, data: Any, seen: Seen | None = ANY_VERSION) -> tuple[api.DocumentInfo, bool]:
        """Writes a document; returns it, and True if it is new. Its next run uses this revision.

        Faults that the current revision has, too, do not prevent writing: they are among its problems.

        Raises:
            NotFound: There is no such kind.
            DocumentError: It is not valid.
            WrongState: There are too many documents of its kind.
            StaleVersion: It was changed since it was seen.
        """
        self._known(kind)
        before = self._store.get(kind, id_)
        if before is not None:
            require_seen(seen, before.version)
        elif len(self._store.all(kind)) >= _MOST:
            raise WrongState(
                "there are {count} documents of kind {kind} already: remove some that are not needed",
                count=_MOST,
                kind=kind,
            )
        module, maker = _module(kind, id_), self._kind(kind)
        _require_plain(data, module)
        made = self._make(maker, data, module)
        review = self._review(maker, data, made, module)
        if review.faults:
            accepted = set() if before is None else {fault.text for fault in self._reviewed(before).problems}
            if refused := [fault for fault in review.faults if fault.text not in accepted]:
                raise DocumentError(refused, module)
        document = self._store.put(kind, id_, data, expects=0 if before is None else before.version)
        self._offer(self._station.session, document, made)
        self._station.alarms.clear(AlarmKind.MODULE, module)
        return _info(document, _as_problems(review)), before is None

    def import_text(
        self, kind: str, id_: str, text: str, media_type: str, seen: Seen | None = ANY_VERSION
    ) -> tuple[api.DocumentInfo, bool]:
        """Writes a document from text in one of the formats of its kind; see :meth:`put`.

        Raises:
            NotFound: There is no such kind.
            Refused: Its kind has no format of this media type.
            DocumentError: The text is not well-formed, or the document is not valid.
            StaleVersion: It was changed since it was seen.
        """
        known = self._known(kind)
        formats = [name for name, type_ in known.formats.items() if type_ == media_type]
        if not formats:
            types = ", ".join(known.formats.values())
            raise Refused(
                "UnsupportedMediaType", f"{kind} documents are imported as {types}, not as {media_type!r:.100}"
            )
        module, maker = _module(kind, id_), self._kind(kind)
        data = _asked(module, lambda: maker.parse(text, formats[0]))
        try:
            return self.put(kind, id_, data, seen)
        except DocumentError as error:
            faults = error.faults
            located = _asked(module, lambda: self._located(maker, data, text, formats[0], faults))
            raise DocumentError(located, module) from error

    def remove(self, kind: str, id_: str, seen: Seen | None = ANY_VERSION) -> None:
        """Removes a document; its active runs continue, and its revisions are kept.

        Raises:
            NotFound: There is none.
            StaleVersion: It was changed since it was seen.
        """
        document, module = self._find(kind, id_), _module(kind, id_)
        require_seen(seen, document.version)
        self._store.remove(kind, id_, expects=document.version)
        self._station.session.managers.documents.pop(module, None)
        self._station.alarms.clear(AlarmKind.MODULE, module)

    # ------------------------------------------------------------------ kinds

    def _find(self, kind: str, id_: str) -> Document:
        self._known(kind)
        with addressed():
            return self._store.find(kind, id_)

    def _known(self, kind: str) -> type[DocumentKind]:
        return find("kind of document", kind, self._kinds)

    def _kind(self, kind: str) -> DocumentKind:
        return _asked(f"documents of kind {kind}", self._known(kind))

    def _make(self, maker: DocumentKind, data: Any, module: str) -> RunnableDocument | None:
        """Returns a document as a module, before it has a revision; None if it has no behaviour.

        Raises:
            DocumentError: Something is wrong with it, or its kind raises an exception.
        """

        def make() -> RunnableDocument | None:
            if faults := maker.check(data, self._reader):
                raise DocumentError(faults, module)
            behaviour = maker.behaviour(data, self._reader)
            if behaviour is None:
                return None
            interface = maker.interface(data)
            return RunnableDocument(behaviour, 0, behaviour.title, interface.params, interface.outputs)

        return _asked(module, make)

    def _located(
        self, maker: DocumentKind, data: Any, text: str, format_: str, faults: Sequence[DocumentFault]
    ) -> Sequence[DocumentFault]:
        """Returns faults with the line and column of their places in the text of an imported document."""
        reader, places = replace(self._reader), {}
        with suppress(SkirosError):  # what cannot be read has no nodes: its faults have places in the data
            root = maker.behaviour(data, reader)
            nodes = () if root is None else nodes_of(root, "")
            places = {node.path.lstrip("/"): reader.places.get(id(node.behaviour), "") for node in nodes}
        known = {place: (line, column) for place, line, column in maker.places(text, format_)}

        def located(fault: DocumentFault) -> DocumentFault:
            place = places.get(fault.place, fault.place)
            while place not in known and place:  # what is missing there: its parent is
                place = place[: max(place.rfind("."), place.rfind("["), 0)]
            line, column = known.get(place, (fault.line, fault.column))
            return replace(fault, line=line, column=column)

        return tuple(map(located, faults))

    def _offer(self, session: Session, document: Document, made: RunnableDocument | None) -> None:
        module = _module(document.kind, document.name)
        if made is None:
            session.managers.documents.pop(module, None)
        else:
            session.managers.documents[module] = replace(made, revision=document.version)

    def _reviewed(self, document: Document) -> Review:
        """Compares a stored document with the current world; all that is found are problems."""
        module = _module(document.kind, document.name)
        try:
            maker = self._kind(document.kind)
            made = self._make(maker, document.data, module)
        except DocumentError as error:
            return Review(problems=error.faults)
        except UsageError as error:
            return Review(problems=(DocumentFault("", str(error)),))
        return _as_problems(self._review(maker, document.data, made, module))

    def _review(self, maker: DocumentKind, data: Any, made: RunnableDocument | None, module: str) -> Review:
        """Compares a document with the current world and the modules of this station."""
        session = self._station.session
        skills, catalogue = session.tasks.skills, session.catalogue
        try:
            world = session.world.snapshot()
            found = limited(
                lambda: "its review", _PATIENCE, lambda: maker.review(data, world, skills, catalogue.conditions)
            )
        except Exception as error:  # noqa: BLE001 - a plug-in's check
            return Review(faults=(DocumentFault("", f"{maker.kind} cannot check it: {type(error).__name__}: {error}"),))
        if made is None or found.faults:
            return found
        missing = tuple(self._missing_documents(made.behaviour, module))
        known = Known(
            session.world.ontology,
            catalogue.primitives,
            tuple(catalogue.skills.values()),
            catalogue.reasoners,
            session.runtime.signals.names,
            {**dict.fromkeys(name for _, name in missing), **session.managers.documents, module: made},
        )
        faults = faults_of_document(made.behaviour, made.params, known)
        problems = [
            DocumentFault(place, Message("there is no document '{name}' that can run", name=name))
            for place, name in missing
        ]
        if not found.agents:  # it has checked the elements itself, in the world that its steps leave
            problems += _wrong_elements(made.behaviour, known, world)
        return replace(
            found,
            faults=tuple(DocumentFault(*fault) for fault in faults),
            problems=(*found.problems, *problems),
        )

    def _missing_documents(self, root: Behaviour, module: str) -> Iterator[tuple[str, str]]:
        """Yields the calls of documents that cannot run now, each with its place: they may be written later."""
        there = {module, *self._station.session.managers.documents}
        for node in nodes_of(root, ""):
            for call in node.behaviour.uses().calls:
                kind, colon, _ = call.module.partition(":")
                if colon and kind in self._kinds and call.module not in there:
                    yield node.path.lstrip("/"), call.module


def _asked(module: str, work: Callable[[], T]) -> T:
    """Returns what code of a plug-in returns; its exceptions, and code that hangs, are faults of the document."""
    try:
        return limited(lambda: "its code", _PATIENCE, work)
    except SkirosError:
        raise
    except Exception as error:
        raise _refused(f"{type(error).__name__}: {error}", module) from error


def _refused(text: str, module: str) -> DocumentError:
    return DocumentError((DocumentFault("", text),), module)


def _require_plain(data: Any, module: str) -> None:
    """Requires that a document is an object that JSON can represent and editors can draw."""
    if not isinstance(data, dict):
        raise _refused(Message("a document is an object, not {given}", given=repr(data)[:100]), module)
    try:
        text = json.dumps(data, allow_nan=False, ensure_ascii=False)
        text.encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise _refused(f"JSON cannot represent it: {type(error).__name__}: {error!s:.200}", module) from None
    if len(text) > _LONGEST:
        said = Message("at most {most} characters of JSON, not {count}", most=_LONGEST, count=len(text))
        raise _refused(said, module)


def _wrong_elements(root: Behaviour, known: Known, world: WorldView) -> Iterator[DocumentFault]:
    """Yields the calls with constants that name no element of the world, or one of a wrong class."""
    for node in nodes_of(root, ""):
        for call in node.behaviour.uses().calls:
            for param in known.params(call.module) or ():
                value = call.inputs.get(param.key)
                if param.is_element and isinstance(value, str):
                    try:
                        read_value(param, value, world)
                    except UsageError as error:
                        yield DocumentFault(node.path.lstrip("/"), f"'{call.module}': {error}")


def _as_problems(review: Review) -> Review:
    return replace(review, faults=(), problems=(*review.faults, *review.problems))


def _module(kind: str, id_: str) -> str:
    return f"{kind}:{id_}"


def _info(document: Document, review: Review = _NOT_REVIEWED) -> api.DocumentInfo:
    return api.DocumentInfo.view_of(
        document,
        id=document.name,
        revision=document.version,
        module=_module(document.kind, document.name),
        problems=tuple(map(api.DocumentProblem.view_of, review.problems)),
        agents=dict(review.agents),
    )
