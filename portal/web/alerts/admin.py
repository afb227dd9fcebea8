"""Admin pages of alerts and of the messages about them; nobody changes them."""

from django.contrib import admin

from portal.web.alerts.models import Alert, AlertMessage
from robots.admin.bases import ReadOnlyAdmin


@admin.register(Alert)
class AlertAdmin(ReadOnlyAdmin):
    """The times that robots needed staff."""

    list_display = ("robot", "kind", "text", "seen_at", "told_at", "ended_at")
    sentences = ("text",)
    list_filter = ("robot", "kind")


@admin.register(AlertMessage)
class AlertMessageAdmin(ReadOnlyAdmin):
    """Who was told of alerts, and what went wrong."""

    list_display = ("alert", "over", "user", "state", "tries", "sent_at", "error")
    sentences = ("error",)
    list_filter = ("state", "over")
