"""The person of a socket, as far as the last snapshot says."""

from dataclasses import dataclass

from portal.live.threads import ANYBODY, DRIVERS, KNOWN, Pool


@dataclass(frozen=True, slots=True)
class Role:
    """The person of a socket and their rights there, as of the last snapshot.

    It decides about messages that do not wait for the database; a command is judged by the database.
    """

    person: int = 0  # their key; 0: nobody, or not known yet
    anonymous: bool = False  # nobody is signed in
    grant: int = 0  # the key of the open grant under which they drive the robot; 0: they do not drive
    staff: bool = False
    queued: bool = False  # they have a place in a queue

    @property
    def may_stop(self) -> bool:
        """Return whether a Stop goes to the robot at once."""
        return self.staff or self.grant > 0

    @property
    def stop_grant(self) -> int:
        """Return the grant that a Stop names, so that it counts for no later one; staff name none (0)."""
        return 0 if self.staff else self.grant

    @property
    def pool(self) -> Pool:
        """Return the threads for queries of this person."""
        return DRIVERS if self.grant else KNOWN if self.staff or self.queued else ANYBODY
