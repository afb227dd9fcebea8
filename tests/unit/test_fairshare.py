import pytest
from hypothesis import given
from hypothesis import strategies as st

from queueing import fairshare
from queueing.fairshare import Clock


@given(st.lists(st.tuples(st.integers(0, 4), st.floats(1, 300)), min_size=20, max_size=120))
def test_two_who_always_wait_never_drift_apart_by_more_than_two_turns(demand):
    """Start-time fair queueing's bound: their service differs by at most a turn of each."""
    finish, served = dict.fromkeys(range(5), 0.0), dict.fromkeys(range(5), 0.0)
    clock = Clock()
    tags = {u: fairshare.start_tag(clock, 0.0) for u in range(5)}
    for _, seconds in demand:
        user = min(tags, key=lambda u: (tags[u], u))
        clock = clock.serve(tags[user])
        finish[user] = fairshare.finish_tag(tags[user], seconds, 1.0)
        served[user] += seconds
        clock = clock.finish(finish[user])
        tags[user] = fairshare.start_tag(clock, finish[user])
        assert max(served.values()) - min(served.values()) <= 600


@given(st.lists(st.tuples(st.booleans(), st.floats(1, 300)), min_size=20, max_size=120))
def test_turns_and_jobs_of_people_who_always_wait_share_the_robot_by_their_weights(demand):
    """Ada drives, bob asks for jobs, guests with half his weight ask too: service over weight stays together."""
    weights = {"ada": 1.0, "bob": 1.0, "guests": 0.5}
    served = dict.fromkeys(weights, 0.0)
    clock, tags = Clock(), dict.fromkeys(weights, 0.0)
    for robots_fault, seconds in demand:
        who = min(tags, key=lambda u: (tags[u], u))
        clock = clock.serve(tags[who])
        if robots_fault and who != "ada":
            continue  # cut short: it keeps its tag, so it is next again, and costs nothing
        finish = fairshare.finish_tag(tags[who], seconds, weights[who])
        served[who] += seconds / weights[who]
        clock, tags[who] = clock.finish(finish), fairshare.start_tag(clock, finish)
        assert max(served.values()) - min(served.values()) <= 300 / 0.5 + 300


@given(st.floats(0, 1e6), st.floats(0, 1e6))
def test_absence_earns_no_credit(greatest, old_finish):
    clock = Clock(virtual=0.0, greatest_finish=greatest).empty()
    assert fairshare.start_tag(clock, min(old_finish, greatest)) == greatest


@given(st.floats(0, 1e4), st.floats(0, 1e4))
def test_time_alone_costs_less_never_more(used, alone):
    assert 0 <= fairshare.chargeable_s(used, alone) <= used
    assert fairshare.chargeable_s(used, 0) == used


def test_a_heavier_weight_pays_less_and_none_is_refused():
    assert fairshare.finish_tag(10, 60, 2.0) == 40
    with pytest.raises(ValueError, match="positive"):
        fairshare.finish_tag(0, 1, 0)


LENGTHS = st.lists(st.integers(1, 4), max_size=50)
HANDOVERS = st.tuples(st.floats(0, 60), st.floats(0, 300)).map(lambda times: (times[0], sum(times)))


@given(LENGTHS, st.integers(1, 4), st.floats(0, 600), st.floats(30, 900), HANDOVERS)
def test_the_estimate_is_a_range_that_grows_with_the_queue(before, more, left, turn_s, handover_s):
    low, high = fairshare.estimate(len(before), sum(before), left, turn_s, handover_s)
    assert 0 <= low <= high
    later = fairshare.estimate(len(before) + 1, sum(before) + more, left, turn_s, handover_s)
    assert (later[0] >= low, later[1] >= high) == (True, True)


@given(LENGTHS, st.data(), st.floats(0, 600), st.floats(30, 900), HANDOVERS)
def test_people_with_longer_turns_take_no_longer_than_the_estimate_says(before, data, left, turn_s, handover_s):
    low, high = fairshare.estimate(len(before), sum(before), left, turn_s, handover_s)
    handover = st.floats(*handover_s)
    shares = [data.draw(st.tuples(st.floats(0, 1), st.floats(0.25, 1), handover)) for _ in before]
    waited = left + data.draw(handover)
    for length, (answer, used, took) in zip(before, shares, strict=True):
        waited += length * (answer * fairshare.ANSWER_S + used * turn_s) + took
    assert low - 1 <= waited <= high + 1


@given(st.lists(st.floats(1, 300), min_size=20, max_size=120), st.integers(1, 4))
def test_who_has_longer_turns_has_as_many_as_others(seconds, times):
    """Ada's turns are so many times as long and are charged as usual ones, as `end_turn` does it; bob's are usual."""
    clock, tags, turns = Clock(), {"ada": 0.0, "bob": 0.0}, {"ada": 0, "bob": 0}
    charged = dict.fromkeys(turns, 0.0)
    for usual_s in seconds:
        who = min(tags, key=lambda u: (tags[u], u))
        clock = clock.serve(tags[who])
        used_s = usual_s * (times if who == "ada" else 1)
        cost = used_s / (times if who == "ada" else 1)
        finish = fairshare.finish_tag(tags[who], cost, 1.0)
        charged[who] += cost
        turns[who] += 1
        clock, tags[who] = clock.finish(finish), fairshare.start_tag(clock, finish)
        assert abs(charged["ada"] - charged["bob"]) <= 600
