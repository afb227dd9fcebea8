"""Answers of an edge to browsers: the player, playlists, and segments that any cache may keep."""

import re
from collections.abc import Callable
from pathlib import Path

from portal.broadcast.answers import Answer, Headers, as_json, later, nothing, text
from portal.broadcast.assembly import Assembly
from portal.broadcast.edge import Edge
from portal.broadcast.index import Index
from portal.broadcast.timetable import SECOND

HERE = Path(__file__).parent
PLAYER = {
    "/": ("player.html", "text/html; charset=utf-8"), "/player.js": ("player.js", "text/javascript; charset=utf-8"),
    "/player.css": ("player.css", "text/css; charset=utf-8"),
}  # fmt: skip
NEVER_CHANGES = "public, max-age=3600, immutable"  # the address names the content; kept for an hour, as the movie is
PLAYLIST = "application/vnd.apple.mpegurl"  # of HTTP Live Streaming (RFC 8216)
VERSION = "#EXTM3U\n#EXT-X-VERSION:7\n"
PLAYERS_NS = 2 * SECOND  # players look for new segments about once a second, and have to fetch them
GROWING, WHOLE = "max-age=1", "max-age=10"
POLICY = "default-src 'self'; media-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'none'"
PLACE = re.compile(r"/([0-9a-f]{8})/(?:(movie\.m3u8)|(init\.mp4)|seg-([1-9][0-9]{0,3})\.m4s)")


class Serving:
    """Answers browsers from the segments that the edge has."""

    def __init__(self, edge: Edge, now_ns: Callable[[], int]) -> None:
        self._edge, self._now_ns = edge, now_ns
        self._player = {path: ((HERE / name).read_text(), kind) for path, (name, kind) in PLAYER.items()}

    def answer(self, path: str, _: Headers) -> Answer:
        """Answer a request."""
        if path in self._player:
            page = text(*self._player[path], "max-age=60")
            return Answer(200, page.body, {**page.headers, "content-security-policy": POLICY})
        if path == "/status.json":
            return as_json(self._edge.status())
        if path == "/index.m3u8":
            return self._begin()
        place = PLACE.fullmatch(path)
        movie = self._edge.find(int(place[1], 16)) if place else None
        if place is None or movie is None or movie.index is None:
            return nothing()
        if place[2]:
            ended = movie is not self._edge.current
            kept = WHOLE if ended or movie.playable == movie.count else GROWING
            return text(media_playlist(movie, movie.index, ended), PLAYLIST, kept)
        if place[3]:
            return self._bytes(movie.index.init, "video/mp4")
        return self._segment(movie, int(place[4]))

    def _begin(self) -> Answer:
        """Return the first playlist, as soon as each segment of the movie will be there when players need it."""
        movie = self._edge.current
        if not (movie and movie.playable and self._now_ns() >= movie.joined_ns + movie.wait_ns + PLAYERS_NS):
            movie = self._edge.before  # a new one begins: the one before is shown until then
        if movie is None or movie.index is None or not movie.playable:
            return later(1)
        return text(multivariant_playlist(movie, movie.index), PLAYLIST, GROWING)

    def _segment(self, movie: Assembly, number: int) -> Answer:
        segment = movie.segments.get(number)
        if segment is None or not segment.whole or number > movie.count:
            return nothing()
        return self._bytes(bytes(segment.data), "video/iso.segment")

    @staticmethod
    def _bytes(body: bytes, kind: str) -> Answer:
        return Answer(200, body, {"content-type": kind, "cache-control": NEVER_CHANGES})


def multivariant_playlist(movie: Assembly, index: Index) -> str:
    """Return the playlist that players begin with: it leads to the movie that is broadcast now."""
    durations = index.durations_ms
    known = [(len(one.data), durations[n - 1]) for n, one in movie.segments.items() if 0 < n <= len(durations)]
    peak = max((size * 8000 // max(1, duration) for size, duration in known), default=1)
    stream = f'#EXT-X-STREAM-INF:BANDWIDTH={peak},CODECS="{index.codec}"\n'
    title = f'#EXT-X-SESSION-DATA:DATA-ID="org.farhand.title",VALUE="{index.title}"\n' if index.title else ""
    return f"{VERSION}{title}{stream}{movie.movie:08x}/movie.m3u8\n"


def media_playlist(movie: Assembly, index: Index, ended: bool) -> str:
    """Return the playlist of the segments that are there, from the first one on.

    It grows at least as fast as the movie is shown, so that a player that begins at the beginning never waits. `ended`:
    no more will come.
    """
    lines = [
        f"{VERSION}#EXT-X-TARGETDURATION:{max(1, round(max(index.durations_ms) / 1000))}", "#EXT-X-PLAYLIST-TYPE:EVENT",
        "#EXT-X-START:TIME-OFFSET=0,PRECISE=YES", '#EXT-X-MAP:URI="init.mp4"',
    ]  # fmt: skip
    if index.independent:
        lines.insert(1, "#EXT-X-INDEPENDENT-SEGMENTS")
    for number in range(1, movie.playable + 1):
        lines += [f"#EXTINF:{index.durations_ms[number - 1] / 1000:.3f},", f"seg-{number}.m4s"]
    if ended or movie.playable == movie.count:
        lines.append("#EXT-X-ENDLIST")
    return "\n".join(lines) + "\n"
