"""Files: read as text, opened for their owner only; and the formats of those that hold triples."""

from __future__ import annotations

import os
from pathlib import Path

from skiros_py.errors import FileError

RDF_TYPES = {
    ".ttl": "text/turtle",
    ".owl": "application/rdf+xml",
    ".rdf": "application/rdf+xml",
    ".owx": "application/owl+xml",
    ".xml": "application/rdf+xml",
    ".nt": "application/n-triples",
    ".jsonld": "application/ld+json",
}
"""Media types of scenes and ontologies, by the ends of their names; XML of each name may be RDF/XML or OWL/XML."""


def read_text(path: Path) -> str:
    """Reads a file as UTF-8 text, with or without a byte-order mark.

    Raises:
        FileError: It is missing, unreadable or not such a text.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise FileError(path, "there is no such file") from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror or error}") from None
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise FileError(path, "is UTF-16 text: save it as UTF-8")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise FileError(path, f"cannot be read as UTF-8 text: {error.reason}", line=line) from None
    if "\0" in text:
        raise FileError(path, "is no text: it has a zero byte", line=text.count("\n", 0, text.index("\0")) + 1)
    return text


def open_private(path: str, flags: int) -> int:
    """Opens a file, for ``open(..., opener=open_private)``: a new one can be used by its owner only.

    A file that root makes belongs to the owner of its folder, whose programs could not use it otherwise.
    """
    file = os.open(path, flags, 0o600)
    if os.geteuid() == os.fstat(file).st_uid == 0:
        owner = Path(path).absolute().parent.stat()
        os.fchown(file, owner.st_uid, owner.st_gid)
    return file
