"""Puts a rule set into force while the rover does whatever it does: upload, checksum, and the word to swap."""

from collections.abc import Callable

from robots.kit.contract.errors import ControllerRefused, GaveUp, LineSilent
from robots.kit.contract.session import Permit
from robots.kit.drivers.srv1.extension import Activate
from robots.kit.drivers.srv1.rules import canonical, crc_of
from robots.kit.drivers.srv1.wheels import Wheels

TRIES = 3  # of an upload, which moves nothing; a motion that ends beside it ends it, too
NOT_WHOLE = "The rules did not reach the rover whole; those that were in force still are."


def put_in_force(text: str, wheels: Wheels, permit: Permit, began: Callable[[], None]) -> int:
    """Return the CRC of the set, which the rover drives by from its next tick on; `text` is a rule set's.

    A hold by another thread ends an upload, which is begun again where `permit` allows it. Raises what `permit` and the
    line raise; GaveUp where the rover answers but does not get or take the text.
    """
    data, crc = canonical(text).encode("ascii"), crc_of(text)
    for _ in range(TRIES):
        permit()
        try:
            wheels.line.upload(data, permit)
            began()
            wheels.line.ask(Activate(wheels.line.epoch, crc), permit=permit)
        except LineSilent:
            continue
        except ControllerRefused as error:
            raise GaveUp(str(error)) from error
        else:
            wheels.ask()
            return crc
    wheels.ask()
    raise GaveUp(NOT_WHOLE)
