"""A microphone's address may lead to real sound of any rate, and to everything else that answers there."""

import io
import threading
import time
import wave
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import islice

import av
import numpy as np
import pytest

from workers.media.microphone import BIT_RATE, PIECE, RATE, Encoder, Microphone, MicrophoneFault

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

HZ = 440.0


def tone(seconds=2.0, rate=44_100, channels=2):
    out = io.BytesIO()
    with wave.open(out, "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(2)
        file.setframerate(rate)
        samples = (8000 * np.sin(2 * np.pi * HZ * np.arange(int(seconds * rate)) / rate)).astype("<i2")
        file.writeframes(np.repeat(samples[:, None], channels, 1).tobytes())
    return out.getvalue()


def opus():
    """Return the tone as an endless radio would send it: Opus in Ogg."""
    out = io.BytesIO()
    with av.open(io.BytesIO(tone(rate=48_000, channels=1))) as heard, av.open(out, "w", format="ogg") as made:
        stream = made.add_stream("libopus", rate=48_000)
        for frame in heard.decode(audio=0):
            for packet in stream.encode(frame):
                made.mux(packet)
        for packet in stream.encode(None):
            made.mux(packet)
    return out.getvalue()


@pytest.fixture
def network():
    """A server; `answers` by path, `asked` what was asked of it."""
    answers, asked = {}, []

    class Handler(BaseHTTPRequestHandler):
        def log_message(self, *args):
            pass

        def do_GET(self):
            asked.append(self.path)
            status, body = answers[self.path]
            self.send_response(status)
            if body is not None:
                self.send_header("Content-Length", str(len(body)))
            if status == 302:
                self.send_header("Location", body.decode())
            self.end_headers()
            if body is None:
                time.sleep(4)
                return
            self.wfile.write(body)

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
    server.at, server.answers, server.asked = f"http://127.0.0.1:{server.server_address[1]}", answers, asked
    yield server
    server.shutdown()
    server.server_close()


def pitch(pieces):
    samples = np.concatenate([piece.to_ndarray().ravel() for piece in pieces]).astype(float)
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(samples.size)))
    return np.argmax(spectrum) * RATE / samples.size


@pytest.mark.parametrize("body", [
    tone(), tone(8.0, rate=8000, channels=1), tone(rate=96_000), opus(),
], ids=["WAV", "slow WAV", "fast WAV", "Opus"])  # fmt: skip
def test_whatever_the_rate_pieces_are_of_one_length_and_sound_the_same(network, tmp_path, body):
    network.answers["/live"] = (200, body)
    microphone = Microphone(f"{network.at}/live", tmp_path)
    pieces = list(islice(microphone.pieces(), 25))
    microphone.close()
    assert {(piece.samples, piece.sample_rate, len(piece.layout.channels)) for piece in pieces} == {(PIECE, RATE, 1)}
    assert pitch(pieces) == pytest.approx(HZ, abs=2)
    encoder = Encoder()
    packets = [encoder.encode(piece) for piece in pieces]
    assert all(packets), "one packet a piece, none late"
    assert sum(map(len, packets)) * 8 / (len(packets) * PIECE / RATE) < 1.5 * BIT_RATE


def test_the_end_of_the_sound_is_told(network, tmp_path):
    network.answers["/live"] = (200, tone(0.5))
    with pytest.raises(MicrophoneFault, match="ended"):
        list(Microphone(f"{network.at}/live", tmp_path).pieces())


@pytest.mark.asvs("1.3.6", "15.3.2")
def test_what_is_no_sound_is_refused_and_leads_nowhere_else(network, tmp_path):
    inner = f"{network.at}/inner.wav"
    network.answers |= {
        "/rubbish": (200, np.random.default_rng(1).bytes(100_000)), "/nothing": (200, b""), "/gone": (404, b"no"),
        "/silent": (200, None), "/inner.wav": (200, tone()), "/moved": (302, inner.encode()),
        "/list.m3u8": (200, f"#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\n{inner}\n#EXT-X-ENDLIST\n".encode()),
        "/concat": (200, f"ffconcat version 1.0\nfile '{inner}'\n".encode()),
    }  # fmt: skip
    for path in network.answers.keys() - {"/inner.wav"}:
        began = time.monotonic()
        with pytest.raises(MicrophoneFault):
            list(Microphone(f"{network.at}{path}", tmp_path).pieces())
        assert time.monotonic() - began < 6
    assert "/inner.wav" not in network.asked


@pytest.mark.asvs("1.3.6", "15.3.2")
@pytest.mark.parametrize("address", ["http://169.254.169.254/x.wav", "file:///etc/passwd", "alsa:file:/etc/passwd"])
def test_an_address_that_was_not_checked_before_is_checked_now(tmp_path, address):
    with pytest.raises(MicrophoneFault):
        Microphone(address, tmp_path)


def test_a_simulated_microphone_that_has_not_started_is_waited_for(tmp_path):
    with pytest.raises(MicrophoneFault, match="not started"):
        Microphone("sim:microphone", tmp_path)


def test_a_device_of_this_machine_is_read(tmp_path, monkeypatch):
    config = tmp_path / "alsa.conf"
    config.write_text("pcm.default { type null }\n")  # a device that hears nothing, at once
    monkeypatch.setenv("ALSA_CONFIG_PATH", str(config))
    microphone = Microphone("alsa:default", tmp_path)
    assert [piece.samples for piece in islice(microphone.pieces(), 5)] == [PIECE] * 5
    microphone.close()
