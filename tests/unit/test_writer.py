"""What is written first to a viewer whose line takes one message at a time."""

import asyncio
import json
from types import SimpleNamespace

from websockets.frames import Frame, Opcode
from websockets.streams import StreamReader

from portal.live.cheers import Cheers
from portal.live.rooms import Room
from portal.live.viewer import Viewer, Wish
from portal.live.writer import Writer
from robots.kit.contract.short_heads import FIRST, ShortHeads
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.packets import CommandStage, Notice

THIN = Wish(frozenset({0}), 5.0, compact=True, pieces=True)
STATE, PATH, PICTURE = b"\xc8state", b"\x06path", b"\x02" + bytes(200)
DELTAS = [pack(StreamPacket(0, n, 0, n == 1, bytes((n,)))) for n in (1, 2)]
MAP = pack(StreamPacket(0, 3, 0, True, b"m" * 150))


def content(message):
    return (Opcode.TEXT, message.encode()) if isinstance(message, str) else (Opcode.BINARY, message)


class ThinLine:
    """A connection that takes one message, until it is emptied."""

    deflates, window = False, 80

    def __init__(self):
        self.written, self._taken, self._kept, self.bounded = [], True, False, None
        self.when_free = self.when_ready = lambda call: None

    @property
    def ready(self):
        return self._taken and not self._kept

    def free(self):
        return self._taken

    def is_closing(self):
        return False

    def bound(self, on):
        self.bounded = on

    def remember(self, on):
        self.remembers = on

    def frame(self, message):
        return Frame(*content(message)).serialize(mask=False)

    def size(self, message):
        return len(content(message)[1])

    def keep(self, waits):
        self._kept = waits

    def write(self, frame):
        self.written.append(frame)
        self._taken = False


def parsed(frame, *extensions):
    """Return the frame in these bytes, as these extensions read it."""
    reader = StreamReader()
    reader.feed_data(frame)
    parser = Frame.parse(reader.read_exact, mask=False, extensions=extensions)
    try:
        while True:
            next(parser)
    except StopIteration as end:
        return end.value


def read(frame):
    """Return what is in a frame: a text, or bytes."""
    found = parsed(frame)
    return bytes(found.data).decode() if found.opcode == Opcode.TEXT else bytes(found.data)


async def written(put, most=40, texts=lambda before: {}):
    """Let a writer write to a thin line what `put(viewer, number of messages before)` gives it; return the messages.

    `texts(number of messages before)`: long texts by their kind.
    """
    line, got = ThinLine(), []
    viewer = Viewer("arm", line)
    viewer.choose(THIN)
    assert line.bounded
    assert line.remembers
    packets = []
    hub = SimpleNamespace(link=True, video=lambda _: [], watchers=lambda _: 3, cheers=lambda _: Cheers())
    hub.news = lambda _: [packets.pop(0) for _ in list(packets)]
    writer = Writer(viewer, None, asyncio.Event(), hub)
    task = asyncio.create_task(writer.run())
    for _ in range(most):
        packets += put(viewer, len(got)) or []
        for kind, text in texts(len(got)).items():
            await writer.tell(kind, text)
        for _ in range(20):
            await asyncio.sleep(0)
        if not line.written:
            break
        got.append(read(line.written.pop()))
        assert not line.written, "more than one message at once"
        line._taken = True
        writer.freed.set()
    task.cancel()
    return got


def with_a_notice(at):
    """Return what puts a state before each message, a picture before the first one, and an event before that one."""

    def put(viewer, before):
        viewer.put_state(STATE + bytes((before,)))
        if before == 0:
            viewer.put_picture(0, PICTURE)
        if before == at:
            viewer.put_event(Notice("stopped"))

    return put


def whole(pieces):
    return b"".join(piece[2:] for piece in pieces)


