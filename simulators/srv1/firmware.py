"""The rover's firmware, byte by byte: the stock one's loop, and ours behind `%` and in two interrupts.

One thread `run`s the loop: it takes a letter, does everything that the letter asks for, and then throws away all bytes
that have arrived meanwhile. `receive` is the serial port, `tick` the timer's interrupt; both may be called by other
threads while the loop is busy. `receive` finds a hold at any moment: the rover brakes at once, the loop gives up its
command (an argument that it waits for, a motion of `M`) without an answer, and answers the hold when it is free.
"""

from collections.abc import Callable

from robots.kit.clock import TIMER, Limit, Lock, Timer
from robots.kit.drivers.srv1 import answers, extension
from robots.kit.drivers.srv1.extension import Hold
from robots.kit.drivers.srv1.framing import BOOT, COMMAND, LONGEST_COMMAND, Frame
from robots.kit.drivers.srv1.protocol import Malformed
from simulators.common.journal import Note
from simulators.srv1.commander import Commander, Parse
from simulators.srv1.flash import Flash
from simulators.srv1.hardware import Hardware
from simulators.srv1.motors import Motors
from simulators.srv1.rules import RuleSet
from simulators.srv1.stock import AUTORUN, VERSION, Reset, Stock
from simulators.srv1.uart import Interrupted, Stopped, Uart

BAUD, BITS_A_BYTE = 2_500_000, 10  # of the serial port to the module
FLUSH_S = 12 / BAUD  # after a command it throws bytes away until none has come for so long
BOOT_S = 1.0  # memory is cleared, and the camera is set up
NEXT_S = 0.1  # the longest pause within one of our frames; without the rest it is given up
HELLO, HELLO_ANSWER = b"h", b"myfunc:  hello ! \r\n"


