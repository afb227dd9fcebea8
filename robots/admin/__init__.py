"""The admin of robots."""

from robots.admin.catalogue import RobotAdmin
from robots.admin.forms import RobotForm
from robots.admin.recordings import MovieAdmin, RecordingAdmin
from robots.admin.records import CommandAdmin, FrameAdmin, GrantAdmin, IncidentAdmin, ProgramAdmin

__all__ = (
    "CommandAdmin", "FrameAdmin", "GrantAdmin", "IncidentAdmin", "MovieAdmin", "ProgramAdmin", "RecordingAdmin",
    "RobotAdmin", "RobotForm",
)  # fmt: skip
