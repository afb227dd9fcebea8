"""The snapshot: everything that a page needs to know about a robot, for one viewer."""

from datetime import datetime
from typing import Any

from django.db.models import QuerySet

from accounts.services import cleared, has_read
from operatorlog.models import Entry, Visibility
from operatorlog.services import hidden_of, may_see_picture
from portal.stores import trouble
from queueing.models import Turn
from queueing.services import (
    CLOSED,
    Forecast,
    end_of_turn,
    forecast,
    is_news,
    job_kinds,
    kinds_for,
    last_turn,
    offers_turns,
    open_ticket,
    open_turn,
    others_wait_since,
    place_and_wait,
    wait_if_joined,
    waiting,
    waits_for_staff,
)
from robots.grants import open_grant, rounded_without_texts, told_result, told_target
from robots.kit.clock import ms_of
from robots.models import Command, Frame, Grant, Robot
from robots.people import STAFF, driver_name, sees_names
from robots.sentences import english
from robots.services import StopShown, may_stop, newest_still, stop_shown
from robots.services.status import BY_ITSELF, status_of
from robots.states import Cycle, GrantEnd, GrantKind

RECENT, JOBS, ENTRIES = 8, 50, 5  # commands, open jobs and log entries that are listed
SOON_S = 15  # as long as a robot's page accepts an offer by itself after one press
BY_STAFF = (GrantKind.STAFF, GrantKind.UPKEEP)


def moves(state: str, label: str) -> bool:
    """Return whether something moves the robot now, by what `status_of` says: a person, a job, staff or itself."""
    return state in ("operating", "handover") or (state, label) == BY_ITSELF[GrantKind.IDLE][:2]


def is_free(state: str, label: str, queued: int, wait: tuple[int, int] | None) -> bool:
    """Return whether somebody who joins now drives at once: the robot rests, and nobody waits in an open queue."""
    return state == "ready" and not moves(state, label) and not queued and wait is not None


def is_soon(state: str, label: str, queued: int, wait: tuple[int, int] | None) -> bool:
    """Return whether somebody who joins now drives within seconds: the robot is free, or soon leaves what it does."""
    if is_free(state, label, queued, wait):
        return True
    leaves = (state, label) in {
        BY_ITSELF[GrantKind.IDLE][:2], BY_ITSELF[GrantKind.REST][:2], ("handover", english(Cycle.HANDOVER.label)),
    }  # fmt: skip
    return leaves and not queued and wait is not None and wait[1] <= SOON_S


def practice_info(robot: Robot) -> dict[str, Any] | None:
    """Return for which robot people practise on this one, and how long without an account (s); None on a robot."""
    if robot.practice_for is None:
        return None
    return {"slug": robot.practice_for.slug, "name": robot.practice_for.name, "guest_s": robot.guest_s}


def still_info(frame: Frame | None) -> dict[str, Any] | None:
    """Return the fields of a stored picture for the page."""
    if frame is None:
        return None
    return {
        "id": frame.pk, "url": frame.url, "at_ms": ms_of(frame.taken_at), "stable": frame.stable,
        "verdict": frame.verdict, "pose": rounded_without_texts(frame.pose),
        "joints": rounded_without_texts(frame.joints), "values": frame.values, "calibration": frame.calibration,
        "width": frame.width, "height": frame.height,
    }  # fmt: skip


def command_info(command: Command, viewer: Any = None) -> dict[str, Any]:
    """Return the fields of a command for the page's list, which everybody sees.

    Only the holder of the grant is named: a person who asks for a job chooses the name that its page shows.
    """
    holder = command.issued_by if command.issued_by_id == command.grant.holder_id else None
    return {
        "id": command.pk, "seq": command.client_seq, "grant": command.grant_id, "kind": command.kind,
        "state": command.state, "reason": command.reason, "result": told_result(command), "progress": command.progress,
        "at_ms": ms_of(command.reached_at), "seen_ms": ms_of(command.seen_picture_at),
        "newest_ms": ms_of(command.newest_picture_at), "clamping": command.clamping,
        "target": told_target(command),
        "by": driver_name(holder, viewer) if holder else "",
    }  # fmt: skip


