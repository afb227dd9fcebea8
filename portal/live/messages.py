"""The messages that a page may send over its socket, and their limits.

A message is decoded into one of these types, with every length and number limited, before anything uses it.
No Django, no I/O.
"""

from typing import Annotated, Any, Generic, Literal, TypeVar

import msgspec
from msgspec import Meta

LONGEST = 8192  # bytes of one message
GREATEST = 2**53 - 1  # the largest integer that a browser represents exactly
JOINTS = 16
CAMERAS = 8  # a robot may have

Sequence = Annotated[int, Meta(ge=1, le=GREATEST)]
Number = Annotated[int, Meta(ge=0, le=GREATEST)]
Name = Annotated[str, Meta(min_length=1, max_length=30, pattern=r"^[^\x00]*\Z")]
Text = Annotated[str, Meta(max_length=LONGEST, pattern=r"^[^\x00]*\Z")]
Slug = Annotated[str, Meta(max_length=50, pattern=r"^[-a-zA-Z0-9_]*\Z")]
Integer = Annotated[int, Meta(ge=-GREATEST, le=GREATEST)]
Arguments = Annotated[dict[Name, bool | Integer | float | Text | None], Meta(max_length=32)]
Numbers = Annotated[dict[Name, Integer | float], Meta(max_length=8)]


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="t"):
    """Base class of messages; `t` on the wire names the type."""


class Command(Message, frozen=True, tag="command"):
    """Give a command; the same `seq` again is the same command.

    `seen`: when the picture was taken that the page shows (ms since 1970); 0: none, or the page does not say.
    """

    kind: Name
    seq: Sequence
    args: Arguments = {}
    seen: Number = 0


class Stop(Message, frozen=True, tag="stop"):
    """Stop the robot."""


class Release(Message, frozen=True, tag="release"):
    """Release a latched stop; `checked`: the person looked at the newest picture."""

    checked: bool = False


class Join(Message, frozen=True, tag="join"):
    """Take a place in the queue."""


class Leave(Message, frozen=True, tag="leave"):
    """Give up a place, an offer or a turn."""


class Accept(Message, frozen=True, tag="accept"):
    """Accept an offer."""


class Ping(Message, frozen=True, tag="ping"):
    """Report presence; `n` is returned in the pong."""

    n: Number = 0


class Keep(Message, frozen=True, tag="keep"):
    """The controls of the held motion `seq` are still held; `args` are newer values of it, where it is steered."""

    seq: Sequence
    args: Numbers = {}


class Released(Message, frozen=True, tag="released"):
    """The controls of the held motion `seq` were released."""

    seq: Sequence


class Trace(Message, frozen=True, tag="trace"):
    """Start or stop showing the robot's wire trace; for staff."""

    on: bool


class Cheer(Message, frozen=True, tag="cheer"):
    """Cheer for who drives."""


class Watch(Message, frozen=True, tag="watch"):
    """Choose the cameras whose pictures this page wants.

    `every_s`: the least time between two pictures of a camera (s); 0: each picture. If the page wants each, `video` is
    the coding of video that it decodes (empty: only JPEG), and `coarse` asks for few bytes, at most five pictures a
    second. `compact`: states in few bytes, over a line on which little may be on the way. `sound`: the person listens.
    `pieces`: it takes long messages in pieces, and deltas of byte streams with short heads.
    """

    cameras: Annotated[list[Annotated[int, Meta(ge=0, lt=CAMERAS)]], Meta(max_length=CAMERAS)]
    every_s: Annotated[float, Meta(ge=0, le=60)] = 0.0
    compact: bool = False
    video: Literal["", "vp8", "vp9"] = ""
    coarse: bool = False
    sound: bool = False
    pieces: bool = False


class Plan(Message, frozen=True, tag="plan"):
    """Ask where a command would lead from these joints (rad, m); a robot without joints answers in its own frame."""

    kind: Name
    joints: Annotated[list[float], Meta(max_length=JOINTS)] = msgspec.field(name="from", default_factory=list)
    args: Arguments = {}
    n: Number = 0


class Here(Message, frozen=True, tag="here"):
    """Report that the person's page is open."""


class Look(Message, frozen=True, tag="look"):
    """Ask for the person's places again."""


class Do(Message, frozen=True, tag="do"):
    """Join, leave, accept or stay at a robot, or dismiss the note about an end, from any page."""

    what: Literal["join", "leave", "accept", "stay", "dismiss"]
    robot: Slug = ""
    ticket: Number = 0


PersonMessage = Here | Look | Do
RobotMessage = Command | Stop | Release | Join | Leave | Accept | Ping | Keep | Released | Trace | Cheer | Watch | Plan
M = TypeVar("M")


class NotUnderstood(Exception):
    """The message is not valid; `to` and `seq` are its type and number, if they can be read.

    `hopeless`: none of our pages sends this, because it is not a JSON object or is too long.
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
        """Return the message in the text of a frame (None: a binary frame). Raises NotUnderstood."""
        try:
            data = (text or "").encode()
        except UnicodeEncodeError:  # an unpaired surrogate
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
