"""One answer for many who ask at about the same time: never older than the question, one work at a time."""

import asyncio

from hypothesis import given, settings
from hypothesis import strategies as st

from portal.live.shared import Shared


@given(st.lists(st.tuples(st.integers(0, 6), st.booleans()), min_size=1, max_size=20), st.integers(0, 5))
@settings(deadline=None)
def test_an_answer_is_worked_out_after_the_question_and_works_never_overlap(questions, steps):
    """`questions`: steps of the event loop before each, and whether who asks leaves before the answer."""

    async def run():
        works, asked, running = 0, 0, 0

        async def work():
            nonlocal works, running
            assert not running
            running, works = 1, works + 1
            seen = asked
            for _ in range(steps):
                await asyncio.sleep(0)
            running = 0
            return str(seen)

        shared, waiting = Shared(work), []

        async def ask():
            nonlocal asked
            asked += 1
            mine = asked
            assert int(await shared.ask()) >= mine

        for pause, leaves in questions:
            for _ in range(pause):
                await asyncio.sleep(0)
            waiting.append(asyncio.create_task(ask()))
            await asyncio.sleep(0)
            if leaves:
                waiting.pop().cancel()
        await asyncio.gather(*waiting)
        while not shared.idle():
            await asyncio.sleep(0)
        assert works <= asked

    asyncio.run(run())


def test_many_who_ask_at_once_cost_two_works_and_a_failure_is_told_to_all():
    async def run():
        works = 0

        async def work():
            nonlocal works
            works += 1
            await asyncio.sleep(0.01)
            if works == 2:
                raise ValueError("no")
            return "yes"

        shared = Shared(work)
        first = asyncio.create_task(shared.ask())
        await asyncio.sleep(0.001)
        rest = [asyncio.create_task(shared.ask()) for _ in range(100)]
        assert await first == "yes"
        told = await asyncio.gather(*rest, return_exceptions=True)
        assert works == 2
        assert {str(one) for one in told} == {"no"}
        assert shared.idle()
        assert await shared.ask() == "yes"

    asyncio.run(run())