def entry_info(entry: Entry) -> dict[str, Any]:
    """Return a log entry for the page."""
    return {
        "id": entry.pk, "author": entry.author_name, "text": entry.text, "at_ms": ms_of(entry.written_at),
        "picture": entry.frame.url if entry.frame else None, "featured": entry.visibility == Visibility.FEATURED,
    }  # fmt: skip


def jobs_shown(robot: Robot, now: datetime) -> list[dict[str, Any]]:
    """Return the open jobs in the order in which they will be served; none if the robot takes no jobs."""
    if not job_kinds(robot):
        return []
    return [job_info(one) for one in forecast(robot, now)[:JOBS]]


def job_info(one: Forecast) -> dict[str, Any]:
    """Return the fields of an open job that everybody may see; of its values only the numbers."""
    job = one.job
    return {
        "id": job.pk, "kind": job.kind, "state": job.state, "ahead": one.ahead, "wait_s": one.wait_s,
        "args": {name: value for name, value in job.args.items() if isinstance(value, int | float)},
    }  # fmt: skip


def newest_entries(robot: Robot) -> QuerySet[Entry]:
    """Return the newest log entries about a robot that everybody may see, with author and picture."""
    shown = Entry.objects.filter(robot=robot).exclude(visibility=Visibility.HIDDEN)
    return shown.select_related("author", "frame")[:ENTRIES]


def visible_frame(frame: Frame | None, user: Any) -> Frame | None:
    """Return the picture, unless the entry about its turn is hidden, and with it the picture from this person."""
    hidden = hidden_of(frame.grant_id) if frame is not None and frame.grant_id is not None else None
    return frame if frame is None or hidden is None or may_see_picture(hidden, frame.file, user) else None


def shown_still(robot: Robot, user: Any) -> Frame | None:
    """Return the newest picture, unless it is hidden from this person."""
    return visible_frame(newest_still(robot), user)


def snapshot(slug: str, user: Any, now: datetime, link: bool) -> dict[str, Any]:
    """Return everything about a robot that `user` may see."""
    robot = Robot.objects.get(slug=slug)
    state, label, why = status_of(robot, now)
    grant = open_grant(robot)
    turn, turns = open_turn(robot), offers_turns(robot)
    frame = newest_still(robot)
    before = Frame.objects.filter(robot=robot, pk__lt=frame.pk).order_by("-id").first() if frame else None
    mine, queued = _mine(grant, user), waiting(robot)
    wait = wait_if_joined(robot, now) if turns and not mine and state not in CLOSED else None
    if not mine:
        frame, before = visible_frame(frame, user), visible_frame(before, user)
    return {
        "t": "snapshot",
        "now_ms": ms_of(now),
        "link": link,
        "store": trouble(),
        "robot": {
            "slug": robot.slug,
            "name": robot.name,
            "simulated": robot.simulated,
            "state": state,
            "label": label,
            "why": why,
            "turns": turns,
            "practice": practice_info(robot),
            "moves": moves(state, label),
            "free": is_free(state, label, queued, wait),
            "soon": is_soon(state, label, queued, wait),
        },
        "stopped": robot.stop_latched,
        "suspended": waits_for_staff(robot),
        "stop": _stop(stop_shown(robot, now)),
        "operator": operator_name(turn, grant, user),
        "queue": queued,
        "join_wait_s": wait,
        "jobs": jobs_shown(robot, now),
        "turn": _turn(robot, turn, grant, mine),
        "me": {**_me(robot, user, now, mine), "grant": grant.pk if grant is not None and mine else 0},
        "still": still_info(frame),
        "before": still_info(before),
        "commands": [
            command_info(c, user)
            for c in Command.objects.filter(robot=robot).select_related("issued_by", "grant").order_by("-id")[:RECENT]
        ],
        "log": [entry_info(e) for e in newest_entries(robot)],
    }


