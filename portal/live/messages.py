"""What a page may say over its socket: the one place for the wire's format.

A message is decoded into one of these types, with every length and number bounded, before
anything looks at it. Pure: no Django, no I/O.
"""

from typing import Annotated, Any, Generic, Literal, TypeVar

import msgspec
from msgspec import Meta

LONGEST = 8192  # bytes of one message
GREATEST = 2**53 - 1  # the largest whole number that a browser tells exactly
JOINTS = 16
CAMERAS = 8  # a robot may have

Sequence = Annotated[int, Meta(ge=1, le=GREATEST)]
Number = Annotated[int, Meta(ge=0, le=GREATEST)]
Name = Annotated[str, Meta(min_length=1, max_length=30, pattern=r"^[^\x00]*\Z")]
Text = Annotated[str, Meta(max_length=LONGEST, pattern=r"^[^\x00]*\Z")]
Slug = Annotated[str, Meta(max_length=50, pattern=r"^[-a-zA-Z0-9_]*\Z")]
Integer = Annotated[int, Meta(ge=-GREATEST, le=GREATEST)]
Arguments = Annotated[dict[Name, bool | Integer | float | Text | None], Meta(max_length=32)]


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="t"):
    """Root of all messages; `t` on the wire says which."""


class Command(Message, frozen=True, tag="command"):
    """Issue a command under one's grant; the same `seq` again is the same command."""

    kind: Name
    seq: Sequence
    args: Arguments = {}


class Stop(Message, frozen=True, tag="stop"):
    """Stop the robot."""


class Release(Message, frozen=True, tag="release"):
    """Release a latched stop; `checked`: the newest picture was looked at."""

    checked: bool = False


class Join(Message, frozen=True, tag="join"):
    """Take a place in the queue."""


class Leave(Message, frozen=True, tag="leave"):
    """Give up one's place, offer or turn."""


class Accept(Message, frozen=True, tag="accept"):
    """Take up an offer."""


class Ping(Message, frozen=True, tag="ping"):
    """Presence; `n` comes back in the pong."""

    n: Number = 0


class Keep(Message, frozen=True, tag="keep"):
    """The controls of the held motion `seq` are still held."""

    seq: Sequence


class Released(Message, frozen=True, tag="let_go"):
    """The controls of the held motion `seq` were released."""

    seq: Sequence


class Trace(Message, frozen=True, tag="trace"):
    """Show the robot's wire, or no longer; for staff."""

    on: bool


class Watch(Message, frozen=True, tag="watch"):
    """Whose pictures this page wants."""

    cameras: Annotated[list[Annotated[int, Meta(ge=0, lt=CAMERAS)]], Meta(max_length=CAMERAS)]


class Plan(Message, frozen=True, tag="plan"):
    """Ask where a command would lead from these joints (rad, m)."""

    kind: Name
    joints: Annotated[list[float], Meta(max_length=JOINTS)] = msgspec.field(name="from")
    args: Arguments = {}
    n: Number = 0


class Here(Message, frozen=True, tag="here"):
    """The page of a person is there and hears; the answer to what it is told."""


class Look(Message, frozen=True, tag="look"):
    """Tell me again where I stand."""


class Do(Message, frozen=True, tag="do"):
    """Join, leave or accept at a robot, or dismiss the note of a lost place, from any page."""

    what: Literal["join", "leave", "accept", "dismiss"]
    robot: Slug = ""
    ticket: Number = 0


PersonMessage = Here | Look | Do
RobotMessage = Command | Stop | Release | Join | Leave | Accept | Ping | Keep | Released | Trace | Watch | Plan
M = TypeVar("M")


class NotUnderstood(Exception):
    """The message is none of ours; `to` and `seq` say, as far as can be read, what it meant to be.

    `hopeless` is what no page of ours sends: no JSON object, or too long.
    """

    def __init__(self, text: str, to: str = "", seq: int = 0, hopeless: bool = False) -> None:
        super().__init__(text)
        self.to, self.seq, self.hopeless = to, seq, hopeless


class _Head(msgspec.Struct, frozen=True):
    t: str = ""
    seq: Number = 0


class Wire(Generic[M]):
    """The messages of one kind of socket."""

    def __init__(self, types: Any) -> None:
        self._decoder: msgspec.json.Decoder[M] = msgspec.json.Decoder(types)
        self._head = msgspec.json.Decoder(_Head)

    def decode(self, text: str | None) -> M:
        """Return the message that the text of a frame is (None: a frame of bytes). Raises NotUnderstood."""
        try:
            data = (text or "").encode()
        except UnicodeEncodeError:  # half of a surrogate pair
            data = b""
        if not data or len(data) > LONGEST:
            raise NotUnderstood(f"A message is a JSON object of at most {LONGEST} bytes.", hopeless=True)
        try:
            return self._decoder.decode(data)
        except (msgspec.MsgspecError, RecursionError) as error:
            raise self._refusal(data, error) from error

    def _refusal(self, data: bytes, error: Exception) -> NotUnderstood:
        head: _Head | None
        try:
            head = self._head.decode(data)
        except msgspec.ValidationError:
            head = _Head() if data.lstrip()[:1] == b"{" else None
        except (msgspec.MsgspecError, RecursionError):
            head = None
        if head is None:
            return NotUnderstood("A message is a JSON object.", hopeless=True)
        return NotUnderstood(f"That request was not understood ({error}); reload the page.", head.t[:30], head.seq)


ROBOT: Wire[RobotMessage] = Wire(RobotMessage)
PERSON: Wire[PersonMessage] = Wire(PersonMessage)
