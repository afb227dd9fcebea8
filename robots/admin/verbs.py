"""Verbs of a robot's admin page, and hooks that run after staff add a robot. Each returns a sentence for staff."""

from collections.abc import Callable
from functools import wraps

from django.http import HttpRequest
from django.utils.translation import gettext, gettext_lazy

from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract import procedures
from robots.kit.contract.errors import BadRequest, RobotError
from robots.kit.contract.find import spec_or_none
from robots.kit.contract.spec import STAFF, TURN, CommandKind, Spec
from robots.kit.plain import NUMERAL
from robots.models import Robot
from robots.sentences import translate
from robots.services import probes
from robots.services.permissions import need_staff
from robots.states import Cycle

Verb = Callable[[Robot, HttpRequest], str]
Load = Callable[[Robot], str]
AFTER_ADDING: list[Load] = []
STOPPED = gettext_lazy("The robot is stopped: look at the newest picture, then release the stop.")

LOCKED = gettext_lazy("Locked out. People keep their places.")


def _stays_stopped(robot: Robot) -> str:
    robot.refresh_from_db()
    return str(STOPPED) if robot.stop_latched else ""


def staff_only(verb: Verb) -> Verb:
    """Make a verb raise NotStaff for people who may not change robots."""

    @wraps(verb)
    def checked(robot: Robot, request: HttpRequest) -> str:
        need_staff(request.user)
        return verb(robot, request)

    return checked


@staff_only
def enable(robot: Robot, request: HttpRequest) -> str:
    """Switch the robot on."""
    if robot.enabled:
        return gettext("The robot is on already.")
    services.set_enabled(robot, request.user, True)
    done = gettext("Switched on; the supervisor starts its worker.")
    return f"{done} {_stays_stopped(robot)}".strip()


@staff_only
def disable(robot: Robot, request: HttpRequest) -> str:
    """Stop the robot, then end its processes."""
    services.set_enabled(robot, request.user, False)
    return gettext("Switched off; it was stopped first.")


@staff_only
def stop(robot: Robot, request: HttpRequest) -> str:
    """Hold the robot at once; it does not move until the stop is released."""
    services.stop(robot, request.user)
    return (
        gettext("Stop was sent.")
        if robot.enabled
        else gettext("The robot is off; it stays stopped when it is switched on.")
    )


@staff_only
def release(robot: Robot, request: HttpRequest) -> str:
    """Release the stop after a look at the robot."""
    if not robot.stop_latched:
        return gettext("The robot is not stopped.")
    services.release_stop(robot, request.user, request.POST.get("checked") == "yes")
    return gettext("The stop is released; nothing moves until somebody gives a command.")


@staff_only
def lock_out(robot: Robot, request: HttpRequest) -> str:
    """Close the robot to drivers; the note says why. The open turn ends, places stay."""
    services.lock_out(robot, request.user, request.POST.get("note", ""))
    return str(LOCKED)


@staff_only
def lift(robot: Robot, request: HttpRequest) -> str:
    """Let people drive again, after the release of the stop."""
    if robot.cycle != Cycle.LOCKED_OUT:
        return gettext("The robot is not locked out.")
    services.lift_lock_out(robot, request.user)
    done = gettext("The lock-out is lifted.")
    return f"{done} {STOPPED}"


@staff_only
def maintenance(robot: Robot, request: HttpRequest) -> str:
    """Give the member of staff a turn of 30 minutes at a robot; with a note, lock it out before."""
    locks = robot.cycle != Cycle.LOCKED_OUT and bool(request.POST.get("note", "").strip())
    if locks:
        services.need_worker(robot, SYSTEM.now())  # else nobody could drive it, and it would be closed for nothing
        services.lock_out(robot, request.user, request.POST["note"])
    try:
        services.start_maintenance(robot, request.user)
    except RobotError as error:
        if not locks:
            raise
        return f"{LOCKED} {translate(error)}"
    return gettext("You drive now, for 30 minutes. Release the stop first. When you are done, press “End maintenance”.")


@staff_only
def end_maintenance(robot: Robot, request: HttpRequest) -> str:
    """End the maintenance turn, of whoever drives; the robot stays locked out."""
    if not services.end_maintenance(robot, request.user):
        return gettext("No maintenance turn runs.")
    return gettext("The maintenance turn is over. The robot stays locked out.")


def _queued(kind: CommandKind) -> str:
    return gettext("{command}: queued; the command history shows its result.").format(command=translate(kind.label))


@staff_only
def procedure(robot: Robot, request: HttpRequest) -> str:
    """Run the procedure `kind`, if the robot offers it to staff."""
    found = procedures.procedure(robot.driver, request.POST.get("kind", ""))
    if found is None:
        raise BadRequest(gettext("This robot has no such procedure."))
    services.staff_command(robot, request.user, found.kind)
    return _queued(found)


def settings_by_staff(spec: Spec) -> tuple[CommandKind, ...]:
    """Return the settings of a robot that staff alone change, each with numbers alone."""
    return tuple(
        c
        for c in spec.commands
        if c.lane == "config" and c.open_to(STAFF) and not c.open_to(TURN) and not any(a.text for a in c.arguments)
    )


@staff_only
def setting(robot: Robot, request: HttpRequest) -> str:
    """Change the setting `kind` of the robot, with the numbers of its form."""
    spec, kind = spec_or_none(robot.driver), request.POST.get("kind", "")
    found = next((c for c in settings_by_staff(spec) if c.kind == kind), None) if spec is not None else None
    if found is None:
        raise BadRequest(gettext("This robot has no such setting."))
    args = {}
    for argument in found.arguments:
        text = request.POST.get(argument.name, "").strip()[:40]
        if text or argument.required:
            if not NUMERAL.fullmatch(text):
                words = gettext("The value {name} must be a number.")
                raise BadRequest(words.format(name=translate(argument.title)))
            args[argument.name] = float(text)
    services.configure(robot, request.user, found.kind, args)
    return _queued(found)


@staff_only
def test(robot: Robot, request: HttpRequest) -> str:
    """Test the connection; an enabled robot that nobody uses also takes a picture, if it has a camera."""
    if not robot.enabled:
        probes.ask(robot, request.user, SYSTEM.now())
        return gettext("The connection is being tested; the result appears below in some seconds.")
    services.need_worker(robot, SYSTEM.now())
    if robot.cycle == Cycle.FAULT:
        words = gettext("The robot is on, and its worker answers, but has a fault: {reason}")
        return words.format(reason=translate(robot.reason))
    in_use = services.open_grant(robot)
    if (
        robot.stop_latched
        or in_use is not None
        or procedures.PICTURE not in procedures.offered_procedures(robot.driver)
    ):
        if robot.stop_latched:
            return gettext("The robot is on, and its worker answers; it is stopped, so no picture was taken.")
        if in_use is not None:
            return gettext("The robot is on, and its worker answers; it is in use, so no picture was taken.")
        return gettext("The robot is on, and its worker answers.")
    services.staff_command(robot, request.user, procedures.PICTURE.kind)
    return gettext("The robot is on: a new picture was asked for; see the command history.")


def add(verb: Verb) -> Verb:
    """Offer a verb of another app on the robot's admin page too, by its name."""
    VERBS[verb.__name__] = verb
    return verb


def after_adding(load: Load) -> Load:
    """Call a function of another app for each robot that staff add; staff see the text that it returns."""
    AFTER_ADDING.append(load)
    return load


OWN = (enable, disable, stop, release, lock_out, lift, maintenance, end_maintenance, procedure, setting, test)
VERBS: dict[str, Verb] = {verb.__name__: verb for verb in OWN}
