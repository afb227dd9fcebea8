"""The origin: sends one movie at a time, or none, and answers the repair requests of edges."""

from collections.abc import Callable

from portal.broadcast import packets
from portal.broadcast.answers import Answer, Headers, as_json, nothing
from portal.broadcast.carousel import Carousel
from portal.broadcast.media import Movie
from portal.broadcast.repairs import Repairs
from portal.broadcast.running import Line, Sending, now_ns
from portal.broadcast.timetable import bytes_a_second

REPAIRS = 10  # times the movie's rate
HEADERS = packets.DATAGRAM - packets.PAYLOAD + packets.UDP_IP


class Origin:
    """Sends a movie while `run` runs. `number` returns the number of a movie's first packet, greater at each call."""

    def __init__(self, key: bytes, line: Line, wait_ds: int, number: Callable[[], int]) -> None:
        self._key, self._wait_ds, self._number = key, wait_ds, number
        self._sending = Sending(None, line)
        self._repairs: Repairs | None = None

    def show(self, movie: Movie) -> Carousel:
        """Send this movie from now on."""
        made = Carousel(self._key, movie.contents, movie.starts_ns, self._wait_ds, now_ns(), self._number())
        self._sending.carousel = made
        self._repairs = Repairs(made, self._key, REPAIRS * movie.rate, now_ns)
        return made

    def rest(self) -> None:
        """Send nothing."""
        self._sending.carousel = self._repairs = None

    def answer(self, path: str, headers: Headers) -> Answer:
        """Answer an edge."""
        if self._repairs is not None:
            return self._repairs.answer(path, headers)
        return as_json({"movie": None}) if path == "/status.json" else nothing()

    async def run(self) -> None:
        """Send."""
        await self._sending.run()


def words(movie: Movie, sent: Carousel) -> str:
    """Return in words how long a movie is and what rate it takes to send it."""
    rate = float(bytes_a_second(sent.channels, HEADERS))
    return (
        f"{movie.seconds:.0f} s in {len(movie.contents) - 1} segments, {movie.rate / 1000:.0f} kB/s; "
        f"broadcast {rate / 1000:.0f} kB/s with headers, {rate / movie.rate:.2f} times, for any number of edges"
    )
