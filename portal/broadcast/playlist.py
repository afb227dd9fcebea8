"""HTTP Live Streaming playlists (RFC 8216) of a movie that an edge has, or is getting."""

from portal.broadcast.assembly import Assembly
from portal.broadcast.index import Index

VERSION = "#EXTM3U\n#EXT-X-VERSION:7\n"


def multivariant(movie: Assembly, index: Index) -> str:
    """Return the playlist that players begin with: it leads to the movie that is broadcast now."""
    durations = index.durations_ms
    known = [(len(one.data), durations[n - 1]) for n, one in movie.segments.items() if 0 < n <= len(durations)]
    peak = max((size * 8000 // max(1, duration) for size, duration in known), default=1)
    stream = f'#EXT-X-STREAM-INF:BANDWIDTH={peak},CODECS="{index.codec}"\n'
    title = f'#EXT-X-SESSION-DATA:DATA-ID="org.farhand.title",VALUE="{index.title}"\n' if index.title else ""
    return f"{VERSION}{title}{stream}{movie.movie:08x}/movie.m3u8\n"


def media(movie: Assembly, index: Index, ended: bool) -> str:
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