class Firmware:
    """`send` takes what goes to the Wi-Fi module, and returns for how long (s) that has no room for more.

    `stock`: without our part, so that `%` is silent. `lock` protects the hardware, and is the simulator's: its steps of
    the motor board hold it. `boot` is the number of this start; `flash` has what outlives a loss of power; `parse`
    makes a rule set of its text. `wake` is called when the motors get a command.
    """

    def __init__(
        self, hardware: Hardware, send: Callable[[bytes], float], note: Note, clock: Timer = TIMER,
        lock: Lock | None = None, *, stock: bool = False, boot: int = 1, flash: Flash | None = None,
        parse: Parse = RuleSet.parse, wake: Callable[[], None] = lambda: None,
    ) -> None:  # fmt: skip
        self._hardware, self._sends, self._note, self._clock = hardware, send, note, clock
        self._said_until = 0.0  # when the newest answer was out
        self._lock = lock if lock is not None else clock.lock()
        self._is_stock, self._wake = stock, wake
        self.flash = flash if flash is not None else Flash()
        self._uart = Uart(None if stock else self._held, clock)
        self._motors = Motors(self._percent, self._uart.delay)
        self._stock = Stock(hardware, self._lock, self._uart, self._motors, self.flash, self._send, clock)
        self.commander = Commander(hardware, self.flash, note, clock, boot, parse)
        self._said_hold, self._boots, self.started = False, True, False  # started: it has said its first lines
        self._heard = self._heard_at = clock.monotonic()  # when the newest command ended, and when the next one came
        self._fails_safe = False  # the failsafe speeds have been taken since
        note("power_on", boot=boot)

    @property
    def boot(self) -> int:
        """Return the number of this start."""
        return self.commander.boot

    # what other threads call

    def receive(self, data: bytes) -> None:
        """Take bytes from the Wi-Fi module, at any time."""
        self._uart.receive(data)

    def tick(self, now: float) -> None:
        """Execute the timer's interrupt, ten times a second or more; `now`: the motor board's time (s)."""
        with self._lock:
            self.commander.tick(now)

    def restart(self) -> None:
        """Lose the power and get it back: only the flash memory keeps its contents."""
        self._begin()
        self._uart.interrupt(forget=True)

    def stop(self) -> None:
        """End the loop."""
        self._uart.stop()

    def _begin(self) -> None:
        with self._lock:
            self._hardware.drive.restart()
            self.commander.boot = (self.commander.boot + 1) % (BOOT.high + 1)
            self.commander.restart()
            self._stock.restart()
            self._said_hold, self._boots, self.started = False, True, False
            self._note("power_on", boot=self.commander.boot)

    def _held(self) -> None:
        with self._lock:
            self._said_hold = True
            self.commander.hold()
        self._wake()

    def _percent(self, left: int, right: int) -> None:
        with self._lock:
            self.commander.by_letters()
            self._hardware.drive.percent(left, right)
        self._wake()

    # the loop

    def run(self) -> None:
        """Execute commands until stopped."""
        while True:
            try:
                self._uart.settle()
                if self._boots:
                    self._start()
                if self._said_hold:
                    self._say_held()
                while True:
                    self._next()
            except Interrupted:
                continue
            except Reset:
                self._begin()
            except Stopped:
                return
            except Exception as error:  # noqa: BLE001 - one command must not end the loop
                self._note("crash", error=f"{type(error).__name__}: {error}")
                self._end_command()

    def _start(self) -> None:
        """Send the first lines, which no command asks for."""
        self._boots = False
        limit = Limit(self._clock, BOOT_S)
        while limit.remaining > 0:
            try:
                self._uart.delay(limit.remaining)
            except Interrupted:
                self._uart.settle()
                if self._boots:
                    raise
        self._send(b"#f" + VERSION)  # it begins by switching the failsafe off
        self._send(AUTORUN)
        self._heard, self.started = self._clock.monotonic(), True

    def _say_held(self) -> None:
        with self._lock:
            self._said_hold = False
            status = self.commander.status(Hold.letter)
        self._answer(status)
        self._end_command()

    def _next(self) -> None:
        """Execute the next command, or take the failsafe speeds if none comes."""
        due = None if self._fails_safe else self._motors.failsafe_due(self._clock.monotonic() - self._heard)
        byte = self._uart.byte(None if due is None else max(0.0, due))
        self._heard_at = self._clock.monotonic()
        if byte is None:
            self._fails_safe = due is not None
            self._motors.fail_safe()
            return
        if byte == COMMAND[0]:
            self._user_function()
        else:
            self._stock.do(chr(byte))
        self._end_command()

    def _send(self, data: bytes) -> None:
        """Send bytes. This takes as long as the serial port needs, or longer by the module's flow control.

        All of them arrive at the end, so that no client goes on before the firmware does.
        """
        self._clock.sleep(len(data) * BITS_A_BYTE / BAUD)
        out = self._clock.monotonic()
        wait = self._sends(data)
        self._clock.sleep(wait)
        self._said_until = out + wait  # without the time by which this machine delayed the thread

    def _end_command(self) -> None:
        now = self._clock.monotonic()
        silent = self._said_until < self._heard_at  # it had no answer
        self._heard, self._fails_safe = now, False
        self._uart.flush(now if silent else self._said_until + FLUSH_S)

    def _user_function(self) -> None:
        """Execute what follows `%`."""
        if self._is_stock:
            if self._uart.argument() == HELLO[0]:
                self._send(HELLO_ANSWER)
            return
        frame = bytearray(COMMAND)
        while len(frame) < LONGEST_COMMAND and not frame.endswith(b"\n"):
            byte = self._uart.byte(NEXT_S)
            if byte is None:
                break
            frame.append(byte)
        if frame == COMMAND + HELLO:
            self._send(HELLO_ANSWER)
            return
        try:
            said = Frame.decode(bytes(frame), COMMAND)
        except Malformed:
            return  # a frame that cannot be read gets no answer
        try:
            command = extension.decode(said)
        except Malformed:
            if said.letter in extension.COMMANDS:
                self._answer(answers.Refusal(said.letter, answers.Reason.BOUNDS))
            return
        with self._lock:
            answer = self.commander.answer(command)
        self._wake()
        self._answer(answer)

    def _answer(self, answer: answers.Answer) -> None:
        self._send(answers.encode(answer))
