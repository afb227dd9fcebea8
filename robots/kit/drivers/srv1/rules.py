"""Rule sets for this rover: the readings that they may use, and its braking."""

from binascii import crc_hqx
from functools import cache, lru_cache

from robots.kit.contract.errors import BadRequest
from robots.kit.description import load, text_of
from robots.kit.rovers.fuzzy import RuleSet
from robots.kit.rovers.fuzzy_check import Braking, check
from robots.kit.rovers.fuzzy_text import parse, write

READINGS = {
    "infrared": "m", "sonar": "m", "battery": "V", "temperature": "C", "humidity": "%", "light": "%",
}  # fmt: skip
NOISES = 3  # standard deviations of a distance


def braking() -> Braking:
    """Return how the rover stops, by its robot.toml.

    Its deceleration counts as that of a change of speed by the rules, which is less than that of a hold; its reaction
    time counts as the time after which a velocity is forgotten.
    """
    made = load("srv1")
    body, motion, infrared = made["body"], made["motion"], made["infrared"]
    behind = body["length"] / 2 - infrared["from"][0]
    return Braking(
        deceleration=min(motion["acceleration"], motion["braking"]),
        reaction_s=motion["forget_s"],
        margin=behind + NOISES * infrared["noise"],
        stop=infrared["stop"],
        far=infrared["far"],
        most=motion["most_speed"],
    )


def rules_of(text: str) -> RuleSet:
    """Return the rule set of a text that somebody sends. Raises BadRequest with a sentence that names the rule."""
    try:
        rules = parse(text)
        check(rules, READINGS, braking())
    except ValueError as error:
        raise BadRequest(str(error)) from error
    return rules


@cache
def paper() -> str:
    """Return the text of the rule set that the rover was made with, the paper's."""
    return text_of("srv1", "rules.txt")


def canonical(text: str) -> str:
    """Return the text of a rule set as it is sent to the rover: its lines in a fixed order, without comments.

    Raises ValueError where the text is no rule set.
    """
    return write(parse(text))


@lru_cache(64)
def crc_of(text: str) -> int:
    """Return the CRC by which the rover names a rule set that was sent to it. Raises ValueError as `canonical`."""
    return crc_hqx(canonical(text).encode("ascii"), 0)


def number_of(text: str) -> int:
    """Return what the channel `rules` shows while that set is in force; -1, which it never shows, for no rule set."""
    try:
        return channel_value(crc_of(text))
    except ValueError:  # an earlier version may have taken it
        return -1


def channel_value(crc: int) -> int:
    """Return what the channel `rules` shows for the set in force: 0 for the paper's, also if it was sent."""
    return 0 if crc == crc_of(paper()) else crc
