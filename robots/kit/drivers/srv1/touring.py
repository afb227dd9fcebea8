"""Carries out a mission, one step after the other, and reports the findings of each."""

from collections.abc import Callable

from robots.kit.contract.errors import GaveUp, RobotError
from robots.kit.contract.session import JSON, Observation, OnStage, Permit, Progress
from robots.kit.drivers.srv1.answers import Status
from robots.kit.drivers.srv1.locating import Locating, Looked
from robots.kit.drivers.srv1.missions import Step, parse
from robots.kit.drivers.srv1.motions import Began, Left, Motions
from robots.kit.drivers.srv1.pictures import NONE, Pictures
from robots.kit.drivers.srv1.ways import Place
from robots.kit.drivers.srv1.wheels import compass_deg
from robots.kit.rovers.grid import TURNS

READINGS = ("temperature", "humidity", "light", "presence", "infrared", "sonar")


def observer(pictures: Pictures, on_stage: OnStage) -> Looked:
    """Return a function that records each reading of a look around, with a picture where the line carries one.

    After one picture that did not come no other is requested, so that a lost camera costs a moment, not minutes.
    """
    missed = pictures.missed_count

    def looked(number: int, status: Status) -> None:
        if number == 1 and pictures.size is None:
            on_stage(Observation(f"looks around {NONE}"))
        values = {"compass": compass_deg(status), "infrared": status.infrared, "sonar": status.sonar}
        wanted = pictures.size is not None and pictures.missed_count == missed
        on_stage(Observation(f"look {number} of {TURNS}", values, photograph=wanted))

    return looked


def go_to(
    place: Place, motions: Motions, locating: Locating, permit: Permit, began: Began, left: Left,
    tell: Callable[[str], None],
) -> float:  # fmt: skip
    """Go to a place: look around before and after it if the rover's place is not certain enough (section 7.2).

    An obstacle may be in the way because the rover is elsewhere than it believes: then it looks around and tries once
    more. Returns how long the ways were (m). Raises GaveUp, OutOfWorkspace.
    """
    if locating.is_unsure:
        locating.find(permit, began, tell)
    try:
        metres = motions.go(place, permit, began, left)
        if not locating.is_unsure:
            return metres
    except GaveUp:
        metres = 0.0
    locating.find(permit, began, tell)
    return metres + motions.go(place, permit, began, left)


def tour(
    text: str, motions: Motions, locating: Locating, pictures: Pictures, permit: Permit, began: Began, on_stage: OnStage
) -> JSON:
    """Carry out the mission; return how many steps it had.

    Raises what its steps raise, with the step's number and words before the sentence.
    """
    steps = parse(text)
    permit()
    began()
    for number, step in enumerate(steps, 1):
        share = (number - 1) / len(steps)

        def tell(words: str = "", written: str = _named(step), number: int = number, share: float = share) -> None:
            alone, more = (
                f"step {number} of {len(steps)}: {written}",
                f"step {number} of {len(steps)}: {written}, {words}",
            )
            on_stage(Progress(more if words else alone, share))

        tell()
        try:
            _do(step, motions, locating, pictures, permit, tell, on_stage)
        except RobotError as error:
            written = _named(step)
            error.args = (f"Step {number} of {len(steps)}, {written}: {error}",)
            raise
    return {"steps": len(steps)}


def _do(
    step: Step, motions: Motions, locating: Locating, pictures: Pictures, permit: Permit,
    tell: Callable[[str], None], on_stage: OnStage,
) -> None:  # fmt: skip
    def began() -> None:
        """A mission has begun once."""

    if step.verb == "go":
        place = step.numbers[0], step.numbers[1]
        go_to(place, motions, locating, permit, began, lambda metres, _: tell(f"{metres:.1f} m to go"), tell)
    elif step.verb == "turn":
        motions.turn(step.numbers[0], permit, began)
    elif step.verb == "wait":
        motions.wait(step.numbers[0], permit)
    elif step.verb == "patrol":
        motions.patrol(step.numbers[0], permit, began, tell)
    elif step.verb == "look":
        locating.look(permit, began, observer(pictures, on_stage))
    elif step.verb == "photograph":
        permit()
        given = pictures.size is not None
        on_stage(Observation("photograph" if given else f"photograph {NONE}", photograph=given))
    elif step.verb == "read":
        on_stage(Observation("readings", _readings(motions, READINGS)))
    else:
        on_stage(Observation(step.words))


def _named(step: Step) -> str:
    """Return a step as everybody may read it: without the words that its author wrote."""
    return "say" if step.verb == "say" else str(step)


def _readings(motions: Motions, names: tuple[str, ...]) -> dict[str, float]:
    """Return what the rover's sensors read now, by name."""
    motions.wheels.ask()
    values = motions.wheels.newest.values
    return {name: values[name] for name in names if name in values}
