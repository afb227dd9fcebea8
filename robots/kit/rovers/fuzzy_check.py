"""Checks a rule set: the rover has the readings, and can stop before what its infrared sensor sees."""

from collections.abc import Mapping
from dataclasses import dataclass

from robots.kit.rovers.fuzzy import TERMS, RuleSet, rule_name


@dataclass(frozen=True)
class Braking:
    """Figures of the rover's braking (SI units).

    deceleration: the least with which it slows down; reaction_s: until it does; margin: what a distance read by the
    infrared sensor may be too long, and how far the sensor is from the front; stop: the distance of the reflex;
    far: the farthest distance that the sensor reads; most: the fastest that it is let go.
    """

    deceleration: float
    reaction_s: float
    margin: float
    stop: float
    far: float
    most: float

    def needs(self, speed: float) -> float:
        """Return the distance (m) that must be read at this speed, so that it stops before what stands there."""
        return self.margin + speed * self.reaction_s + speed * speed / (2 * self.deceleration)


def check(rules: RuleSet, readings: Mapping[str, str], braking: Braking) -> None:
    """Raise ValueError with a sentence unless the rover may drive by these rules.

    `readings`: what the rover has, name to unit. A rule counts wherever its infrared term is above 0, so from the peak
    of the term before it on; nearer than `stop` the reflex halts the rover whatever the rules say. At the least
    distance d at which a rule counts, its own speed v must satisfy v * reaction + v^2 / (2 * deceleration) + margin
    <= d. Then so does every speed between those of the rules that count at d, and with it the speed that results.
    Where infrared is no input, each rule may count at any distance, so d is `stop`.
    """
    for variable in rules.inputs:
        if variable.name not in readings:
            raise ValueError(f"The rover has no reading {variable.name}; it has {', '.join(readings)}.")
        if variable.unit != readings[variable.name]:
            raise ValueError(f"The {variable.name} is read in {readings[variable.name]}, not in {variable.unit}.")
    for i in range(TERMS):
        for j in range(TERMS):
            name, fastest = rule_name(rules.inputs, i, j), _fastest(rules, rules.table[i][j])
            if fastest > braking.most:
                raise ValueError(f"{name} gives up to {fastest:.2f} m/s; the rover goes at most {braking.most:g}.")
            least = _least(rules, (i, j), braking)
            if braking.needs(fastest) > least:
                raise ValueError(
                    f"{name} is too fast: {fastest:.2f} m/s takes {braking.needs(fastest):.2f} m to stop, and the rule "
                    f"counts from {least:.2f} m on."
                )


def _least(rules: RuleSet, pair: tuple[int, int], braking: Braking) -> float:
    """Return the least infrared distance (m) above the reflex at which the rule counts, as far as that is seen."""
    for variable, term in zip(rules.inputs, pair, strict=True):
        if variable.name == "infrared" and term > 0:
            return min(max(braking.stop, variable.peaks[term - 1]), braking.far)
    return braking.stop


def _fastest(rules: RuleSet, term: int) -> float:
    """Return the highest speed (m/s) that can result where no rule that counts has a term above this one.

    A mean of peaks is at most the highest one. The centroid of a triangle that is longer on its right side lies beyond
    its peak, at most by half of the difference, which it has when it is clipped to a thin layer.
    """
    peaks = rules.output.peaks
    if rules.method == "sugeno" or term in (0, TERMS - 1):
        return peaks[term]
    return peaks[term] + max(0.0, peaks[term + 1] - 2 * peaks[term] + peaks[term - 1]) / 2
