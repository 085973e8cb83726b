"""The file of a replay: whatever a crash leaves of it can be read, and gone on with."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.server.replays.lines import Kind, Line, add_lines, mend, read_lines

FIRST: list[Line] = [(Kind.BEGINNING, b'{"job":"kit"}'), (Kind.VIEW, '{"label":"Anlasser \u2028 äöü"}'.encode())]
SECOND: list[Line] = [(Kind.FRAMES, b"AAAA"), (Kind.FULL, b""), (Kind.END, b'{"time":1.5}')]


def test_lines_come_back_as_they_were_kept(tmp_path: Path) -> None:
    file = tmp_path / "one"
    sizes = [add_lines(file, FIRST), add_lines(file, SECOND)]
    assert read_lines(file) == FIRST + SECOND
    assert file.stat().st_size == sum(sizes)


def test_a_file_that_was_cut_off_anywhere_has_its_whole_pieces(tmp_path: Path) -> None:
    file = tmp_path / "one"
    first = add_lines(file, FIRST)
    add_lines(file, SECOND)
    data = file.read_bytes()
    for length in range(len(data)):
        file.write_bytes(data[:length])
        assert read_lines(file) == (FIRST if length >= first else [])


@pytest.mark.parametrize("torn", [b"", b"\x1f\x8b\x08", b"no such thing at all", bytes(100)])
def test_a_torn_file_is_mended_before_others_follow(tmp_path: Path, torn: bytes) -> None:
    file = tmp_path / "one"
    add_lines(file, FIRST)
    with file.open("ab") as more:
        more.write(torn)
    mend(file)
    add_lines(file, SECOND)
    assert read_lines(file) == FIRST + SECOND
