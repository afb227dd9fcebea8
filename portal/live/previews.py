"""Previews for all sockets of this process: limited for each person, computed in a separate process.

No queue grows here: only the newest question of each person is kept, over all their sockets, and people are served in
turn. The process starts with the first question and ends when nobody has asked for a while.
"""

import asyncio
import contextlib
import json
import logging
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import msgspec
from django.conf import settings
from django.db import Error

from accounts.services import preview_job
from portal.live.messages import Plan
from portal.live.people import current_user
from portal.live.threads import Pool
from portal.stores import down_text
from robots.kit import previews
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.models import Robot

log = logging.getLogger(__name__)
EACH_S = 0.05  # between two previews of one person
REFUSED_S = 2.0  # until a person who may not ask is checked again
OVERRUN_S = 5.0  # pause of a person whose preview was cut off
ANSWER_S, START_S = 5.0, 30.0  # for an answer; for the first one, including the start of the process
IDLE_S = 120.0
PEOPLE = 100  # waiting at once
BUSY = "Too many people ask where their robot would go now; try again in a moment."
PREPARE = Pool("preview", 1)


class Asker(Protocol):
    """The page that asks for previews."""

    @property
    def closed(self) -> bool:
        """Return whether nobody waits for an answer any more."""

    def answer(self, text: str) -> None:
        """Receive an answer."""


@dataclass(frozen=True)
class Question:
    """A person's newest question, and the page that asks."""

    asker: Asker
    scope: dict[str, Any]
    slug: str
    message: Plan

    def refuse(self, text: str) -> None:
        """Answer with a sentence."""
        self.asker.answer(json.dumps({"t": "plan", "n": self.message.n, "ok": False, "text": text}))


def job_of(question: Question) -> previews.Job:
    """Return the job to compute. Raises NotPermitted, Robot.DoesNotExist."""
    robot, message = Robot.objects.get(slug=question.slug), question.message
    user = current_user(question.scope)
    return preview_job(robot, user, message.kind, dict(message.args), tuple(message.joints), message.n)


class Previewer:
    """The previews of one event loop."""

    def __init__(self, clock: Callable[[], float] = SYSTEM.awake) -> None:
        self._clock = clock
        self._waiting: dict[int, Question] = {}  # in the order of first questions
        self._rests: dict[int, tuple[float, str]] = {}  # until when, and the answer meanwhile
        self._asked = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self._process: asyncio.subprocess.Process | None = None
        self.computed, self.computing = 0, False

    def ask(self, person: int, question: Question) -> None:
        """Take the question of a person (0: not signed in); their older question is dropped."""
        if not person:
            question.refuse("Sign in first.")
            return
        until, text = self._rests.get(person, (0.0, ""))
        if text and until > self._clock():
            question.refuse(text)
        elif person not in self._waiting and len(self._waiting) >= PEOPLE:
            question.refuse(BUSY)
        else:
            self._waiting[person] = question  # it keeps the place of the older one
            self._asked.set()
            if self._task is None or self._task.done():
                self._task = asyncio.create_task(self._run())

    async def _run(self) -> None:
        try:
            while await self._asked_in_time():
                person = next((p for p in self._waiting if self._rest_of(p) <= 0), None)
                if person is None:
                    await asyncio.sleep(max(0.005, min(self._rest_of(p) for p in self._waiting)))
                    continue
                question = self._waiting.pop(person)
                if not question.asker.closed:
                    await self._serve(person, question)
        finally:
            await self._end()

    async def _asked_in_time(self) -> bool:
        if not self._waiting:
            now = self._clock()
            self._rests = {p: rest for p, rest in self._rests.items() if rest[0] > now}
            self._asked.clear()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(IDLE_S):
                    await self._asked.wait()
        return bool(self._waiting)

    def _rest_of(self, person: int) -> float:
        return self._rests.get(person, (0.0, ""))[0] - self._clock()

    async def _serve(self, person: int, question: Question) -> None:
        rest, text = EACH_S, ""
        try:
            job = await PREPARE.orm(job_of)(question)
            question.asker.answer((await self._compute(job)).decode())
        except NotPermitted as error:
            rest, text = REFUSED_S, str(error)
            question.refuse(text)
        except Robot.DoesNotExist:
            question.refuse("There is no such robot any more.")
        except Error as error:
            question.refuse(down_text(error))
        except (OSError, EOFError, TimeoutError, ValueError) as error:
            log.warning("a preview was cut off: %r", error)
            await self._end()
            rest, text = OVERRUN_S, previews.TOO_MUCH
            question.refuse(text)
        except Exception:
            log.exception("a preview failed")
            rest, text = OVERRUN_S, previews.TOO_MUCH
            question.refuse(text)
        self.computing = False
        self._rests[person] = (self._clock() + rest, text)

    async def _compute(self, job: previews.Job) -> bytes:
        """Return the answer. Raises OSError, EOFError, TimeoutError, ValueError; the process has to be ended then."""
        start = self._process is None or self._process.returncode is not None
        async with asyncio.timeout(START_S if start else ANSWER_S):
            if start:
                self._process = await asyncio.create_subprocess_exec(
                    sys.executable, "-m", "robots.kit.previews", cwd=settings.BASE_DIR,
                    stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
                    env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
                )  # fmt: skip
            assert self._process is not None
            source, sink = self._process.stdout, self._process.stdin
            assert source is not None
            assert sink is not None
            body = msgspec.msgpack.encode(job)
            self.computing = True
            sink.write(previews.LENGTH.pack(len(body)) + body)
            await sink.drain()
            (length,) = previews.LENGTH.unpack(await source.readexactly(previews.LENGTH.size))
            if length > previews.LARGEST:
                raise ValueError("an answer is too long")
            said = await source.readexactly(length)
        self.computed += 1
        return said

    async def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            await process.communicate()  # `wait` alone would wait for ever for bytes that come after an answer
