"""The rules of a rover in three libraries; run by the Python of an environment that has them (`fuzzy_step`).

The first line of the input is JSON: the peaks of both inputs and of the output, the table, readings. The first line of
the answer has the speeds of each for all readings; for about 24 of them, in equal steps, where it is a centroid. Then each line that comes is answered by the milliseconds of the
processor that one step of each took.
"""

import json
import sys
import time
import warnings
from collections.abc import Callable
from itertools import product
from typing import Any

Step = Callable[[float, float], float]


def main() -> None:
    """Answer until the input ends."""
    warnings.simplefilter("ignore")
    sys.stdout = sys.stderr  # one of them prints what it is told
    task = json.loads(sys.stdin.readline())
    readings = task.pop("readings")
    made = (simpful_sugeno, simpful_mamdani, fuzzylite_sugeno, fuzzylite_mamdani, skfuzzy_mamdani)
    steps = {make.__name__.replace("_", ", "): make(**task) for make in made}
    few = readings[:: max(1, len(readings) // 24)]
    tell(
        {name: [float(step(*pair)) for pair in (readings if "sugeno" in name else few)] for name, step in steps.items()}
    )
    for _ in sys.stdin:
        times = {}
        for name, step in steps.items():
            begun = time.process_time()
            for pair in few:
                step(*pair)
            times[name] = 1000 * (time.process_time() - begun) / len(few)
        tell(times)


def tell(found: dict[str, Any]) -> None:
    """Write one line."""
    print(json.dumps(found), flush=True, file=sys.__stdout__)


def corners(peaks: list[float]) -> list[tuple[float, float, float]]:
    """Return the triangles; the outer ones have two equal sides."""
    ends = [2 * peaks[0] - peaks[1], *peaks, 2 * peaks[-1] - peaks[-2]]
    return [(ends[n], ends[n + 1], ends[n + 2]) for n in range(5)]


def simpful(inputs: list[list[float]], table: list[list[int]]) -> Any:
    """Return a system with inputs and rules, and no output yet."""
    from simpful import FuzzySet, FuzzySystem, LinguisticVariable, Triangular_MF

    system = FuzzySystem(show_banner=False, operators=["AND_MIN"])
    for n, peaks in enumerate(inputs):
        terms = [FuzzySet(function=Triangular_MF(*c), term=f"t{k}") for k, c in enumerate(corners(peaks))]
        system.add_linguistic_variable(f"v{n}", LinguisticVariable(terms, universe_of_discourse=[peaks[0], peaks[-1]]))
    system.add_rules(
        [f"IF (v0 IS t{i}) AND (v1 IS t{j}) THEN (speed IS t{table[i][j]})" for i, j in product(range(5), repeat=2)]
    )
    return system


def simpful_sugeno(inputs: list[list[float]], output: list[float], table: list[list[int]]) -> Step:
    """The mean of the speeds."""
    system = simpful(inputs, table)
    for n, peak in enumerate(output):
        system.set_crisp_output_value(f"t{n}", peak)

    def step(first: float, second: float) -> float:
        system.set_variable("v0", first)
        system.set_variable("v1", second)
        return system.Sugeno_inference(["speed"])["speed"]

    return step


def simpful_mamdani(inputs: list[list[float]], output: list[float], table: list[list[int]]) -> Step:
    """The centroid."""
    from simpful import FuzzySet, LinguisticVariable, Triangular_MF

    system = simpful(inputs, table)
    shapes = corners(output)
    terms = [FuzzySet(function=Triangular_MF(*c), term=f"t{k}") for k, c in enumerate(shapes)]
    system.add_linguistic_variable(
        "speed", LinguisticVariable(terms, universe_of_discourse=[shapes[0][0], shapes[-1][2]])
    )

    def step(first: float, second: float) -> float:
        system.set_variable("v0", first)
        system.set_variable("v1", second)
        return system.Mamdani_inference(["speed"])["speed"]

    return step


def fuzzylite(inputs: list[list[float]], output: Any, table: list[list[int]]) -> Step:
    """Return one step of an engine with this output variable."""
    import fuzzylite as fl

    names = [fl.InputVariable(
        name=f"v{n}", minimum=peaks[0], maximum=peaks[-1], lock_range=True,
        terms=[fl.Triangle(f"t{k}", *c) for k, c in enumerate(corners(peaks))],
    ) for n, peaks in enumerate(inputs)]  # fmt: skip
    block = fl.RuleBlock(
        conjunction=fl.Minimum(), disjunction=fl.Maximum(), implication=fl.Minimum(), activation=fl.General(),
        rules=[fl.Rule.create(f"if v0 is t{i} and v1 is t{j} then speed is t{table[i][j]}") for i, j in product(range(5), repeat=2)],
    )  # fmt: skip
    engine = fl.Engine(name="rover", input_variables=names, output_variables=[output], rule_blocks=[block])
    a, b = engine.input_variables

    def step(first: float, second: float) -> float:
        a.value, b.value = first, second
        engine.process()
        return output.value

    return step


def fuzzylite_sugeno(inputs: list[list[float]], output: list[float], table: list[list[int]]) -> Step:
    """The mean of the speeds."""
    import fuzzylite as fl

    terms = [fl.Constant(f"t{n}", peak) for n, peak in enumerate(output)]
    speed = fl.OutputVariable(
        name="speed", minimum=output[0], maximum=output[-1], defuzzifier=fl.WeightedAverage("TakagiSugeno"), terms=terms
    )
    return fuzzylite(inputs, speed, table)


def fuzzylite_mamdani(inputs: list[list[float]], output: list[float], table: list[list[int]]) -> Step:
    """The centroid."""
    import fuzzylite as fl

    shapes = corners(output)
    speed = fl.OutputVariable(
        name="speed", minimum=shapes[0][0], maximum=shapes[-1][2], defuzzifier=fl.Centroid(200), aggregation=fl.Maximum(),
        terms=[fl.Triangle(f"t{k}", *c) for k, c in enumerate(shapes)],
    )  # fmt: skip
    return fuzzylite(inputs, speed, table)


def skfuzzy_mamdani(inputs: list[list[float]], output: list[float], table: list[list[int]]) -> Step:
    """The centroid; it has no Sugeno."""
    import numpy as np
    import skfuzzy
    from skfuzzy import control

    def variable(kind: Any, name: str, peaks: list[float], low: float, high: float) -> Any:
        made = kind(np.linspace(low, high, 201), name)
        for k, c in enumerate(corners(peaks)):
            made[f"t{k}"] = skfuzzy.trimf(made.universe, c)
        return made

    a, b = (variable(control.Antecedent, f"v{n}", peaks, peaks[0], peaks[-1]) for n, peaks in enumerate(inputs))
    shapes = corners(output)
    speed = variable(control.Consequent, "speed", output, shapes[0][0], shapes[-1][2])
    rules = [control.Rule(a[f"t{i}"] & b[f"t{j}"], speed[f"t{table[i][j]}"]) for i, j in product(range(5), repeat=2)]
    system = control.ControlSystemSimulation(control.ControlSystem(rules), cache=False)

    def step(first: float, second: float) -> float:
        system.input["v0"] = first
        system.input["v1"] = second
        system.compute()
        return system.output["speed"]

    return step


if __name__ == "__main__":
    main()
