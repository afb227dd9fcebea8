"""Admin pages of queues: pause them, remove people, end turns."""

from typing import Any

from django.contrib import admin
from django.http import HttpRequest

from queueing.models import Account, Job, Queue, QueueRobot, Ticket, Turn
from queueing.services import RESUMED, Asker, cancel, end_by_staff, remove_by_staff, resume
from robots.admin.bases import FormFieldsAdmin, NamedInline, NamedRowsAdmin, NamedValues, ReadOnlyAdmin
from robots.admin.verbs import add, staff_only
from robots.kit.clock import SYSTEM
from robots.models import Robot


@add
@staff_only
def resume_jobs(robot: Robot, request: HttpRequest) -> str:
    """Resume jobs, idle behaviour and needs after a stop."""
    resume(robot, request.user, SYSTEM.now())
    return RESUMED


class LinkInline(NamedInline):
    """The robots that a queue serves."""

    model = QueueRobot
    extra = 0


@admin.register(Queue)
class QueueAdmin(FormFieldsAdmin, NamedRowsAdmin):
    """Pause a queue, choose its robots."""

    list_display = ("name", "paused", "guest_weight")
    list_editable = ("paused",)
    inlines = (LinkInline,)


@admin.register(Ticket)
class TicketAdmin(ReadOnlyAdmin):
    """Places in queues, the newest first."""

    list_display = ("user", "queue", "state", "start_tag", "joined_at", "last_seen", "end_reason")
    list_filter = ("queue", "state")
    ordering = ("-id",)
    actions = ("remove",)

    @admin.action(description="Take out of the queue", permissions=["act"])
    def remove(self, request: HttpRequest, queryset: Any) -> None:
        """Take the chosen people out; a running turn is ended."""
        self.act_on(
            request, queryset, lambda one: remove_by_staff(one, request.user, SYSTEM.now()),
            "Taken out of the queue", "Place ended before",
        )  # fmt: skip


@admin.register(Turn)
class TurnAdmin(ReadOnlyAdmin):
    """Turns, running and ended."""

    list_display = ("id", "robot", "user", "started_at", "ended_at", "end_reason", "charged_s")
    list_filter = ("robot", ("end_reason", NamedValues))
    actions = ("end",)

    @admin.action(description="End the turn now", permissions=["act"])
    def end(self, request: HttpRequest, queryset: Any) -> None:
        """End the chosen running turns."""
        self.act_on(
            request, queryset, lambda one: end_by_staff(one, request.user, SYSTEM.now()), "Ended", "Ended before"
        )


@admin.register(Job)
class JobAdmin(ReadOnlyAdmin):
    """Jobs, open and ended."""

    list_display = ("id", "robot", "kind", "user", "state", "reason", "start_tag", "asked_at", "ended_at", "charged")
    list_filter = ("robot", "state")
    actions = ("cancel",)

    @admin.action(description="Cancel", permissions=["act"])
    def cancel(self, request: HttpRequest, queryset: Any) -> None:
        """Cancel the chosen open jobs; the robot holds."""
        asker = Asker(user=request.user)
        self.act_on(request, queryset, lambda one: cancel(one, asker, SYSTEM.now()), "Cancelled", "Ended before")


@admin.register(Account)
class AccountAdmin(FormFieldsAdmin):
    """The use of people and guests, and their weight."""

    list_display = ("__str__", "queue", "network", "finish_tag", "weight")
    readonly_fields = ("user", "network", "queue", "finish_tag")

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Return False: an account begins with the first place or job."""
        return False
