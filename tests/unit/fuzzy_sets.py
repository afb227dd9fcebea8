"""Rule sets of all sorts for the tests: any peaks that rise, any labels, any table."""

from hypothesis import strategies as st

from robots.kit.drivers.srv1.rules import READINGS
from robots.kit.rovers.fuzzy import PAPER, RuleSet, Variable

METHODS = st.sampled_from(["sugeno", "mamdani"])
letters = st.sampled_from("abyzABYZ")
labels = st.builds(
    lambda first, rest, last: first + rest + last, letters, st.text("aZ -", max_size=10), letters
)  # at most 12 characters
five = st.lists(labels, min_size=5, max_size=5, unique=True).map(tuple)


def variables(names, peaks):
    """Return a strategy of variables of one of these names."""
    return st.builds(lambda name, words, at: Variable(name, READINGS[name], words, at), names, five, peaks)


def thousandths(low, high):
    return st.lists(st.integers(low, high), min_size=5, max_size=5, unique=True).map(
        lambda peaks: tuple(p / 1000 for p in sorted(peaks))
    )


def apart(first, gaps):
    """Return five speeds (m/s) from what is between them (mm/s)."""
    return tuple((first + sum(gaps[:n])) / 1000 for n in range(5))


peaks = thousandths(-9_999_999, 9_999_999) | thousandths(0, 1000) | thousandths(0, 12)
speeds = st.builds(apart, st.integers(0, 40), st.lists(st.integers(10, 115), min_size=4, max_size=4)) | st.just(
    (0.0, 0.01, 0.02, 0.03, 0.5)
)
tables = st.lists(st.lists(st.integers(0, 4), min_size=5, max_size=5).map(tuple), min_size=5, max_size=5).map(tuple)
pairs = st.permutations(sorted(READINGS)).flatmap(
    lambda names: st.tuples(variables(st.just(names[0]), peaks), variables(st.just(names[1]), peaks))
)
rule_sets = st.builds(
    RuleSet, pairs, st.builds(lambda words, at: Variable("speed", "m/s", words, at), five, speeds), tables, METHODS
)


def near(variable):
    """Return a strategy of readings in and around what a variable's peaks span, the peaks among them."""
    low, high = variable.peaks[0], variable.peaks[-1]
    margin = (high - low) / 5
    return st.floats(low - margin, high + margin) | st.sampled_from(variable.peaks)


cases = rule_sets.flatmap(lambda rules: st.tuples(st.just(rules), *(near(v) for v in rules.inputs)))
paper_readings = tuple(near(v) for v in PAPER.inputs)
