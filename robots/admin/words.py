"""Words for codes that rows hold: kinds of commands, and what incidents are about."""

from typing import Any

from django.utils.translation import gettext_lazy

from robots.admin.bases import NamedValues
from robots.models import Grant, Robot
from robots.models.words import label_of
from robots.sentences import translate
from robots.states import CommandState

INCIDENTS = {
    "calibration": gettext_lazy("Calibration"), "camera_fault": gettext_lazy("Camera"),
    "controller_refused": gettext_lazy("Refused by the controller"),
    "controller_restarted": gettext_lazy("Controller started again"), "form": gettext_lazy("Answer not understood"),
    "gave_up": gettext_lazy("Given up"), "hardware_fault": gettext_lazy("Machine"),
    "line_busy": gettext_lazy("Line in use elsewhere"), "line_gone": gettext_lazy("Line lost"),
    "line_silent": gettext_lazy("No answer on the line"), "microphone": gettext_lazy("Microphone"),
    "outage": gettext_lazy("No answer of the worker"), "stop_failed": gettext_lazy("Stop failed"),
    "untidy": gettext_lazy("Not tidied up"),
}  # fmt: skip


def incident_words(code: str) -> str:
    """Return what an incident is about; a code of a package of its own as it is written."""
    return str(INCIDENTS.get(code, code.replace("_", " ").capitalize()))


def end_words(grant: Grant) -> str:
    """Return why a grant ended; that of one command is stored as the command's kind and state."""
    kind, _, state = grant.end_reason.partition(": ")
    if state not in CommandState.values:
        return translate(grant.end_reason)
    return f"{translate(label_of(grant.robot.driver, kind))}: {CommandState(state).label}"


class NamedIncidents(NamedValues):
    """A filter by what incidents are about."""

    def named(self, value: str) -> str:
        """Return the words of a code."""
        return incident_words(value)


class NamedKinds(NamedValues):
    """A filter by kinds of commands: each by its label, with its code beside, as two kinds may have one label."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._drivers = tuple(Robot.objects.order_by("pk").values_list("driver", flat=True))

    def named(self, value: str) -> str:
        """Return the label of the first robot that has the kind."""
        plain = label_of("", value)
        labels = (label_of(driver, value) for driver in self._drivers)
        label = next((label for label in labels if label != plain), plain)
        return f"{translate(label)} ({value})"
