"""Our part of the firmware, behind `%`: the client in command, velocities, patrol, permit, rules, journal.

It has no thread; its owner calls everything under the lock of the hardware. `clock` counts its uptime.
"""

import contextlib
from binascii import crc_hqx
from collections.abc import Callable

from robots.kit.clock import Timer
from robots.kit.description import load
from robots.kit.description import text_of as described_text
from robots.kit.drivers.srv1 import sensors
from robots.kit.drivers.srv1.answers import ENDS, Acknowledgement, Answer, Event, Reason, Refusal, Status
from robots.kit.drivers.srv1.extension import (  # fmt: skip
    LATE_MS,
    Activate,
    Ask,
    Claim,
    Command,
    Journal,
    Patrol,
    Permit,
    Velocity,
)
from robots.kit.drivers.srv1.sensors import Channel
from simulators.common.journal import Note
from simulators.common.rovers.motor_board import End
from simulators.srv1.flash import Flash, text_of
from simulators.srv1.hardware import Hardware
from simulators.srv1.logbook import Logbook
from simulators.srv1.odometry import EncoderWatch, Odometry
from simulators.srv1.patrol import Patrol as Course
from simulators.srv1.patrol import Rules
from simulators.srv1.permits import Permits
from simulators.srv1.rules import RuleSet

MADE_WITH = "rules.txt"  # the original rule set
FORGOTTEN_S = 60.0  # after so long without a command any epoch is accepted: a wrong one locks nobody out for ever
Parse = Callable[[str], Rules]


