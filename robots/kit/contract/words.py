"""What a command does in a sentence of plain words: its label or words of its own, its arguments, their units.

A place is told from where the robot was before, if the spec has words for the directions: "Move to 12 cm right, 4 cm
up". `CommandKind.says` may name arguments in braces; a part in square brackets is left out where its argument was not
given: "Blow air[ for {seconds}]".
"""

import re
from collections.abc import Mapping, Sequence
from math import degrees, isfinite
from typing import Any

from robots.kit.contract.ranges import readable
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.plain import one_line

LONGEST = 60  # characters of a text that are told
SMALLEST = {"m": 0.0005, "rad": 0.001}  # a smaller difference is no motion
OPTIONAL, NAMED = re.compile(r"\[([^\[\]]*)\]"), re.compile(r"\{(\w+)\}")
Place = Mapping[str, float]  # coordinates of the pose by name (m, rad)


def command_words(spec: Spec, kind: str, args: Mapping[str, Any], before: Place | None = None) -> str:
    """Return what a command does. `before`: the robot's pose before it, as far as it is known."""
    found = spec.command(kind)
    if found is None:
        return one_line(kind).replace("_", " ").capitalize()
    if found.says:
        return _said(found, args)
    coordinates = spec.pose.coordinates if spec.pose else ()
    apart = [a for a in found.arguments if is_relative(a) and a.name in coordinates and a.name in args]
    if apart and all(is_number(args[a.name]) and a.name in (before or {}) for a in apart):
        moved = [way(a.directions, args[a.name] - (before or {})[a.name], a.unit) for a in apart]
        others = [_one(spec, a, args[a.name]) for a in found.arguments if a.name in args and a not in apart]
        words = ", ".join(part for part in (*moved, *others) if part)
        return " to ".join((found.label, words)) if words else f"{found.label} to where it was"
    parts = [_one(spec, a, args[a.name]) for a in found.arguments if args.get(a.name) is not None]
    words = ", ".join(part for part in parts if part)
    return f"{found.label}: {words}" if words else found.label


def way_words(spec: Spec, before: Place | None, after: Place | None) -> str:
    """Return how far a robot came, as "3 cm right, 1 cm down"; empty where a pose or the directions are not known."""
    directions = {a.name: a for c in spec.commands for a in c.arguments if is_relative(a)}
    names = [n for n in (spec.pose.coordinates if spec.pose else ()) if n in directions]
    if not names or not all(n in (before or {}) and n in (after or {}) for n in names):
        return ""
    ways = (way(directions[n].directions, (after or {})[n] - (before or {})[n], directions[n].unit) for n in names)
    return ", ".join(one for one in ways if one)


def place_words(spec: Spec, place: Place) -> str:
    """Return a place in the robot's coordinates, as "x 12 cm, y 42 cm"."""
    units = {c.name: c.unit for c in spec.pose.scalars()} if spec.pose else {}
    return ", ".join(f"{name} {quantity(place[name], unit)}" for name, unit in units.items() if name in place)


def place_of(spec: Spec, pose: Sequence[float] | None) -> dict[str, float]:
    """Return the coordinates of a stored pose by name; empty where it is not one of this robot."""
    names = spec.pose.coordinates if spec.pose else ()
    fits = pose is not None and len(pose) == len(names) and all(map(is_number, pose))
    return dict(zip(names, pose or (), strict=False)) if fits else {}


def quantity(value: float, unit: str) -> str:
    """Return a number with its unit as people say it: lengths under a metre in cm, angles in degrees."""
    if unit == "m" and abs(value) < 1:
        return f"{readable(round(value * 100, 1))} cm"
    if unit == "m":
        return f"{readable(round(value, 2))} m"
    if unit == "rad":
        return f"{readable(round(degrees(value), 1 if abs(value) < 0.2 else 0))}°"
    return f"{readable(round(value, 3))} {unit}".rstrip()


def _said(kind: CommandKind, args: Mapping[str, Any]) -> str:
    known = {a.name: _value(a, args[a.name]) for a in kind.arguments if args.get(a.name) is not None}

    def optional(part: re.Match[str]) -> str:
        return part[1] if all(name in known for name in NAMED.findall(part[1])) else ""

    return NAMED.sub(lambda found: known.get(found[1], "?"), OPTIONAL.sub(optional, kind.says))


def is_relative(argument: Argument) -> bool:
    """Tell whether a value is told from where the robot was before; one with a label says itself from where."""
    return bool(argument.directions) and not argument.label


def called(spec: Spec, argument: Argument) -> str:
    """Return what sentences call an argument: by its label, else by the robot's plain word for it, else by its name."""
    word = "" if argument.label else spec.words.get(argument.name, "")
    begins = word[:1].lower() if word[1:2].islower() else word[:1]
    return f"{begins}{word[1:]}" or argument.title


def _one(spec: Spec, argument: Argument, value: Any) -> str:
    """Return one argument in words; empty if it says nothing, as a speed of zero in some direction."""
    if argument.directions and not argument.unit and is_number(value):
        return "" if not value else argument.directions[value < 0]
    if argument.share and is_number(value):
        return f"{quantity(100 * value, '%')} {argument.share}"
    if is_relative(argument) and is_number(value):
        return f"{called(spec, argument)} {quantity(value, argument.unit)}"
    if argument.directions and is_number(value):
        return way(argument.directions, value, argument.unit)
    told = _value(argument, value)
    if argument.text:
        return told
    return f"{told} {argument.label}" if argument.label and argument.unit else f"{called(spec, argument)} {told}"


def way(directions: Sequence[str], value: Any, unit: str) -> str:
    """Return a way in one direction, as "3 cm right"; empty if it is too short to be one, or no number."""
    if not is_number(value) or abs(value) < SMALLEST.get(unit, 0.0) or not value:
        return ""
    return f"{quantity(abs(value), unit)} {directions[value < 0]}"


def _value(argument: Argument, value: Any) -> str:
    if is_number(value):
        return quantity(value, argument.unit)
    lines = [one_line(line) for line in str(value)[: 100 * LONGEST].splitlines() if line.strip()]
    first = lines[0] if lines else ""
    cut = f"{first[:LONGEST]}…" if len(first) > LONGEST else first
    return f"“{cut}” and {len(lines) - 1} more lines" if len(lines) > 1 else f"“{cut}”"


def is_number(value: Any) -> bool:
    """Tell whether a value is a number that can be told; True and False are none."""
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
