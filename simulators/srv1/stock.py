"""The stock firmware of March 2011, letter by letter, with the answers that its source has (`main.c`, `srv.c`).

Not here: C programs, neural nets, the editor, web pages, GPS; their letters take their arguments and say nothing.
"""

from collections.abc import Callable

from robots.kit.clock import Limit, Lock, Timer
from robots.kit.drivers.srv1.protocol import CHANNELS, DURATION_S, METRES_A_PING, UNKNOWN
from simulators.srv1.flash import Flash
from simulators.srv1.hardware import Hardware
from simulators.srv1.imaging import Imaging
from simulators.srv1.motors import Motors
from simulators.srv1.uart import Uart

VERSION = b"##Version - SRV-1 Blackfin w/PicoC 2.1 built:18:55:21 - Mar  5 2011\r\n"
AUTORUN = b"##checking for autorun() in flash sect#4 ... no autorun() found\r\n"
PING_S, ENCODERS_S, COMPASS_S, LASERS_S = 0.04, 0.04, 0.02, 0.75
LOW_V = 6.8
NO_CHANNEL = 0xFFFF
SIDES, BRIGHTNESSES = (b"right", b"left"), range(200, 0, -10)  # with which it looks for a spot of its lasers
REQUEST_S, MOST_REQUEST = 1.0, 4096  # of a request for a web page
REQUEST_ENDS = b"\r\n\r\n", b"\r\r", b"\n\n"
OTHERS = {"s": 2}  # what takes so many bytes and is confirmed by its letter
DIFFERENCES = {"0": b"##g0", "1": b"##g1", "2": b"##g2", "3": b"##g3", "4": b"##g4"}
I2C = {"r": (2, b"##ir%2x 0\r\n"), "R": (2, b"##iR%2x 0\r\n"), "w": (3, b"##iw%2x\r\n"), "W": (4, b"##iW%2x"),
       "d": (5, b"##id%2x"), "M": (3, b"##iM%2x  ")}  # fmt: skip
RESET = "!"


class Reset(Exception):
    """A client has asked the processor to start anew."""


