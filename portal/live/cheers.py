"""Cheers for who drives a robot: watchers press a button, everybody sees how many did in this turn.

Each web process adds its own to a counter in Redis every two seconds. Nothing says who cheered.
"""

from portal.edge.limits import AddressRate
from portal.live.actions import Answer
from portal.live.people import Role

OF_PERSON = AddressRate(rate=0.2, burst=3.0)  # by account: a page sends one in five seconds
OF_NETWORK = AddressRate(rate=0.5, burst=10.0)  # of all strangers of a network address, who may be a class at school
KEPT_S = 3600  # the counter of a turn in Redis, after it was read last
NOBODY = Answer(False, "Nobody drives now who could be cheered.", "not_driven")
YOURSELF = Answer(False, "You drive; the others can cheer.", "drives")
TOO_OFTEN = Answer(
    False,
    "That cheer was not counted: too many came from you, or from your network. Wait a moment.",
    "too_often",
)


class Cheers:
    """The cheers of one robot, as one web process knows them.

    `grant`: the key of the open grant whose holder may be cheered; 0: nobody may. `new`: those that Redis does not have
    yet. `count`: those of this grant in all web processes, when they were counted last.
    """

    def __init__(self) -> None:
        self.grant = self.new = self.count = 0

    def follow(self, grant: int) -> None:
        """Count for this grant from now on."""
        if grant != self.grant:
            self.grant, self.new, self.count = grant, 0, 0

    def note_count(self, grant: int, new: int, count: int) -> bool:
        """Note that Redis has so many of the new cheers, and how many there are. Return whether that is a change."""
        if grant != self.grant:
            return False
        self.new -= new
        changed, self.count = count != self.count, count
        return changed

    def text(self) -> str:
        """Return the message that tells how many cheers there are; empty while there are none."""
        return f'{{"t": "cheers", "grant": {self.grant}, "count": {self.count}}}' if self.count else ""

    def cheer(self, role: Role, address: str) -> Answer:
        """Count a cheer of this person, or of a stranger at this network address. Return the answer."""
        if not self.grant:
            return NOBODY
        if role.grant:
            return YOURSELF
        if not (OF_PERSON.take(f"account {role.person}") if role.person else OF_NETWORK.take(address)):
            return TOO_OFTEN
        self.new += 1
        return Answer()
