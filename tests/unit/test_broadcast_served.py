"""What edges answer browsers and origins answer edges, and what a file becomes."""

from fractions import Fraction
from io import BytesIO

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.broadcast import media, multicast, repairs
from portal.broadcast.answers import Answer
from portal.broadcast.assembly import Gap
from portal.broadcast.media import NoMovie
from portal.broadcast.serving import Serving
from portal.broadcast.timetable import SECOND
from tests.broadcasting import KEY, Air, movie

ORIGIN = Air(movie(2))


@pytest.fixture
def air():
    return Air(movie())


def ask(air, edge, path):
    return Serving(edge, lambda: air.now_ns).answer(path, {})


def test_a_player_is_told_what_is_there_from_the_beginning_on_and_never_too_early(air):
    edge = air.join()
    assert ask(air, edge, "/index.m3u8").status == 503  # nothing was heard yet
    air.go(1.96)
    assert edge.current.playable > 0
    assert ask(air, edge, "/index.m3u8").status == 503  # the rest would not follow in time
    air.go(1.96)
    assert ask(air, edge, "/index.m3u8").status == 503  # players look for more once a second
    air.go(0.1)
    first = ask(air, edge, "/index.m3u8")
    assert first.headers["content-type"] == "application/vnd.apple.mpegurl"
    place = first.body.decode().splitlines()[-1]
    assert 'CODECS="avc1.64000d"' in first.body.decode()
    growing = ask(air, edge, f"/{place}")
    listed = [line for line in growing.body.decode().splitlines() if line.startswith("seg-")]
    assert listed == [f"seg-{n + 1}.m4s" for n in range(edge.current.playable)] != []
    assert b"ENDLIST" not in growing.body
    assert growing.headers["cache-control"] == "max-age=1"
    air.go(5)
    whole = ask(air, edge, f"/{place}").body.decode()
    assert whole.count("#EXTINF:0.500,") == 12
    assert whole.endswith("seg-12.m4s\n#EXT-X-ENDLIST\n")


@pytest.mark.parametrize(
    ("title", "told"), [("Rover, 3 June 2026", "Rover, 3 June 2026"), ('A "b"\n#EXT\x7f' + "x" * 300, "A b#EXT" + "x" * 193), ("", None)]
)  # fmt: skip
def test_the_playlist_tells_the_title(tmp_path, title, told):
    air = Air(media.cut(film(tmp_path / "day.mp4"), 500, title))
    edge = air.join()
    air.go(9)
    lines = ask(air, edge, "/index.m3u8").body.decode().splitlines()
    data = f'#EXT-X-SESSION-DATA:DATA-ID="org.farhand.title",VALUE="{told}"'
    assert [one for one in lines if "SESSION" in one] == ([] if told is None else [data])


def test_segments_are_the_file_and_may_be_kept_by_any_cache(air):
    edge = air.join()
    air.go(9)
    name = f"{edge.current.movie:08x}"
    for n, content in enumerate(air.movie.contents[1:], 1):
        answer = ask(air, edge, f"/{name}/seg-{n}.m4s")
        assert answer.body == content
        assert answer.headers["cache-control"] == "public, max-age=3600, immutable"
    assert ask(air, edge, f"/{name}/init.mp4").body == air.movie.index.init


def test_a_segment_that_is_not_whole_is_not_served(air):
    edge = air.join()
    air.go(1)
    name, open_segments = f"{edge.current.movie:08x}", [n for n, one in edge.current.segments.items() if not one.whole]
    assert open_segments
    answers = [ask(air, edge, f"/{name}/seg-{n}.m4s") for n in open_segments]
    assert {(one.status, one.headers["cache-control"]) for one in answers} == {(404, "max-age=1")}


def test_the_movie_before_is_shown_until_the_new_one_can_be(air):
    edge = air.join()
    air.go(9)
    before = f"{edge.current.movie:08x}"
    air.broadcast(movie(seed=9))
    air.go(1)
    assert before in ask(air, edge, "/index.m3u8").body.decode()
    assert ask(air, edge, f"/{before}/movie.m3u8").body.decode().endswith("#EXT-X-ENDLIST\n")
    air.go(3.5)
    assert before not in ask(air, edge, "/index.m3u8").body.decode()


@pytest.mark.parametrize(
    "path", ["", "/x", "/../settings.py", "/00000000/seg-1.m4s", "/{}/seg-0.m4s", "/{}/seg-13.m4s", "/{}/seg-1", "//{}/init.mp4"]
)  # fmt: skip
def test_other_addresses_lead_nowhere(air, path):
    edge = air.join()
    air.go(9)
    assert ask(air, edge, path.format(f"{edge.current.movie:08x}")).status == 404


def test_the_player_comes_with_a_policy(air):
    edge = air.join()
    page, script, style = ask(air, edge, "/"), ask(air, edge, "/player.js"), ask(air, edge, "/player.css")
    assert b"player.js" in page.body
    assert "default-src 'self'" in page.headers["content-security-policy"]
    assert script.headers["content-type"].startswith("text/javascript")
    assert style.headers["content-type"].startswith("text/css")


def gap(begin=10, end=20, segment=1):
    return Gap(segment, begin, end, 0)


def answered(air, one):
    return air.origin.answer(repairs.path_of(air.carousel.movie, one), {"range": repairs.range_of(one)})


def test_a_gap_is_answered_and_taken(air):
    one = gap()
    content = air.movie.contents[1]
    assert repairs.verify(KEY, air.carousel.movie, one, answered(air, one)) == (content[10:20], len(content))
    unknown = gap(0, 0)
    assert repairs.verify(KEY, air.carousel.movie, unknown, answered(air, unknown)) == (content, len(content))


