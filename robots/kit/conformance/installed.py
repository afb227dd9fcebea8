"""The suite over a driver that is installed, by its name: on its simulator, or at an address."""

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from robots.kit.clock import TIMER, FasterTimer, Timer
from robots.kit.conformance.report import Report, Result, Verdict
from robots.kit.conformance.simulated import Simulated, simulator
from robots.kit.conformance.suite import conform
from robots.kit.conformance.trial import Limits, Opening
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.session import JSON, Session
from robots.kit.description import load, views
from robots.kit.installed import driver_path

Told = Callable[[Result], None]


def wire_address(address: str) -> str:
    """Return what a driver opens of `serial:/dev/PORT` or `tcp:HOST:PORT`."""
    kind, _, rest = address.partition(":")
    return rest if kind == "serial" else f"socket://{rest}"


def opening(name: str, address: str, settings: JSON, clock: Timer) -> Opening:
    """Return what makes the driver's sessions on that clock. Raises LookupError where its module cannot be loaded."""
    try:
        driver: type[Session] = function(driver_path(name))  # type: ignore[assignment]
    except Exception as error:
        raise LookupError(f"the driver {name!r} cannot be loaded: {error}") from error
    timed = driver if clock is driver.clock else type(driver.__name__, (driver,), {"clock": clock})
    return lambda: timed(address, dict(settings))


def conform_installed(
    name: str, address: str, *, factor: float = 1.0, epoch: int = 1, token: str = "", limits: Limits | None = None,
    only: Sequence[str] = (), told: Told = lambda _: None,
) -> Report:  # fmt: skip
    """Run the suite over the installed driver `name`. `address`: `sim:NAME`, `serial:/dev/PORT` or `tcp:HOST:PORT`.

    Kinds are carried out with the values that `[conformance]` of its robot.toml lists, else inside their ranges.
    `factor` is how many times faster than real time a simulator runs, `epoch` the fencing epoch of the sessions.
    Raises LookupError where no such driver is installed, NotStarted where its simulator does not start.
    """
    try:
        spec = spec_of(name)
    except LookupError as error:
        if "is broken" not in str(error):
            raise
        return Report(name, (Result("spec", Verdict.FAILED, (f"{str(error)[:1].upper()}{str(error)[1:]}.",)),))
    try:
        description: dict[str, Any] = load(name)
    except (OSError, ValueError) as error:
        return Report(name, (Result("spec", Verdict.FAILED, (f"Its robot.toml cannot be read: {error}.",)),))
    clock = TIMER if factor == 1.0 else FasterTimer(factor)
    examples: Mapping[str, Sequence[JSON]] = description.get("conformance", {})
    with _at(address, factor) as (wire, simulated), tempfile.TemporaryDirectory(prefix="farhand-conform-") as folder:
        settings = {"epoch": epoch, "folder": folder} | ({"token": token} if token else {})
        return conform(
            opening(name, wire, settings, clock), spec, clock, name=name, limits=limits, description=description,
            examples=examples, faults=(lambda: simulated.board) if simulated else (lambda: None),
            nowhere=opening(name, str(Path(folder) / "nowhere"), settings, clock),
            pictures=(lambda: simulated.pictures(views(description))) if simulated else dict, only=only, told=told,
        )  # fmt: skip


@contextmanager
def _at(address: str, factor: float) -> Iterator[tuple[str, Simulated | None]]:
    kind, _, name = address.partition(":")
    if kind != "sim":
        yield wire_address(address), None
        return
    with simulator(name, factor) as simulated:
        yield simulated.address, simulated
