"""Errors of the rover's line beside those of the contract, and the sentences for what the rover refuses."""

from robots.kit.contract.errors import ControllerRefused, HardwareFault, LineBusy, LineSilent
from robots.kit.drivers.srv1.answers import Reason

REFUSALS = {
    Reason.HOLDING: "The rover is being held.",
    Reason.LATE: "The command came too late over the rover's line, and was refused.",
    Reason.BOUNDS: "The rover does not take this value.",
    Reason.CHECKSUM: "The rules did not arrive whole.",
    Reason.RULES: "The rover does not understand these rules.",
}


class NotNow(ControllerRefused):
    """The rover refused a command that came late or during a hold; another one may be sent."""


class Overtaken(TimeoutError):
    """A hold was sent after the question, which is not answered any more."""


class StockFirmware(LineSilent):
    """The rover answers to its published letters and is silent to `%`; the line stays open."""


def refusal(reason: Reason) -> HardwareFault:
    """Return the error for a command that the rover refuses."""
    if reason is Reason.EPOCH:
        return LineBusy("The rover is used by another client.")
    refused = NotNow if reason in (Reason.LATE, Reason.HOLDING) else ControllerRefused
    return refused(REFUSALS[reason])
