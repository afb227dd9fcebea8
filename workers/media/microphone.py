"""A robot's microphone: whatever FFmpeg reads, as pieces of one length. Only a thread that listens loads PyAV."""

import contextlib
import os
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from robots.kit import addresses
from robots.kit.clock import SYSTEM
from robots.kit.contract.sound import RATE
from robots.kit.opening import why_not

TIMEOUT_S = 2.0  # for opening, and between two pieces
PIECE_MS = 60
PIECE = RATE * PIECE_MS // 1000  # samples
BIT_RATE = 24_000
BROKEN = 20  # pieces one after another that cannot be decoded
SILENT = "The robot's microphone does not answer."
# a list of addresses (HLS, concat) would be opened unchecked
FORMATS = "wav,w64,aiff,au,flac,ogg,mp3,aac,adts,matroska,webm,mpegts,mov,mp4,rtsp,sdp,alsa"
ALSA = "/usr/share/alsa/alsa.conf"  # of the host: PyAV's own library would look in a folder under /tmp
PROTOCOLS = "http,https,tcp,tls,crypto,rtp,rtsp,rtsps,udp"


class MicrophoneFault(Exception):
    """Nothing can be heard; the message says why, for everybody who listens."""


def place_of(address: str, rig: Path) -> tuple[str, str | None, dict[str, str]]:
    """Return what FFmpeg opens: a place, its format if it must be said, and options. Raises MicrophoneFault."""
    try:
        addresses.check_microphone(address)
        if address == addresses.SIMULATED:
            address = (rig / "microphone").read_text().strip()
        if address.startswith("alsa:"):
            os.environ.setdefault("ALSA_CONFIG_PATH", ALSA)
            return address.removeprefix("alsa:"), "alsa", {"sample_rate": str(RATE)}
        parts = urlsplit(address)
        addresses.check_resolved(parts.hostname or "", parts.port or 80)
    except addresses.AddressError as error:
        raise MicrophoneFault(str(error)) from error
    except OSError as error:
        raise MicrophoneFault("The simulated microphone has not started yet.") from error
    options = {
        "format_whitelist": FORMATS, "protocol_whitelist": PROTOCOLS, "fflags": "nobuffer",
        "probesize": "65536", "analyzeduration": "500000",
    }  # fmt: skip
    return address, None, options | (addresses.http_options(parts.scheme) or {"rtsp_transport": "tcp"})


class Microphone:
    """An opened microphone; its pieces are frames of `PIECE` samples, one channel, 48 kHz."""

    def __init__(self, address: str, rig: Path) -> None:
        """Open it. Raises MicrophoneFault."""
        import av  # noqa: PLC0415 - 15 MB that an owner needs only while somebody listens

        self._av: Any = av
        place, form, options = place_of(address, rig)
        begun = SYSTEM.monotonic()
        try:
            self._source = av.open(place, format=form, options=options, timeout=(TIMEOUT_S, TIMEOUT_S))
        except (av.FFmpegError, OSError, ValueError) as error:
            late = SYSTEM.monotonic() - begun >= TIMEOUT_S
            told = why_not(error, place if form == "alsa" else "", late)
            raise MicrophoneFault(f"{SILENT.rstrip('.')}: {told}") from error
        if not self._source.streams.audio:
            self.close()
            raise MicrophoneFault("There is no sound at the address of the robot's microphone.")

    def pieces(self) -> Iterator[Any]:
        """Yield what is heard, as it comes. Raises MicrophoneFault when it ends."""
        even = self._av.AudioResampler(format="s16", layout="mono", rate=RATE, frame_size=PIECE)
        broken = 0
        try:
            for packet in self._source.demux(self._source.streams.audio[0]):
                try:
                    heard = packet.decode()
                    broken = 0
                except self._av.InvalidDataError:
                    heard, broken = [], broken + 1
                    if broken >= BROKEN:
                        raise
                for frame in heard:
                    yield from even.resample(frame)
        except (self._av.FFmpegError, OSError, ValueError) as error:
            raise MicrophoneFault(SILENT) from error
        raise MicrophoneFault("The robot's microphone has ended its sound.")

    def close(self) -> None:
        """Release it."""
        with contextlib.suppress(Exception):
            self._source.close()


class Encoder:
    """Opus at about 24 kbit/s, one packet a piece."""

    def __init__(self) -> None:
        """Raises MicrophoneFault where this host has no encoder."""
        import av  # noqa: PLC0415 - see Microphone

        try:
            self._made: Any = av.CodecContext.create("libopus", "w")
            self._made.sample_rate, self._made.layout, self._made.format = RATE, "mono", "s16"
            self._made.bit_rate = BIT_RATE
            self._made.options = {"frame_duration": str(PIECE_MS), "compression_level": "5"}
            self._made.open()
        except (av.FFmpegError, ValueError) as error:
            raise MicrophoneFault("The robot's host cannot encode sound.") from error
        self._count = 0

    def encode(self, piece: Any) -> bytes:
        """Return Opus' bytes of the next piece; empty if there are none yet. Raises av.FFmpegError."""
        piece.pts, piece.time_base = self._count * PIECE, Fraction(1, RATE)
        self._count += 1
        return b"".join(bytes(packet) for packet in self._made.encode(piece))
