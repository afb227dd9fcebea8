"""Admin pages of queues: pause them, remove people, end turns."""

from typing import Any
from urllib.parse import urlencode

from django.contrib import admin
from django.http import HttpRequest
from django.urls import reverse
from django.utils.html import format_html, format_html_join
from django.utils.safestring import SafeString
from django.utils.translation import gettext, gettext_lazy

from queueing.models import Account, Job, JobState, LostConnection, Queue, QueueRobot, Ticket, Turn
from queueing.rows import links_of
from queueing.services import (
    RESUMED,
    Asker,
    cancel,
    end_by_staff,
    label_of,
    open_turn,
    remove_by_staff,
    resume,
    waiting_people,
)
from robots.admin.bases import (
    FormFieldsAdmin,
    NamedInline,
    NamedRowsAdmin,
    NamedValues,
    ReadOnlyAdmin,
    clock_time,
)
from robots.admin.verbs import add, staff_only
from robots.grants import open_grant
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.people import shown_name
from robots.sentences import in_digits, translate

NAMED, LISTED = 5, 100  # people of a queue in its row of the list, and on its page


@add
@staff_only
def resume_jobs(robot: Robot, request: HttpRequest) -> str:
    """Resume jobs, idle behaviour and needs after a stop."""
    resume(robot, request.user, SYSTEM.now())
    return translate(RESUMED)


class LinkInline(NamedInline):
    """The robots that a queue serves."""

    model = QueueRobot
    extra = 0


def _moved_by(robot: Robot) -> str:
    turn, grant = open_turn(robot), open_grant(robot)
    if turn is not None:
        words = gettext("{operator} until {time}")
        return words.format(operator=shown_name(turn.operator_name), time=clock_time(turn.until))
    if grant is None:
        return gettext("nobody")
    return f"{grant.get_kind_display()}, {grant.holder}" if grant.holder_id else grant.get_kind_display()


@admin.register(Queue)
class QueueAdmin(FormFieldsAdmin, NamedRowsAdmin):
    """Pause a queue, choose its robots; see who drives them and who waits."""

    list_display = ("named", "drive", "wait", "paused", "guest_weight")
    list_editable = ("paused",)
    list_filter = ("robot_links__robot",)
    inlines = (LinkInline,)

    def get_list_display(self, request: HttpRequest) -> tuple[str, ...]:
        """Return the columns; names of people who wait are for those who may see places."""
        return tuple(name for name in self.list_display if name != "wait" or self._sees_places(request))

    def get_readonly_fields(self, request: HttpRequest, obj: Queue | None = None) -> tuple[str, ...]:
        """Return what the page of a queue shows beside its settings."""
        if obj is None:
            return ()
        return ("drive", "wait_in_order", "jobs") if self._sees_places(request) else ("drive", "jobs")

    @staticmethod
    def _sees_places(request: HttpRequest) -> bool:
        return request.user.has_perm("queueing.view_ticket") or request.user.has_perm("queueing.change_ticket")

    @admin.display(description=gettext_lazy("Name"), ordering="name")
    def named(self, queue: Queue) -> str:
        """Return its name; that of a queue to which staff have given none is in the reader's language."""
        return str(queue)

    @admin.display(description=gettext_lazy("Who drives"))
    def drive(self, queue: Queue) -> str:
        """Return who or what moves each of its robots now."""
        return "; ".join(f"{link.robot}: {_moved_by(link.robot)}" for link in links_of(queue)) or "-"

    @admin.display(description=gettext_lazy("Who waits"))
    def wait(self, queue: Queue) -> str:
        """Return how many people wait, and the first ones."""
        places = list(waiting_people(queue))
        more = "…" if len(places) > NAMED else ""
        return (
            f"{len(places)}: {', '.join(str(one.user) for one in places[:NAMED])}{more}"
            if places
            else gettext("nobody")
        )

    @admin.display(description=gettext_lazy("Who waits"))
    def wait_in_order(self, queue: Queue) -> SafeString | str:
        """Return the people who wait, in the order in which they will be served, each with the page of the place."""
        rows = [
            (reverse("admin:queueing_ticket_change", args=[one.pk]), one.user, one.get_state_display().lower(),
             clock_time(one.joined_at), clock_time(one.last_seen))
            for one in waiting_people(queue)[:LISTED]
        ]  # fmt: skip
        if not rows:
            return gettext("nobody")
        item = gettext('<a href="{}">{}</a>: {}; in the queue since {}, last seen {}')
        return format_html('<ol class="farhand-queue">{}</ol>', format_html_join("", f"<li>{item}</li>", rows))

    @admin.display(description=gettext_lazy("Jobs that wait"))
    def jobs(self, queue: Queue) -> SafeString | str:
        """Return how many jobs wait, with their list."""
        count = Job.objects.filter(queue=queue, state=JobState.WAITING).count()
        address = (
            f"{reverse('admin:queueing_job_changelist')}?{urlencode({'queue': queue.pk, 'state': JobState.WAITING})}"
        )
        return format_html('<a href="{}">{}</a>', address, count) if count else gettext("none")