@given(st.text(max_size=30), st.one_of(st.text(max_size=30), st.integers(0, 10**7).map(lambda n: f"bytes={n}-")))
def test_the_origin_answers_whatever_is_asked(path, wanted):
    air = ORIGIN
    for place in (path, f"/{air.carousel.movie:08x}/{path}", f"/{air.carousel.movie:08x}/1"):
        assert air.origin.answer(place, {"range": wanted}).status in (200, 206, 404, 416)


@pytest.mark.parametrize(
    ("one", "status"), [(gap(segment=13), 404), (gap(10**6, 10**6 + 1), 416), (gap(20, 10), 416), (gap(0, 10**7), 206)]
)
def test_gaps_out_of_bounds(air, one, status):
    assert answered(air, one).status == status


def test_an_answer_that_is_not_the_origins_or_not_of_this_place_is_not_taken(air):
    one = gap()
    good, number = answered(air, one), air.carousel.movie
    changed = Answer(206, good.body[:-1] + b"!", good.headers)
    assert repairs.verify(KEY, number, one, changed) is None
    assert repairs.verify(KEY, number, gap(11, 20), good) is None
    assert repairs.verify(KEY, number, gap(segment=2), good) is None
    assert repairs.verify(KEY, number + 1, one, good) is None
    assert repairs.verify(KEY, number, one, Answer(200, good.body, good.headers)) is None
    assert repairs.verify(KEY, number, one, Answer(206, good.body[:-1], good.headers)) is None
    assert repairs.verify(KEY, number, one, Answer(206, good.body, {})) is None


def test_repairs_have_a_rate(air):
    origin = repairs.Repairs(air.carousel, KEY, 1000, lambda: air.now_ns)
    path, size = repairs.path_of(air.carousel.movie, gap()), len(air.movie.contents[1])
    statuses = [origin.answer(path, {}).status for _ in range(10)]
    assert statuses[0] == 206
    assert statuses[-1] == 503
    assert origin.bytes_sent <= 1000 * repairs.SAVED_S + size
    air.now_ns += 10 * SECOND
    assert origin.answer(path, {}).status == 206


def test_who_gets_no_answer_asks_again_after_a_pause(air):
    air.repairing = False
    edge = air.join(0.3)
    air.go(3)
    asked = [len(edge.requests_due(air.now_ns + ms * 10**6, 1000)) for ms in range(0, 1000, 20)]
    assert asked[0] > 0
    assert sum(asked) <= 3 * asked[0] + 60  # each at most each half second, and not at each look


def film(path, seconds=5, codec="libx264", gap_ms=200):
    numbers = np.random.default_rng(1)
    with av.open(str(path), "w", format="mp4") as out:
        stream = out.add_stream(codec, rate=5)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 1000)
        for n in range(seconds * 1000 // gap_ms):
            picture = av.VideoFrame.from_ndarray(numbers.integers(0, 255, (48, 64, 3), np.uint8), "rgb24")
            picture = picture.reformat(format="yuv420p")
            picture.pts, picture.time_base = n * gap_ms, Fraction(1, 1000)
            out.mux(stream.encode(picture))
        out.mux(stream.encode())
    return path


def pictures(file):
    with av.open(file) as opened:
        return [picture.to_ndarray().tobytes() for picture in opened.decode(video=0)]


@pytest.mark.parametrize(("seconds", "gap_ms"), [(5, 200), (17, 1700)])
def test_the_segments_of_a_file_show_its_pictures(tmp_path, seconds, gap_ms):
    path = film(tmp_path / "day.mp4", seconds, gap_ms=gap_ms)
    made = media.cut(path, 1000)
    starts, durations = made.index.starts_ms, made.index.durations_ms
    assert starts[0] == 0
    assert [start + long for start, long in zip(starts, durations, strict=True)][:-1] == starts[1:]
    assert made.seconds == pytest.approx(seconds, abs=1.8)
    assert made.index.codec.startswith("avc1.")
    for start, content in zip(starts, made.contents[1:], strict=True):
        with av.open(BytesIO(made.index.init + content)) as one:
            first = next(one.demux(video=0))
            assert int(1000 * first.dts * first.time_base) == start  # each says by itself when it is shown
    assert pictures(BytesIO(made.index.init + b"".join(made.contents[1:]))) == pictures(str(path))


@pytest.mark.parametrize("content", [b"", b"no movie at all", b"\0\0\0\x18ftypmp42" + b"\0" * 100], ids=len)
def test_what_is_no_movie_is_refused_with_a_reason(tmp_path, content):
    (tmp_path / "day.mp4").write_bytes(content)
    with pytest.raises(NoMovie, match="no movie that can be broadcast"):
        media.cut(tmp_path / "day.mp4", 1000)


def test_a_file_that_was_cut_off_and_one_that_browsers_do_not_show_are_refused(tmp_path):
    whole = film(tmp_path / "day.mp4").read_bytes()
    (tmp_path / "part.mp4").write_bytes(whole[: len(whole) // 2])
    film(tmp_path / "other.mp4", codec="mpeg4")
    for name in ("part.mp4", "other.mp4"):
        with pytest.raises(NoMovie):
            media.cut(tmp_path / name, 1000)


@pytest.mark.parametrize(
    "told", ["", "239.1.1.1", "10.0.0.1:5004", "239.1.1.1:0", "239.1.1.1:70000", "x:5004", "239.1.1.1:-1"]
)
def test_what_is_no_group_is_refused(told):
    with pytest.raises(ValueError, match="multicast"):
        multicast.group_of(told)