class Commander:
    """Answers commands, and `tick`s some ten times a second or more."""

    def __init__(
        self, hardware: Hardware, flash: Flash, note: Note, clock: Timer, boot: int, parse: Parse = RuleSet.parse
    ) -> None:
        self._hardware, self._flash, self._note, self._clock, self._parse = hardware, flash, note, clock, parse
        self._description = load("srv1")
        self.boot = boot
        self.restart()

    def restart(self) -> None:
        """Begin as at power on, with the rule set of the flash memory."""
        hardware = self._hardware
        self._began = self._ticked = self._heard = self._clock.monotonic()
        self._now = 0.0  # the motor board's
        self._epoch, self._mode, self._patrol_said, self._aside = 0, "rest", 0.0, 0.0
        self._course, self._permits = Course(), Permits()
        self._log = Logbook(lambda: self.uptime_ms, lambda: (self._odometry.x, self._odometry.y))
        self._odometry = Odometry(hardware.encoders(), hardware.compass())
        self._encoders = EncoderWatch(hardware.encoders())
        self._stopped = False  # by the sonar's reflex
        self._rules, self._crc = self._stored()
        self._motion, self._reflexes, self._moving = hardware.drive.motion, 0, False
        self._log.write(Event.POWER, self.boot)

    def _stored(self) -> tuple[Rules, int]:
        """Return the rule set of the flash memory and its CRC; if there is none, the original one and 0."""
        text = text_of(self._flash.user)
        if text:
            with contextlib.suppress(ValueError):  # no rule set, or no ASCII
                return self._parse(text.decode("ascii")), crc_hqx(text, 0)
        return RuleSet.parse(described_text("srv1", MADE_WITH)), 0

    @property
    def uptime_ms(self) -> int:
        """Return the ms since power on."""
        return int((self._clock.monotonic() - self._began) * 1000)

    @property
    def odometry(self) -> Odometry:
        """Return the estimate of its place."""
        return self._odometry

    # time

    def tick(self, now: float) -> None:
        """Execute the timer's interrupt; `now` is the motor board's time (s)."""
        at = self._clock.monotonic()
        seconds, self._ticked, self._now = at - self._ticked, at, now
        hardware = self._hardware
        self._odometry.advance(hardware.encoders(), hardware.compass(), seconds)
        self._encoders.advance(hardware.encoders(), hardware.drive.target, hardware.drive.motion, seconds)
        self._watch_permit(at)
        if self._mode == "patrol":
            self._go_on(at)
        elif self._mode == "hand" and self._epoch:
            self._guard()
        self._write_motions()
        self._log.follow(self._mode == "patrol", at - self._patrol_said, hardware.drive.motion)

    def _guard(self) -> None:
        """Limit the speed ahead, below every command, to what infrared and sonar allow."""
        self._hardware.drive.limit_ahead(self._most_ahead())

    def _most_ahead(self) -> float:
        """Return how fast it may drive ahead (m/s). The sonar sees what swallows the light of infrared."""
        hardware, known = self._hardware, self._description
        infrared, sonar = hardware.infrared(), hardware.sonar()
        self._stopped = sonar < known["sonar"]["free" if self._stopped else "stop"]
        if infrared < known["infrared"]["stop"] or self._stopped:
            return 0.0
        return float(known["motion"]["slow" if sonar < known["sonar"]["close"] else "speed"])

    def _alone(self, at: float) -> bool:
        return at - self._patrol_said > float(self._description["motion"]["forget_s"])

    def _watch_permit(self, at: float) -> None:
        why = self._permits.violation(self._odometry, self.uptime_ms)
        if self._permits.runs and self._encoders.dead:
            why = Event.ENCODER
        if why is None:
            return
        self._log.write(why, self._hardware.drive.motion)
        self._note("permit_end", why=str(why))
        self._permits.end()
        if why is not Event.EXPIRED or (self._mode == "patrol" and self._alone(at)):
            self._rest(End.PERMIT)

    def _go_on(self, at: float) -> None:
        """Drive by the rules for the next moment; end the patrol if nobody renews it and there is no permit."""
        if self._alone(at):
            if not self._permits.runs:
                self._mode = "rest"  # the motor board forgets the velocity
                return
            self._aside = 0.0  # where the way leads on is not known any more
        most = float(self._description["motion"]["most_speed"])
        if self._permits.runs:
            most = min(most, self._permits.permit.speed)
        hardware, course = self._hardware, self._course
        speed = self._rules.speed_mm_s(*(self._thousandths(name) for name in self._rules.inputs)) / 1000
        linear, angular = course.velocity(
            hardware.infrared(), hardware.sonar(), self._odometry.linear, min(most, speed), self._aside
        )  # fmt: skip
        if course.reflexes != self._reflexes:
            self._reflexes = course.reflexes
            self._log.write(Event.REFLEX, hardware.drive.motion)
            self._note("reflex", motion=hardware.drive.motion)
        hardware.drive.velocity(linear, angular, self._epoch, self._now)

    def _thousandths(self, name: str) -> int:
        """Return a reading for the rules, in thousandths of its unit (m, V, degrees Celsius, per cent)."""
        hardware = self._hardware
        match name:
            case "infrared":
                value = hardware.infrared()
            case "sonar":
                value = hardware.sonar()
            case "battery":
                value = hardware.battery()
            case "temperature":
                value = sensors.temperature_c(hardware.analogue(Channel.TEMPERATURE))
            case _:
                value = 100 * sensors.share(hardware.analogue(Channel[name.upper()]))
        return round(1000 * value)

    def _write_motions(self) -> None:
        drive = self._hardware.drive
        if drive.motion != self._motion:
            self._motion, self._moving = drive.motion, True
            self._log.write(Event.MOTION, drive.motion)
        if self._moving and not drive.moving:
            self._moving = False
            self._log.write(Event.REST, ENDS.index(drive.end))
        if self._mode == "hand" and not drive.moving:
            self._mode = "rest"

    def _rest(self, why: End) -> None:
        self._mode = "rest"
        self._hardware.drive.hold(why)

    # commands

    def hold(self) -> None:
        """Brake to rest; patrol and permit end."""
        self._note("hold", moving=self._hardware.drive.moving)
        self._write_motions()
        self._permits.end()
        self._rest(End.HELD)

    def by_letters(self) -> None:
        """Note that the published letters drive now: patrol and permit end."""
        self._permits.end()
        self._mode = "hand"

    def answer(self, command: Command) -> Answer:
        """Execute a command; return the answer.

        A command that is not refused for its epoch renews the claim. A question has no epoch; but one client is
        connected at a time, and a client whose claim is refused has nothing to ask.
        """
        answer = self._answer(command)
        if answer != Refusal(command.letter, Reason.EPOCH):
            self._heard = self._clock.monotonic()
        return answer

    def _answer(self, command: Command) -> Answer:
        match command:
            case Claim():
                return self._claim(command)
            case Journal():
                return self._log.after(command.since)
            case Activate():
                return self._activate(command)
            case Velocity() | Patrol() | Permit():
                reason = self._why_not(command)
                if reason is not None:
                    return Refusal(command.letter, reason)
                self._do(command)
                if isinstance(command, Permit):
                    return self._done(command)
        return self.status(command.letter)  # also of a hold, which the interrupt has executed

    def _done(self, command: Command) -> Acknowledgement:
        self._write_motions()
        return Acknowledgement(command.letter, self._hardware.drive.motion, self.uptime_ms)

    def _claim(self, claim: Claim) -> Answer:
        if self._clock.monotonic() - self._heard > FORGOTTEN_S and not self._permits.runs:
            self._epoch = 0
        if claim.epoch < self._epoch:
            return Refusal(claim.letter, Reason.EPOCH)
        if claim.epoch > self._epoch:
            if self._epoch and self._hardware.drive.moving:
                self._rest(End.REPLACED)
            self._permits.end()
            self._epoch = claim.epoch
            self._log.write(Event.CLAIM, claim.epoch)
            self._note("claim", epoch=claim.epoch)
        return self.status(claim.letter)

    def _is_ours(self, command: Velocity | Patrol | Permit | Activate) -> bool:
        return bool(command.epoch) and command.epoch == self._epoch

    def _why_not(self, command: Velocity | Patrol | Permit) -> Reason | None:
        motion = self._description["motion"]
        if not self._is_ours(command):
            return Reason.EPOCH
        if self._hardware.drive.holding:
            return Reason.HOLDING
        if isinstance(command, Permit):
            fits = self._permits.takes(command, self.uptime_ms) and command.speed <= motion["speed"]
            return None if fits else Reason.BOUNDS
        if not 0 <= self.uptime_ms - command.stamp <= LATE_MS:
            self._note("late", seconds=round((self.uptime_ms - command.stamp) / 1000, 3))
            return Reason.LATE
        if isinstance(command, Patrol):
            return None
        fits = abs(command.linear) <= motion["speed"] and abs(command.angular) <= motion["turn"]
        return None if fits else Reason.BOUNDS

    def _do(self, command: Velocity | Patrol | Permit) -> None:
        at = self._clock.monotonic()
        if isinstance(command, Velocity):
            self._mode = "hand"
            linear = min(command.linear, self._most_ahead())
            self._hardware.drive.velocity(linear, command.angular, self._epoch, self._now)
        elif isinstance(command, Permit):
            renewed = self._permits.runs
            self._permits.grant(command, self.uptime_ms)
            left_ms = self._permits.left_ms(self.uptime_ms)
            if not (renewed and left_ms):
                self._log.write(Event.PERMIT, left_ms)
            self._note("permit", seconds=left_ms / 1000, speed=command.speed, area=list(command.area))
        else:
            self._patrol_said, self._aside = at, command.aside
            if self._mode != "patrol":
                self._mode = "patrol"
                self._course.begin()
                self._log.write(Event.PATROL, self._hardware.drive.motion)
                self._go_on(at)

    def _activate(self, command: Activate) -> Answer:
        if not self._is_ours(command):
            return Refusal(command.letter, Reason.EPOCH)
        text = self._flash.text()
        if not text or crc_hqx(text, 0) != command.crc:
            return Refusal(command.letter, Reason.CHECKSUM)
        try:
            self._rules = self._parse(text.decode("ascii"))
        except ValueError:
            return Refusal(command.letter, Reason.RULES)
        self._crc = command.crc
        self._log.write(Event.RULES, command.crc)
        self._note("rules", crc=command.crc)
        return self._done(command)

    def status(self, letter: str = Ask.letter) -> Status:
        """Return the rover's report of itself."""
        hardware, place = self._hardware, self._odometry
        self._write_motions()
        drive = hardware.drive
        return Status(
            self.boot, self._epoch, drive.motion, drive.moving, drive.holding, str(drive.end), self._mode, place.x,
            place.y, place.heading, place.linear, place.angular, hardware.infrared(), hardware.sonar(),
            hardware.battery(), sensors.temperature_c(hardware.analogue(Channel.TEMPERATURE)),
            sensors.share(hardware.analogue(Channel.HUMIDITY)), sensors.share(hardware.analogue(Channel.LIGHT)),
            sensors.is_present(hardware.analogue(Channel.PRESENCE)), self._encoders.dead, self._crc,
            self._permits.left_ms(self.uptime_ms), self._log.newest, self.uptime_ms, letter, hardware.beacon(),
        )  # fmt: skip
