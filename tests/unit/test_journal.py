"""A simulator's journal: whatever a client does often is counted, and written only now and then."""

import json

from simulators.common.journal import A_SECOND, BURST, Journal


class Time:
    """A clock that stands still until it is moved."""

    now = 1000.0

    def monotonic(self):
        return self.now


def lines(path):
    return [json.loads(line) for line in (path / "journal.jsonl").read_text().splitlines()]


def test_a_flood_writes_few_lines_and_all_of_it_is_counted(tmp_path):
    clock = Time()
    journal = Journal(tmp_path / "journal.jsonl", clock)
    for _ in range(20_000):
        clock.now += 1e-3
        journal.note("refused", why="no claim")
    assert journal.counts["refused"] == 20_000
    written = lines(tmp_path)
    assert BURST <= len(written) <= BURST + 20 * A_SECOND + 1
    clock.now += 60
    journal.note("refused", why="no claim")
    counted = lines(tmp_path)
    assert sum(1 + line.get("left_out", 0) for line in counted) == 20_001
    journal._file.close()


def test_a_flood_of_one_kind_hides_no_other(tmp_path):
    journal = Journal(tmp_path / "journal.jsonl", Time())
    for _ in range(1000):
        journal.note("refused")
        journal.note("motion", motion=1)
    journal.note("hold", moving=True)
    told = [line["event"] for line in lines(tmp_path)]
    assert (told.count("refused"), told.count("motion"), told.count("hold")) == (BURST, 1000, 1)
    journal._file.close()