@admin.register(Ticket)
class TicketAdmin(ReadOnlyAdmin):
    """Places in queues, the newest first."""

    list_display = ("user", "queue", "state", "start_tag", "joined_at", "last_seen", "end_reason")
    sentences = ("end_reason",)
    list_filter = ("queue", "queue__robot_links__robot", "state")
    ordering = ("-id",)
    actions = ("remove",)

    @admin.action(description=gettext_lazy("Take out of the queue"), permissions=["act"])
    def remove(self, request: HttpRequest, queryset: Any) -> None:
        """Take the chosen people out; a running turn is ended."""
        self.act_on(
            request, queryset, lambda one: remove_by_staff(one, request.user, SYSTEM.now()),
            gettext_lazy("Taken out of the queue"), gettext_lazy("Place ended before"),
        )  # fmt: skip


@admin.register(Turn)
class TurnAdmin(ReadOnlyAdmin):
    """Turns, running and ended."""

    list_display = ("id", "robot", "user", "started_at", "ended_at", "end_reason", "charged_s")
    sentences = ("end_reason",)
    list_filter = ("robot", ("end_reason", NamedValues))
    actions = ("end",)

    @admin.action(description=gettext_lazy("End the turn now"), permissions=["act"])
    def end(self, request: HttpRequest, queryset: Any) -> None:
        """End the chosen running turns."""
        self.act_on(
            request,
            queryset,
            lambda one: end_by_staff(one, request.user, SYSTEM.now()),
            gettext_lazy("Ended"),
            gettext_lazy("Ended before"),
        )


@admin.register(LostConnection)
class LostConnectionAdmin(ReadOnlyAdmin):
    """Connections of operators that ended during their turns, with cause and side."""

    list_display = ("at", "turn", "cause", "side")
    list_filter = ("turn__robot", "cause")

    @admin.display(description=gettext_lazy("Side"))
    def side(self, lost: LostConnection) -> str:
        """Return on which side the cause was."""
        return lost.side


@admin.register(Job)
class JobAdmin(ReadOnlyAdmin):
    """Jobs, open and ended."""

    list_display = ("id", "robot", "kind", "user", "state", "reason", "start_tag", "asked_at", "ended_at", "charged")
    sentences = ("reason",)
    words = {"kind": lambda job: translate(label_of(job.robot, job.kind))}
    list_filter = ("robot", "state")
    actions = ("cancel",)

    @admin.action(description=gettext_lazy("Cancel"), permissions=["act"])
    def cancel(self, request: HttpRequest, queryset: Any) -> None:
        """Cancel the chosen open jobs; the robot holds."""
        asker = Asker(user=request.user)
        self.act_on(
            request,
            queryset,
            lambda one: cancel(one, asker, SYSTEM.now()),
            gettext_lazy("Cancelled"),
            gettext_lazy("Ended before"),
        )


@admin.register(Account)
class AccountAdmin(FormFieldsAdmin):
    """The use of people and guests, and their weight."""

    list_display = ("__str__", "queue", "network", "used", "weight")
    fields = ("queue", "user", "network", "used", "weight")
    readonly_fields = ("user", "network", "queue", "used")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Return False: an account begins with the first place or job."""
        return False

    @admin.display(description=Account._meta.get_field("finish_tag").verbose_name, ordering="finish_tag")
    def used(self, account: Account) -> str:
        """Return the finish tag."""
        return in_digits(account.finish_tag)
