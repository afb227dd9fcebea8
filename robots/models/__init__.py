"""Database rows of robots, by subject."""

from robots.models.pictures import Finding, Frame, Program, frame_name
from robots.models.recordings import Movie, Recording, RecordingState, Records
from robots.models.robot import Command, Grant, Incident, Lease, Robot, Usage

__all__ = (
    "Command", "Finding", "Frame", "Grant", "Incident", "Lease", "Movie", "Program", "Recording", "RecordingState",
    "Records", "Robot", "Usage", "frame_name",
)  # fmt: skip
