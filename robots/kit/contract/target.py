"""Where a command takes a robot, for everybody who watches: a place in its coordinates, and a sentence."""

from collections.abc import Mapping
from typing import Any

from robots.kit.contract.capabilities import Programs
from robots.kit.contract.spec import Spec
from robots.kit.contract.words import NAMED, OPTIONAL, Place, command_words, is_number

LONGEST = 160  # characters of the sentence


def target_of(spec: Spec, kind: str, args: Mapping[str, Any], before: Place | None = None) -> dict[str, Any]:
    """Return `words`, what a motion does, and `place`, where it goes: coordinates of the pose by name (m, rad).

    The place is left out where the command names none. Empty for what has no target: a setting, a procedure, and a
    motion that goes on while somebody holds it. `before`: the robot's pose before it, as far as it is known. The result
    tells numbers alone, and of a program only its name: its author may not share it.
    """
    command = spec.command(kind)
    if command is None or command.held or not command.moves or command.lane != "motion":
        return {}
    numbers = {name: value for name, value in args.items() if is_number(value)}
    place = {name: numbers[name] for name in (spec.pose.coordinates if spec.pose else ()) if name in numbers}
    told = {a.name: place[a.name] for a in command.arguments if a.name in place and a.unit == "m"} or numbers
    hidden = any(name not in told for name in NAMED.findall(OPTIONAL.sub("", command.says)))
    if hidden or any(one.kind == kind for one in spec.all_of(Programs)):
        return {"words": command.label}
    words = command_words(spec, kind, told, before)[:LONGEST]
    return {"words": words, "place": place} if place else {"words": words}
