"""The rule sets that this rover is sent: which readings they may use, and how it brakes."""

from robots.autonomy.fuzzy import RuleSet
from robots.autonomy.fuzzy_check import Braking, check
from robots.autonomy.fuzzy_text import parse
from robots.contract.errors import BadRequest
from robots.description import load

READINGS = {
    "infrared": "m", "sonar": "m", "battery": "V", "temperature": "C", "humidity": "%", "light": "%",
}  # fmt: skip
NOISES = 3  # standard deviations of a distance


def braking() -> Braking:
    """Return how the rover stops, by its robot.toml.

    It is taken to slow down as rules let it, which is less than what it brakes with when it is held; and to react as
    late as a velocity is forgotten.
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
