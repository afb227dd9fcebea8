"""The package of a program on the robot's own machine: what it carries out, equal to the database's, and its step.

It is written before anything moves, so an owner that is killed leaves behind what it was doing: the next one says so.
"""

import hashlib
import json
import logging
from pathlib import Path
from typing import Any

from robots.kit.contract.errors import BadRequest, GaveUp
from robots.kit.files import replaced
from robots.kit.plain import storable
from robots.models import Command
from robots.services.programs import is_program

log = logging.getLogger(__name__)
LARGEST = 100_000  # bytes of a package
NOT_STORED = "The program could not be stored on the robot's machine, so nothing was moved: its disk may be full."


def step_of(command: Command) -> str:
    """Return at which step a program was when its progress was stored last, in words; empty for what is none."""
    return _step(str(command.progress.get("text") or "")) if is_program(command.robot, command.kind) else ""


def _step(words: str) -> str:
    """Return what stands before the first comma of a progress, which is the step; after it is how far that is."""
    return words.partition(",")[0]


class Packages:
    """The packages of one robot, in `folder`."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._noted = folder, (0, "")

    def begin(self, command: Command) -> str:
        """Store a program before it runs, and read it again; return its SHA-256, empty for what is no program.

        Raises:
            BadRequest: the text cannot be written. GaveUp: the machine does not have what the database has.
        """
        text = command.args.get("text")
        if not is_program(command.robot, command.kind) or not isinstance(text, str):
            return ""
        if not storable(text):  # as rows of an earlier version may hold
            raise BadRequest("The program contains characters that cannot be stored; use plain text.")
        digest, self._noted = hashlib.sha256(text.encode()).hexdigest(), (0, "")
        self._write(command, {"sha256": digest, "text": text, "at": ""}, sync=True)
        read = self._read(command.pk)
        if hashlib.sha256(str(read.get("text", "")).encode()).hexdigest() != digest:
            raise GaveUp(NOT_STORED)
        return digest

    def reached(self, command: Command, words: str) -> None:
        """Note at which step a program is. A disk that is full costs the note alone."""
        words = _step(words)
        told = self._read(command.pk) if (command.pk, words) != self._noted else {}
        self._noted = command.pk, words
        if told:
            try:
                self._write(command, {**told, "at": words})
            except GaveUp as error:
                log.warning("the step of %s is not noted: %s", command, error)

    def end(self, command: Command) -> None:
        """Forget a program that has ended."""
        self._path(command.pk).unlink(missing_ok=True)

    def left_at(self, command: Command) -> str:
        """Return at which step a program is or was, in words; empty if that is not known, and for what is none."""
        return str(self._read(command.pk).get("at") or step_of(command))

    def _path(self, number: int) -> Path:
        return self._folder / f"{number}.json"

    def _write(self, command: Command, told: dict[str, Any], sync: bool = False) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with replaced(self._path(command.pk), sync) as out:
                out.write(json.dumps(told).encode())
        except OSError as error:
            raise GaveUp(NOT_STORED) from error

    def _read(self, number: int) -> dict[str, Any]:
        try:
            with self._path(number).open("rb") as file:
                told = json.loads(file.read(LARGEST))
        except (OSError, ValueError):
            return {}
        return told if isinstance(told, dict) else {}
