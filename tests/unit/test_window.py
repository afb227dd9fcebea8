"""What is on the way over a thin line: bounded whatever the line does, and never stuck."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.edge.window import LEAST, MOST_S, PAYLOAD, PING_BYTES, SendWindow
from portal.live.messages import LONGEST, NotUnderstood
from portal.live.pieces import JoinedText, Pieces, TextPieces
from tests.environment import ROOT

STATE, STEP_S = 23, 0.001  # bytes of a compact state with the head of its frame; s


class Line:
    """A line of so many bytes a second, whose peer answers pings after the delay; time is its own."""

    def __init__(self, rate, delay_s):
        self.rate, self.delay_s, self.now = rate, delay_s, 0.0
        self.window, self.waits, self.answers, self.carried, self._credit = SendWindow(), [], [], 0, 0.0

    def write(self, size):
        self.waits.append((size, None))
        self._follow(self.window.wrote(size, self.now))

    def _follow(self, ping):
        if ping is not None:
            self.waits.append((PING_BYTES, ping))

    @property
    def queue_s(self):
        return sum(size for size, _ in self.waits) / self.rate

    def step(self):
        self.now += STEP_S
        self._credit = self._credit + self.rate * STEP_S if self.waits else 0.0
        while self.waits and self._credit >= self.waits[0][0]:
            size, ping = self.waits.pop(0)
            self._credit -= size
            self.carried += size
            if ping is not None:
                self.answers.append((self.now + self.delay_s, ping))
        while self.answers and self.answers[0][0] <= self.now:
            self._follow(self.window.pong(self.answers.pop(0)[1], self.now))

    def fill(self, seconds, size=STATE):
        """Write as much as the window lets for so long; return the longest wait of a message (s)."""
        longest, end = 0.0, self.now + seconds
        while self.now < end:
            while not self.window.full:
                self.write(size)
            longest = max(longest, self.queue_s)
            self.step()
        return longest


@pytest.mark.parametrize(
    ("rate", "delay_s", "size"),
    [(100, 0.0, STATE), (100, 0.3, STATE), (500, 0.1, STATE), (1000, 0.3, STATE), (50_000, 0.3, 2000), (1e6, 0.02, 2000)],
)  # fmt: skip
def test_a_line_is_filled_and_nothing_waits_long_on_it(rate, delay_s, size):
    line = Line(rate, delay_s)
    line.fill(20, size)
    carried = line.carried
    longest = line.fill(20, size)
    assert line.carried - carried >= 0.95 * 20 * rate
    assert longest <= MOST_S + 2 * size / rate + 0.3


def test_what_waits_is_soon_short_again_where_a_line_becomes_a_tenth():
    line = Line(5000, 0.05)
    line.fill(10)
    line.rate = 500
    line.fill(20)
    assert line.fill(20) <= 1.2


def test_a_line_that_stood_still_for_a_minute_is_filled_again():
    line = Line(1000, 0.1)
    line.fill(10)
    line.rate = 1e-6
    line.fill(60)
    line.rate = 1000
    line.fill(10)
    carried = line.carried
    assert line.fill(20) <= 1.2
    assert line.carried - carried >= 0.8 * 20 * 1000


def test_a_line_that_has_become_longer_is_filled_again():
    line = Line(20_000, 0.01)
    line.fill(10)
    line.delay_s = 0.8
    line.fill(30)
    carried = line.carried
    line.fill(20)
    assert line.carried - carried >= 0.5 * 20 * 20_000


@given(st.lists(st.integers(1, 5000) | st.just("pong") | st.just("late") | st.binary(max_size=4), max_size=60))
def test_a_full_window_always_waits_for_a_ping_and_is_empty_once_all_are_answered(steps):
    window, sent, now = SendWindow(), [], 0.0
    for step in steps:
        now += 0.1
        ping = None
        if isinstance(step, int):
            ping = window.wrote(step, now)
        elif isinstance(step, bytes):
            known = step in sent
            before = window.on_the_way
            ping = window.pong(step, now)
            assert known or window.on_the_way == before, "an answer to nothing"
            sent = sent[sent.index(step) + 1 :] if known else sent
        elif sent:  # the oldest is answered, or the newest, which stands for all before it
            answered = sent[0] if step == "pong" else sent[-1]
            ping = window.pong(answered, now)
            sent = sent[sent.index(answered) + 1 :]
        sent += [ping] if ping is not None else []
        assert window.on_the_way >= 0
        assert window.size >= LEAST
        assert sent or not window.full, "nothing would ever be written again"
    while sent:
        now += 0.1
        ping = window.pong(sent.pop(), now)
        sent = [] if ping is None else [ping]
    assert not window.full
    assert all(len(ping) == PAYLOAD.size for ping in sent)


@given(st.binary(min_size=1, max_size=500), st.integers(0, 200))
def test_a_message_in_pieces_is_whole_again(data, most):
    pieces, got = Pieces(), []
    pieces.begin(data)
    while pieces.left:
        got.append(pieces.take(most))
    assert b"".join(one[2:] for one in got) == data
    assert all(one[0] == 7 and len(one) <= max(most, 3) for one in got)
    assert [bool(one[1] & 1) for one in got] == [True] + [False] * (len(got) - 1)
    assert [bool(one[1] & 2) for one in got] == [False] * (len(got) - 1) + [True]


@pytest.mark.parametrize(
    "one", json.loads((ROOT / "tests/vectors/pieces.json").read_text()), ids=lambda one: one["what"]
)
def test_pieces_are_cut_as_the_browser_reads_them(one):
    pieces, got = Pieces(), []
    pieces.begin(bytes.fromhex(one["message"]))
    while pieces.left:
        got.append(pieces.take(one["most"]).hex())
    assert got == one["pieces"]


@given(
    st.text(st.characters(exclude_characters="\x07", exclude_categories=["Cs"]), max_size=400),
    st.integers(0, 120),
    st.sampled_from([1, 3, 10]),
)
def test_a_text_in_pieces_is_whole_again(text, most, ratio):
    pieces, got = TextPieces(), []
    pieces.put("one", text)
    while pieces.left:
        got.append(pieces.take(most, lambda piece: len(piece.encode()) // ratio))
    joined = JoinedText()
    assert [joined.take(one) for one in got] == [*[None] * (len(got) - 1), text]
    if len(got) == 1 and got[0] == text:
        return
    assert "".join(one[2:] for one in got) == text
    assert all(len(one.encode()) // ratio <= most or len(one) == 3 for one in got)
    assert [one[:2] for one in got] == ["\x071", *["\x070"] * (len(got) - 2), "\x072"] if len(got) > 1 else ["\x073"]


@pytest.mark.parametrize(
    "one", json.loads((ROOT / "tests/vectors/text_pieces.json").read_text()), ids=lambda one: one["what"]
)
def test_texts_are_cut_as_the_browser_reads_them(one):
    pieces, got = TextPieces(), []
    pieces.put("one", one["message"])
    while pieces.left:
        got.append(pieces.take(one["most"], lambda piece: len(piece.encode())))
    whole = "".join(piece[2:] if piece[0] == "\x07" else piece for piece in got)
    assert (got, whole) == (one["pieces"], one["message"])


@given(
    st.lists(
        st.tuples(st.sampled_from(["\x070", "\x071", "\x072", "\x073", "\x07", "\x079", ""]), st.text(max_size=5000)),
        max_size=8,
    )
)
def test_pieces_of_strangers_keep_little_and_are_joined_or_refused(pieces):
    joined = JoinedText()
    for head, text in pieces:
        try:
            whole = joined.take(head + text)
        except NotUnderstood as refused:
            assert refused.hopeless
            continue
        assert whole is None or len(whole) <= max(LONGEST, len(text))
        assert len(joined._text or "") <= LONGEST