def cheered_grant(whole: dict[str, Any]) -> int:
    """Return the key of the grant whose holder may be cheered, from a snapshot; 0: nobody may."""
    turn = whole["turn"]
    return turn["grant"] or 0 if turn and turn["cheers"] else 0


def of_person(slug: str, user: Any, now: datetime) -> dict[str, Any] | None:
    """Return the part of a snapshot that is only this person's; None if other parts differ: they drive or are staff."""
    robot = Robot.objects.get(slug=slug)
    return None if sees_names(user) or _mine(open_grant(robot), user) else {**_me(robot, user, now, False), "grant": 0}


def _mine(grant: Grant | None, user: Any) -> bool:
    driven = grant is not None and grant.kind != GrantKind.UPKEEP
    return grant is not None and driven and user.is_authenticated and grant.holder_id == user.pk


def _stop(shown: StopShown | None) -> dict[str, Any] | None:
    if shown is None:
        return None
    return {"confirmed": shown.confirmed, "since_ms": ms_of(shown.since), "rests_by_ms": ms_of(shown.rests_by)}


def operator_name(turn: Turn | None, grant: Grant | None, viewer: Any = None) -> str | None:
    """Return who drives, as the viewer may read it: a name or staff; None: nobody."""
    if turn is not None:
        return driver_name(turn.user, viewer)
    by_staff = grant is not None and grant.kind in BY_STAFF and grant.holder_id is not None
    return STAFF if by_staff else None


def _turn(robot: Robot, turn: Any, grant: Grant | None, mine: bool) -> dict[str, Any] | None:
    if turn is None and not (grant and grant.kind == GrantKind.STAFF):
        return None
    until = turn.until if turn else grant.until if grant else None
    last = grant.commands.order_by("-client_seq").values_list("client_seq", flat=True).first() if grant else None
    return {
        "id": turn.pk if turn else None, "grant": grant.pk if grant else None, "mine": mine,
        "until_ms": ms_of(until), "next_seq": (last or 0) + 1,
        "extra": bool(turn and turn.until > turn.base_until), "staff": turn is None,
        "wanted": turn is not None and others_wait_since(turn) is not None,
        "cheers": robot.takes_cheers,
    }  # fmt: skip


def _written(robot: Robot, turn: Turn) -> bool:
    """Return whether nothing is left to write about the turn; practice is in no log."""
    return robot.practice or hasattr(turn, "entry")


def _end(robot: Robot, turn: Turn) -> dict[str, Any]:
    """Return the fields of a turn that has ended."""
    end = end_of_turn(turn)
    return {
        "turn": turn.pk, "ended_ms": ms_of(turn.ended_at), "why": end.why, "credited": end.credited, "next": end.next,
        "own": turn.grant.end_code == GrantEnd.HOLDER, "written": _written(robot, turn),
    }  # fmt: skip


def _me(robot: Robot, user: Any, now: datetime, mine: bool) -> dict[str, Any]:
    can = {
        "watch": True, "drive": mine, "ask": robot.enabled and bool(kinds_for(robot, user)),
        "stop": may_stop(robot, user),
    }  # fmt: skip
    if not user.is_authenticated:
        return {"signed_in": False, "cleared": False, "read": False, "ticket": None, "can": can}
    ticket = open_ticket(robot, user)
    shown = None
    if ticket is not None:
        ahead, wait = place_and_wait(robot, ticket, now)
        shown = {
            "state": ticket.state, "ahead": ahead, "wait_s": wait,
            "offer_until_ms": ms_of(ticket.offer_until) if ticket.state == "offered" else None,
        }  # fmt: skip
    is_cleared, last = cleared(user, robot), last_turn(robot, user)
    written = last is not None and _written(robot, last)
    return {
        "signed_in": True, "guest": user.guest, "name": user.username, "cleared": is_cleared,
        "read": is_cleared or has_read(user, robot), "ticket": shown, "can": can,
        "staff": user.has_perm("robots.change_robot"),
        "last_turn": last.pk if last is not None and not written else None,
        "last_end": _end(robot, last) if last is not None and (is_news(last, now) or not written) else None,
    }  # fmt: skip