class Stock:
    """`send` takes the answers. All waiting is in `uart`, whose exceptions are not caught here."""

    def __init__(
        self, hardware: Hardware, lock: Lock, uart: Uart, motors: Motors, flash: Flash, send: Callable[[bytes], None],
        clock: Timer,
    ) -> None:  # fmt: skip
        self._hardware, self._lock, self._uart, self._motors, self._flash = hardware, lock, uart, motors, flash
        self._send, self._clock = send, clock
        self._imaging = Imaging(hardware, uart, clock)
        self._began = clock.monotonic()
        argument = uart.argument
        self._letters: dict[str, Callable[[], bytes]] = {
            "D": self._battery, "p": self._ping, "R": self._lasers, "r": self._lasers_in_words,
            "V": lambda: VERSION, "t": self._time, "$": self._prototype, "g": self._difference, "i": self._i2c,
            "M": self._do(lambda: motors.move(argument), b"#M"), "S": self._do(lambda: motors.servos(argument), b"#S"),
            "F": self._do(lambda: motors.set_failsafe(argument), b"#F"), "f": self._no_failsafe,
            "X": lambda: flash.receive(uart.byte, send), "z": lambda: flash.do(argument),
            "<": bytes, ">": bytes, "J": self._planes, "n": self._silent(1), "m": self._other_motors,
            "x": self._other_board, "G": lambda: self._request(b"G"), "P": lambda: self._request(b"P"),
            "+": self._do(motors.faster, b"#+"), "-": self._do(motors.slower, b"#-"),
        }  # fmt: skip
        self._letters |= {letter: self._silent(0) for letter in "|Q!E"}
        self._letters |= {letter: self._key(letter) for letter in "0123456789."}
        self._letters |= {letter: self._acknowledged(letter, OTHERS.get(letter, 0)) for letter in "lLoOs"}
        self._letters |= self._imaging.letters

    def restart(self) -> None:
        """Begin as at power on."""
        self._began = self._clock.monotonic()
        self._imaging.restart()
        self._motors.restart()

    def do(self, letter: str) -> None:
        """Execute a letter with the arguments that follow it. Raises Interrupted, Reset, Stopped."""
        function = self._letters.get(letter)
        answer = UNKNOWN if function is None else function()
        if answer:
            self._send(answer)

    # functions for the table

    def _do(self, function: Callable[[], None], answer: bytes) -> Callable[[], bytes]:
        def do() -> bytes:
            function()
            return answer

        return do

    def _silent(self, arguments: int) -> Callable[[], bytes]:
        return self._do(lambda: self._swallow(arguments), b"")

    def _acknowledged(self, letter: str, arguments: int) -> Callable[[], bytes]:
        return self._do(lambda: self._swallow(arguments), b"#" + letter.encode())

    def _key(self, letter: str) -> Callable[[], bytes]:
        return self._do(lambda: self._motors.keypad(letter), b"#" + letter.encode())

    def _swallow(self, arguments: int) -> None:
        for _ in range(arguments):
            self._uart.argument()

    # functions of single letters

    def _planes(self) -> bytes:
        return b"P5\n80\n192\n255\n" + bytes(80 * 64 * 3)

    def _battery(self) -> bytes:
        with self._lock:
            low = self._hardware.battery() < LOW_V
        return b"##D - low battery voltage detected\r\n" if low else b"##D - battery voltage okay\r\n"

    def _ping(self) -> bytes:
        self._uart.delay(PING_S)
        with self._lock:
            metres = self._hardware.sonar()
        return b"##ping %d 0 0 0\r\n" % round(metres / METRES_A_PING)

    def _lasers(self) -> bytes:
        """Return the distance where no spot of a laser is seen, which the firmware works out as six times the width."""
        self._motors.keypad("5")
        self._uart.delay(LASERS_S)
        return b"##Range(cm) = %d\r\n" % (6 * self._imaging.size.width)

    def _lasers_in_words(self) -> bytes:
        size, answer = self._imaging.size, self._lasers()
        nothing = b" ".join(b" 0 %d 0 %d 0" % (size.width, size.height) for _ in range(3))
        looks = (
            b"%b blobs: ymin=%d  %b\r\n" % (side, y, nothing) for side in (b"right", b"left") for y in BRIGHTNESSES
        )
        return b"".join(looks) + b"lconf 0 lrange %d rconf 0 rrange %d\r\n" % ((6 * size.width,) * 2) + answer

    def _other_motors(self) -> bytes:
        """Wait as long as motors would run that this rover does not have."""
        *_, duration = [self._uart.argument() for _ in range(3)]
        self._uart.delay(duration * DURATION_S)
        return b"#m"

    def _other_board(self) -> bytes:
        self._send(b"#x")  # before it reads the arguments
        self._swallow(2)
        return b""

    def _request(self, seen: bytes) -> bytes:
        """Read a request for a web page until an empty line, or for a second; one that sends a file until a silence."""
        limit, posts = Limit(self._clock, REQUEST_S), seen == b"P"
        while posts or (len(seen) < MOST_REQUEST and not seen.endswith(REQUEST_ENDS)):
            byte = self._uart.byte(max(0.0, limit.remaining))
            if byte is None:
                break
            if posts:
                limit = Limit(self._clock, REQUEST_S)
            else:
                seen += bytes((byte,))
        return b""

    def _time(self) -> bytes:
        return b"##time - millisecs:  %d\r\n" % int((self._clock.monotonic() - self._began) * 1000)

    def _no_failsafe(self) -> bytes:
        self._motors.failsafe = None
        return b"#f"

    def _difference(self) -> bytes:
        letter = chr(self._uart.argument())
        if letter == "6":
            digit = chr(self._uart.argument())
            return b"##g6 bin# %x\r\n" % (int(digit) if digit in "0123456789" else 0)
        return DIFFERENCES.get(letter, b"#g_")

    def _i2c(self) -> bytes:
        letter = chr(self._uart.argument())
        if letter not in I2C:
            return b""
        arguments, answer = I2C[letter]
        device, *_, last = [self._uart.argument() for _ in range(arguments)]
        return answer % device + (b"0 " * (last & 15) + b"\r\n" if letter == "M" else b"")

    def _prototype(self) -> bytes:
        letter = chr(self._uart.argument())
        if letter == RESET:
            raise Reset
        kinds = {"A": self._analogue, "E": self._rates, "C": self._compass, "a": self._board_analogue,
                 "e": self._board_encoder, "c": self._axes, "T": self._tilt}  # fmt: skip
        return kinds[letter]() if letter in kinds else b""

    def _digit(self) -> int:
        return self._uart.argument() & 15

    def _counts(self, channel: int) -> int:
        with self._lock:
            return self._hardware.analogue(channel)

    def _analogue(self) -> bytes:
        channel = self._digit() * 10 + self._digit()
        return b"##$A%d %04d\r\n" % (channel, self._counts(channel) if channel in CHANNELS else NO_CHANNEL)

    def _board_analogue(self) -> bytes:
        channel = self._digit()
        return b"##$a%d %04d\r\n" % (channel, self._counts(channel))

    def _encoders(self) -> tuple[int, int]:
        with self._lock:
            return self._hardware.encoders()

    def _rates(self) -> bytes:
        """Return pulses a second, counted for 40 ms; fewer than three edges count as none, and there is no sign."""
        before = self._encoders()
        self._uart.delay(ENCODERS_S)
        counts = [abs(new - old) for new, old in zip(self._encoders(), before, strict=True)]
        left, right = (round(n / ENCODERS_S) if n > 1 else 0 for n in counts)
        return b"##$Encoders:  left = %d  right = %d\r\n" % (left, right)

    def _board_encoder(self) -> bytes:
        channel = self._digit()
        return b"##$e%d %05d\r\n" % (channel, self._encoders()[channel % 2] & 0xFFFF)

    def _degrees(self) -> int:
        self._uart.delay(COMPASS_S)
        with self._lock:
            return int(self._hardware.compass()) % 360

    def _compass(self) -> bytes:
        return b"##$C %3d\r\n" % self._degrees()

    def _axes(self) -> bytes:
        return b"##c heading=%d  x=0 y=0 z=0  xmin=0 xmax=0 ymin=0 ymax=0\r\n" % self._degrees()

    def _tilt(self) -> bytes:
        return b"##$T%d    0\r\n" % self._digit()