def test_a_path_and_events_come_first_then_state_packets_and_pieces_of_a_picture_in_rounds():
    def put(viewer, before):
        if before == 0:
            viewer.put_picture(0, PICTURE)
            viewer.put_path(PATH)
            viewer.put_state(STATE)
            viewer.put_event(Notice("first"))
            return list(DELTAS)
        return None

    got = asyncio.run(written(put))
    assert got[0] == PATH
    assert "first" in got[1]
    assert got[2:4] == [STATE, DELTAS[0]]
    assert got[4] == bytes((FIRST, 0, 2 << 4, 2)), "the delta, with a short head; the picture is not begun before"
    pieces = [one for one in got[4:] if one[0] == 7]
    assert whole(pieces) == PICTURE
    assert all(len(piece) <= ThinLine.window for piece in pieces)


def test_what_is_urgent_overtakes_a_picture_that_has_begun_and_no_state_waits_for_more_than_a_piece():
    got = asyncio.run(written(with_a_notice(4), 12))
    begun = next(n for n, one in enumerate(got) if one[0] == 7)
    ended = max(n for n, one in enumerate(got) if one[0] == 7)
    at = next(n for n, one in enumerate(got) if isinstance(one, str))
    assert begun < at < ended
    assert at == 4, "it is the next message after it has come"
    kinds = ["state" if isinstance(one, bytes) and one[0] == 200 else "other" for one in got if isinstance(one, bytes)]
    assert all("state" in kinds[n : n + 2] for n in range(len(kinds) - 1))
    assert got[-1][-1] >= len(got) - 2, "it is the newest"


def test_packets_of_a_stream_keep_their_order_though_one_comes_in_pieces():
    later = pack(StreamPacket(0, 4, 0, False, b"later"))

    def put(viewer, before):
        viewer.wake()
        return [MAP, later] if before == 0 else None

    got = asyncio.run(written(put))
    assert whole(got[:-1]) == MAP
    assert got[-1] == bytes((FIRST, 0, 4 << 4)) + b"later"


def test_a_short_packet_of_another_stream_overtakes_one_in_pieces():
    moved = [pack(StreamPacket(1, n, 0, n == 1, b"moved")) for n in (1, 2)]

    def put(viewer, before):
        viewer.wake()
        return {0: [MAP], 1: moved}.get(before)

    got = asyncio.run(written(put))
    assert [one[0] for one in got][:4] == [7, 3, 7, FIRST + 1], "one packet a round"
    assert whole(one for one in got if one[0] == 7) == MAP


def test_a_key_packet_takes_the_place_of_those_of_its_stream_that_wait():
    newer = [pack(StreamPacket(0, n, 0, True, f"map {n}".encode())) for n in (4, 5)]

    def put(viewer, before):
        viewer.wake()
        return {0: [MAP], 1: newer[:1], 2: newer[1:]}.get(before)

    got = asyncio.run(written(put))
    assert whole(got[:-1]) == MAP
    assert got[-1] == newer[1]


def test_a_picture_that_nobody_looks_at_any_more_is_not_sent_to_its_end():
    def put(viewer, before):
        if before == 0:
            viewer.put_picture(0, PICTURE)
        if before == 1:
            viewer.choose(Wish(frozenset(), compact=True, pieces=True))
            viewer.put_state(STATE)

    got = asyncio.run(written(put))
    assert [one[0] for one in got] in ([7, 200], [7, 7, 200])
    assert not any(one[1] & 2 for one in got if one[0] == 7)


def test_deltas_that_follow_have_short_heads_also_where_they_come_in_pieces():
    long = pack(StreamPacket(0, 5, 90, False, b"l" * 150))
    packets = [MAP, pack(StreamPacket(0, 4, 40, False, b"later")), long]

    def put(viewer, before):
        viewer.wake()
        return packets if before == 0 else None

    got = asyncio.run(written(put))
    pieces = [one for one in got if one[0] == 7]
    ended = [n for n, one in enumerate(pieces) if one[1] & 2]
    assert len(ended) == 2
    reader = ShortHeads()
    assert reader.restore(whole(pieces[: ended[0] + 1])) == MAP
    (short,) = [one for one in got if one[0] == FIRST]
    assert len(short) == 3 + len(b"later")
    assert reader.restore(short) == packets[1]
    assert reader.restore(whole(pieces[ended[0] + 1 :])) == long
    assert len(whole(pieces[ended[0] + 1 :])) == 3 + 150


