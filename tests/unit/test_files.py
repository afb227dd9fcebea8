"""A file is written beside and then replaced: readers see the old or the new one, and an error leaves nothing behind."""

import pytest

from robots.kit.files import beside, replaced


def test_what_was_written_replaces_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"old")
    with replaced(path, sync=True) as out:
        out.write(b"new")
        assert path.read_bytes() == b"old"
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("a.txt", b"new")]


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_an_error_keeps_the_old_file_and_removes_the_part(tmp_path, error):
    path = tmp_path / "a.txt"
    path.write_bytes(b"old")
    with pytest.raises(error), replaced(path) as out:
        out.write(b"half")
        raise error
    with pytest.raises(error), beside(path, tmp_path / "other.new") as part:
        part.write_bytes(b"half")
        raise error
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("a.txt", b"old")]


def test_what_was_never_written_is_an_error_and_the_old_file_stays(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"old")
    with pytest.raises(FileNotFoundError), beside(path, tmp_path / "other.new"):
        pass
    assert path.read_bytes() == b"old"
