"""Carries out a mission, a step after the other, and tells what each has found."""

from collections.abc import Callable
from math import tau

from robots.contract.errors import RobotError
from robots.contract.session import JSON, Noted, OnStage, Permit, Progress
from robots.drivers.permits import until_held
from robots.drivers.srv1.missions import SCAN_TURNS, Step, parse
from robots.drivers.srv1.motions import Began, Motions

READINGS = ("temperature", "humidity", "light", "presence", "infrared", "sonar")


def tour(text: str, motions: Motions, permit: Permit, began: Began, on_stage: OnStage) -> JSON:
    """Carry out the mission; return how many steps it had.

    Raises what its steps raise, with the step's number and words before the sentence.
    """
    steps = parse(text)
    free = until_held(permit, lambda: motions.wheels.holds)
    free()
    began()
    for number, step in enumerate(steps, 1):
        share = (number - 1) / len(steps)

        def tell(words: str = "", named: str = f"step {number} of {len(steps)}: {step}", share: float = share) -> None:
            on_stage(Progress(f"{named}{f', {words}' if words else ''}", share))

        tell()
        try:
            _do(step, motions, free, tell, on_stage)
        except RobotError as error:
            error.args = (f"Step {number} of {len(steps)}, {step}: {error}",)
            raise
    return {"steps": len(steps)}


def _do(step: Step, motions: Motions, permit: Permit, tell: Callable[[str], None], on_stage: OnStage) -> None:
    def began() -> None:
        """A mission has begun once."""

    if step.verb == "go":
        motions.go((step.numbers[0], step.numbers[1]), permit, began, lambda metres, _: tell(f"{metres:.1f} m to go"))
    elif step.verb == "turn":
        motions.turn(step.numbers[0], permit, began)
    elif step.verb == "wait":
        motions.wait(step.numbers[0], permit)
    elif step.verb == "patrol":
        motions.patrol(step.numbers[0], permit, began, tell)
    elif step.verb == "look":
        for number in range(SCAN_TURNS):
            motions.turn(tau / SCAN_TURNS, permit, began)
            on_stage(Noted(f"look {number + 1} of {SCAN_TURNS}", _readings(motions, ("infrared", "sonar"))))
    elif step.verb == "photograph":
        permit()
        on_stage(Noted("photograph", photograph=True))
    elif step.verb == "read":
        on_stage(Noted("readings", _readings(motions, READINGS)))
    else:
        on_stage(Noted(step.words))


def _readings(motions: Motions, names: tuple[str, ...]) -> dict[str, float]:
    """Return what the rover's sensors read now, by name."""
    motions.wheels.ask()
    values = motions.wheels.newest.values
    return {name: values[name] for name in names if name in values}