def test_the_path_of_a_motion_that_begins_waits_for_nothing_over_a_thin_line():
    line, packet = ThinLine(), bytes((6, *bytes(40)))
    viewer, room = Viewer("arm", line), Room("arm")
    viewer.choose(THIN)
    room.add(viewer)
    line._taken = False  # something is on the way
    room.give_path(packet)
    assert [read(frame) for frame in line.written] == [packet]
    assert viewer.take_path() is None
    viewer.choose(Wish())
    room.give_path(packet)
    assert viewer.take_path() == packet


WHOLE = b"\x01" + bytes(range(100))


def test_a_whole_state_between_compact_ones_lets_them_pass():
    def put(viewer, before):
        viewer.put_state(STATE + bytes((before,)))
        if before == 0:
            viewer.put_state(WHOLE)

    got = asyncio.run(written(put, 9))
    pieces = [one for one in got if one[0] == 7]
    assert whole(pieces) == WHOLE
    assert got[1] != WHOLE
    assert [one[0] for one in got[:4]] == [200, 7, 200, 7]


def test_where_no_compact_states_come_a_whole_one_is_sent_as_such():
    def put(viewer, before):
        if before == 0:
            viewer.put_state(WHOLE)

    assert asyncio.run(written(put)) == [WHOLE]


def test_of_the_stages_of_a_command_that_wait_the_newest_is_sent():
    def put(viewer, before):
        for command, state in (
            ((1, "accepted"), (2, "accepted"), (1, "sent"), (1, "acknowledged")) if before == 0 else ()
        ):
            viewer.put_event(CommandStage(command, 1, 1, "move", state))

    got = [json.loads(text) for text in asyncio.run(written(put))]
    assert [(told["id"], told["state"]) for told in got] == [(2, "accepted"), (1, "acknowledged")]


SNAPSHOT = "a snapshot of " + "many words " * 30


def joined(pieces):
    return "".join(piece[2:] for piece in pieces)


def test_a_long_text_lets_states_and_events_pass_and_comes_before_a_picture():
    got = asyncio.run(written(with_a_notice(3), 24, lambda before: {"snapshot": SNAPSHOT} if before == 0 else {}))
    pieces = [one for one in got if isinstance(one, str) and one[0] == "\x07"]
    assert joined(pieces) == SNAPSHOT
    assert all(len(piece) <= ThinLine.window for piece in pieces)
    assert [piece[1] for piece in pieces] == ["1", *["0"] * (len(pieces) - 2), "2"]
    assert "stopped" in got[3], "it is the next message after it has come"
    first = next(n for n, one in enumerate(got) if isinstance(one, bytes) and one[0] == 7)
    assert first > got.index(pieces[-1]), "the picture waits"
    kinds = [
        "state" if isinstance(one, bytes) and one[0] == 200 else "other" for one in got if "stopped" not in str(one)
    ]
    assert all("state" in kinds[n : n + 2] for n in range(len(kinds) - 1))


def test_a_text_that_was_begun_is_sent_to_its_end_and_of_those_that_wait_the_newest_of_each_kind():
    told = {0: {"snapshot": "first " * 30}, 1: {"snapshot": "second " * 30, "plan": "plan"}, 2: {"snapshot": "third"}}
    got = asyncio.run(written(lambda viewer, before: viewer.wake(), 12, lambda before: told.get(before, {})))
    ended = next(n for n, one in enumerate(got) if one[:2] == "\x072")
    assert joined(got[: ended + 1]) == "first " * 30
    assert got[ended + 1 :] == ["third", "plan"]


def test_a_text_that_was_begun_over_a_thin_line_is_not_overtaken_where_the_line_is_thin_no_longer():
    def put(viewer, before):
        viewer.wake()
        if before == 1:
            viewer.choose(Wish(frozenset()))

    told = {0: {"snapshot": SNAPSHOT}, 2: {"snapshot": "newer"}}
    got = asyncio.run(written(put, 12, lambda before: told.get(before, {})))
    assert joined(got[:-1]) == SNAPSHOT
    assert got[-1] == "newer"
