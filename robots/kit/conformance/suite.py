"""The suite: every check that a driver has to pass, over one robot, real or simulated.

It moves the robot to the ends of its ranges and disturbs it. It waits by the clock of the session under test, with
generous limits, and compares no measured times: a slow robot, or a slow machine, passes.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

from robots.kit.clock import Timer
from robots.kit.conformance import beside, commands, holds, lines, resting, states, steering
from robots.kit.conformance.report import NotApplicable, Note, Report, Result, Verdict
from robots.kit.conformance.runs import error_text
from robots.kit.conformance.trial import Broken, Faults, Limits, Opening, Trial
from robots.kit.contract.session import JSON
from robots.kit.contract.spec import Spec

Check = Callable[[Trial], Iterator[str]]
CHECKS: dict[str, Check] = {
    "spec": states.spec,
    "connect": states.connect,
    "values": commands.values,
    "permit": commands.permit,
    "commands": commands.carried_out,
    "state": states.state,
    "hold": holds.hold,
    "held motions": holds.held_kinds,
    "steered": steering.steered,
    "replaced": holds.replaced,
    "policies": states.policies,
    "time left": resting.time_left,
    "lanes": beside.lanes,
    "recovery": lines.recovery,
    "close in motion": lines.close_under_motion,
    "lost line": lines.lost_line,
    "rests within": resting.rests_within,
    "lost power": lines.lost_power,
    "noise": lines.noise,
    "pictures": beside.pictures,
    "streams": beside.streams,
    "end": beside.end,
}
HEARD = ("streams",)  # judged by earlier packets, so also if the robot cannot be reached any more


def conform(
    opening: Opening, spec: Spec, clock: Timer, *, name: str = "", limits: Limits | None = None,
    description: Mapping[str, object] | None = None, examples: Mapping[str, Sequence[JSON]] | None = None,
    faults: Callable[[], Faults | None] = lambda: None, nowhere: Opening | None = None,
    pictures: Callable[[], Mapping[str, str]] = dict, only: Sequence[str] = (),
    told: Callable[[Result], None] = lambda _: None,
) -> Report:  # fmt: skip
    """Run the checks and return what they found; a driver's errors are results, never raised.

    `opening` makes a session that is not connected; `clock` is the one that the session reads (`Session.clock`).
    `name` is the driver's, where it is installed. `description` is its robot.toml, `examples` are values with which
    kinds can be carried out, `faults` returns the board of its simulator, `nowhere` makes a session whose address leads
    nowhere, `pictures` returns the addresses of cameras by view. `only` are names of `CHECKS`; `told` is called with
    each result at once.
    """
    trial = Trial(
        opening, spec, clock, limits or Limits(), name, dict(description or {}), dict(examples or {}), faults, nowhere,
        pictures,
    )  # fmt: skip
    results: list[Result] = []
    broken = ""
    for check, function in CHECKS.items():
        if only and check not in only:
            continue
        result = _made(trial, check, function, "" if check in HEARD else broken)
        broken = broken or _out_of_order(trial, check)
        results.append(result)
        told(result)
    trial.close()
    return Report(name or spec.name, tuple(results))


def _made(trial: Trial, check: str, function: Check, broken: str) -> Result:
    if broken:
        return Result(check, Verdict.NOT_APPLICABLE, (broken,))
    wrong: list[str] = []
    try:
        wrong.extend(function(trial))
    except NotApplicable as reason:
        if not wrong:
            return Result(check, Verdict.NOT_APPLICABLE, (f"{str(reason)[:1].upper()}{str(reason)[1:]}.",))
    except Broken as error:
        wrong.append(str(error))
    except Exception as error:  # noqa: BLE001 - of the driver, which the check called
        wrong.append(f"The driver raised {error_text(error)}; errors are those of robots/kit/contract/errors.py.")
    faults = [word for word in wrong if not isinstance(word, Note)]
    notes = [word for word in wrong if isinstance(word, Note)]
    return Result(check, Verdict.FAILED if faults else Verdict.PASSED, (*faults, *notes))


def _out_of_order(trial: Trial, check: str) -> str:
    """Make the robot ready for the next check; return why that is not possible, or an empty text."""
    if trial.session is None:
        return ""
    try:
        trial.settle()
    except Broken as error:
        return f"The robot is not in order after the check {check!r}: {error}"
    except Exception as error:  # noqa: BLE001 - of the driver
        return f"The robot is not in order after the check {check!r}: {error_text(error)}."
    return ""
