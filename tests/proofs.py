"""`make proofs`: run the proofs at full numbers and write `docs/reference/proofs.md`.

Results add up in `docs/reference/proofs.json`; a test whose numbers were run already, of that robot and on that
database, is left out unless its promise is named (`make proofs P=7`).
"""

import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from tests import history
from tests.proof import SEEDS, VIRTUAL, without_seed

ROOT = Path(__file__).resolve().parent.parent
KEPT = ROOT / "docs" / "reference" / "proofs.json"
PAGE = ROOT / "docs" / "reference" / "proofs.md"
ROBOTS = ("mercury", "pa10", "irat", "srv1", "puma")
ON_BOTH = (4, 7, 21, 22, 23)  # promises that are run on both databases
LIST = "proofs.txt"
OF_SECONDS = (6, 7, 14, 22, 23, 24, 28, 29, 31, 32, 43, 48, 49)  # only a real machine can show how many
MADE = ("docs/reference/proofs.json", "docs/reference/proofs.md")  # change while the proofs run
PROMISES = {
    1: "One command, at most one motion.",
    2: "A crash means `unknown`, never a replay.",
    3: "Late commands never move.",
    4: "Only the current holder of the robot moves it.",
    5: "One owner a robot.",
    6: "A held motion stops within 500 ms after its controls are lost.",
    7: "Stop overtakes everything.",
    8: "Stopped stays stopped.",
    9: "The envelope is enforced at the server and at the driver.",
    10: "Line noise cannot cause a wrong move.",
    11: "Every command reaches a final state.",
    12: "The image-stability check always answers.",
    13: "Never two operators.",
    14: "A turn ends within a second of its deadline.",
    15: "No starvation.",
    16: "No skipped or doubled steps.",
    17: "Blips are forgiven, absence is not.",
    18: "A robot's fault refunds time exactly once.",
    19: "The estimate of the wait is honest.",
    20: "The key of the clearance test never leaves the server.",
    21: "Nothing acknowledged is lost.",
    22: "An outage of Redis is survived.",
    23: "An outage of the database is survived.",
    24: "A full disk is survived.",
    25: "Upgrade and restore.",
    26: "A stop of everything is safe in mid-motion.",
    27: "72 hours of soak.",
    28: "The load is held.",
    29: "Slow viewers get fewer, fresh frames.",
    30: "Lost events heal.",
    31: "Day-long sockets keep working.",
    32: "Mass reconnect.",
    33: "Foreign, null and missing origins are refused.",
    34: "Logout, ban and lost clearance close sockets.",
    35: "The matrix of permissions.",
    36: "Garbage in, 4xx out.",
    37: "Uploads are rejected or re-encoded.",
    38: "No enumeration of accounts.",
    39: "The session key rotates at login.",
    40: "Rate limits survive tricks.",
    41: "A robot's text is untrusted.",
    42: "No default credentials.",
    43: "Overload is a brownout: pictures slow down, nothing else gives way.",
    44: "A hostile client on a robot's wire changes nothing.",
    45: "A hostile socket leaves nothing behind.",
    46: "What a stranger may ask for delays no command, stop or presence.",
    47: "A job runs at most once, in its fair place, without its person.",
    48: "Motion beyond the connection ends inside its bound.",
    49: "The age that a page shows is the picture's true age.",
}
ELSEWHERE = {
    27: "No proof yet: [shorter soaks](soak.md).",
    37: "Nothing can be uploaded: no page takes a file.",
}
TESTED = {  # whole files, or tests of other names
    14: (
        "test_queue.py::test_a_turn_goes_on_while_nobody_waits_and_ends_a_minute_after_somebody_joins",
        "test_queue_machine.py",
    ),
    15: ("test_fairshare.py", "test_queue.py::test_who_has_driven_much_waits_behind_who_has_not"),
    16: ("test_queue_machine.py", "test_queue.py::test_a_double_accept_is_one_turn"),
    17: (
        "test_queue.py::test_a_lost_line_keeps_the_turn_for_twenty_seconds",
        "test_queue.py::test_somebody_absent_is_passed_over_and_keeps_the_place",
    ),
    18: ("test_queue.py::test_ending_twice_charges_once", "test_jobs.py"),
    19: (
        "test_fairshare.py::test_the_estimate_is_a_range_that_grows_with_the_queue",
        "test_queue.py::test_the_wait_is_a_range_or_unknown",
    ),
    39: ("test_passwords.py::test_signing_in_makes_a_new_session_key",),
    40: ("test_addresses.py", "test_networks.py"),
    47: ("test_jobs.py", "test_queue_machine.py"),
    48: ("test_policies.py", "test_stop_unconfirmed.py"),
}


def machine() -> str:
    """Return the machine in a few words."""
    return f"{os.cpu_count()} cores, {platform.system()} {platform.machine()}, Python {platform.python_version()}"


def kept() -> list[dict]:
    return json.loads(KEPT.read_text()) if KEPT.exists() else []


def pytest_collection_modifyitems(items) -> None:
    """Write down which tests have a proof, where this file is a plug-in of pytest's."""
    found = [
        item.nodeid
        for item in items
        if "test_promise_" in item.name and ("proof" in item.fixturenames or "Proof(" in item.path.read_text())
    ]
    (Path(os.environ["FARHAND_PROOFS_TO"]) / LIST).write_text("\n".join(found))


def with_proofs() -> dict[str, int]:
    """Return the tests that write a figure down, by pytest's name of them, with the number of their promise."""
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "PYTHONPATH": ".", "FARHAND_TEST_DB": "sqlite", "FARHAND_PROOFS": "full",
               "FARHAND_PROOFS_TO": folder}  # fmt: skip
        files = [str(f) for f in sorted((ROOT / "tests").rglob("test_*.py")) if "def test_promise_" in f.read_text()]
        argv = [sys.executable, "-m", "pytest", "--collect-only", "-qq", "-p", "tests.proofs", *files]
        subprocess.run(argv, cwd=ROOT, env=env, check=True, stdout=subprocess.DEVNULL)
        names = (Path(folder) / LIST).read_text().splitlines()
    return {name: int(re.search(r"test_promise_(\d+)", name)[1]) for name in names}


def databases(promise: int) -> tuple[str, ...]:
    return ("sqlite", "postgres") if promise in ON_BOTH else ("sqlite",)


def with_each_seed(r: dict) -> bool:
    """Tell whether a test of seeds was run with all of them."""
    return all(c["ran"] >= c["asked"] for c in r["counts"] if c["what"] == SEEDS)


def missing(wanted: dict[str, int], results: list[dict], only: str) -> dict[tuple[int, str], list[str]]:
    """Return which tests have not been run in full, by promise and database; `only`: none of another robot."""
    proven = {(r["test"], r["database"]) for r in results if r.get("full") and with_each_seed(r)}
    left: dict[tuple[int, str], list[str]] = {}
    for name, promise in sorted(wanted.items(), key=lambda one: one[1]):
        if only and any(robot in name for robot in ROBOTS if robot != only):
            continue
        parts = name.split("::")
        for database in databases(promise):
            if (without_seed(f"{Path(parts[0]).name}::{parts[-1]}"), database) not in proven:
                left.setdefault((promise, database), []).append(name)
    return left


def choice(promise: int, only: str) -> list[str]:
    """Return what makes pytest run one promise's tests, of all robots or of one."""
    others = "".join(f" and not {robot}" for robot in ROBOTS if only and robot != only)
    where = ["tests/world", "tests/faults", "tests/drivers", "tests/e2e", "tests/services", "tests/unit"]
    return [*where, "-k", f"promise_{promise:02d}{others}"]


def run(tests: list[str], database: str) -> bool:
    """Run these tests; keep what they say. Return whether they were green."""
    commit = history.commit(ROOT, MADE)  # before: whoever runs them may write on meanwhile
    with tempfile.TemporaryDirectory() as folder:
        env = {
            **os.environ, "PYTHONPATH": ".", "FARHAND_TEST_DB": database,
            "FARHAND_PROOFS": "full", "FARHAND_PROOFS_TO": folder,
        }  # fmt: skip
        done = subprocess.run([sys.executable, "-m", "pytest", *tests], cwd=ROOT, env=env, check=False)
        take(Path(folder), commit)
    return done.returncode in (0, 5)


def take(folder: Path, commit: str) -> None:
    """Add what the tests of that commit wrote into `folder` to what is kept."""
    lines = folder / "proofs.jsonl"
    found = [json.loads(line) for line in lines.read_text().splitlines()] if lines.exists() else []
    results = kept()
    for line in found:
        line |= {"machine": machine(), "commit": commit}
        same = [
            r
            for r in results
            if (r["promise"], r["test"], r["database"]) == (line["promise"], line["test"], line["database"])
        ]
        for old in same:  # numbers run add up; the figure is the newest, of one commit the worst
            for a, b in zip(line["counts"], old["counts"], strict=False):
                a["ran"] += b["ran"]
            line["full"] = line["full"] or old.get("full", False)
            if old.get("commit") == commit and old.get("worst", 0.0) > line["worst"]:
                line |= {name: old[name] for name in ("figure", "worst", "pace", "discarded")}
            results.remove(old)
        results.append(line)
    results.sort(key=lambda r: (r["promise"], r["test"], r["database"]))
    KEPT.write_text(json.dumps(results, indent=1) + "\n")


def tests_of(promise: int) -> list[str]:
    """Return the tests that name the promise, and what else is known to test it."""
    named = [
        f"{file.name}::{name}"
        for file in sorted((ROOT / "tests").rglob("test_*.py"))
        for name in re.findall(rf"def (test_promise_{promise:02}_\w+)", file.read_text())
    ]
    return [*named, *TESTED.get(promise, ())]


def without_figures(promise: int) -> str:
    """Return what is said of a promise of which nothing was measured."""
    names = ", ".join(f"`{name}`" for name in tests_of(promise))
    return ELSEWHERE.get(promise) or (f"No figures; tested by {names}." if names else "No proof yet.")


def figure(r: dict) -> str:
    """Return the figure; of several seeds it is that of each one, or of the worst."""
    if not any(c["what"] == SEEDS for c in r["counts"]):
        return r["figure"]
    return f"{'worst' if r.get('worst') else 'each'} seed: {r['figure']}"


def how(r: dict) -> str:
    """Return how a figure was measured; older ones do not say it."""
    if not {"time", "commit", "pace", "discarded"} & r.keys():
        return "not recorded"
    pace = ", ".join(
        f"{when} work {p['work']:.1f}, sleep {p['sleep']:.1f}" for when, p in r.get("pace", {}).items() if p
    )
    lost = "; ".join(f"{d['number']} discarded: {d['why']}" for d in r.get("discarded", [])) or "0 discarded"
    said = [
        f"{r['time']} time" if "time" in r else "time not recorded",
        f"commit {r['commit']}" if r.get("commit") else "commit not recorded",
    ]
    if r.get("time") != VIRTUAL:
        said.append(f"pace {pace}" if pace else "pace not recorded")
    return "; ".join([*said, lost if "discarded" in r else "discarded samples not recorded"])


def write() -> None:
    """Write the page."""
    lines = [
        "# Proofs", "",
        "Written by `make proofs`; what the rig is, and what counts as one, is in "
        "[how the promises are proven](../explanation/proofs.md). Numbers run stand beside numbers asked for: where "
        "they are smaller, this machine was too small or the time too short, and running it again adds to them.", "",
        "**How** a figure was measured stands beside it, for its newest run. *Real time*: by the clock of real processes. "
        "*Virtual time*: by a clock that the test moves, so it shows an order and a number, and nothing of how quick a "
        f"machine is; what promises {', '.join(map(str, OF_SECONDS))} say of seconds, only real time shows. The commit is "
        "that of the code; `+changes` says that the tree had others. The pace, which real time needs, is how many times "
        "as long as nominal a fixed work and short sleeps took, before the test and after it. A test with seeds is one "
        "row: the numbers of all of its seeds, and the figure of one. A discarded sample is one that says nothing; "
        "older figures do not tell these, which is named so.", "",
    ]  # fmt: skip
    results = kept()
    for number, text in PROMISES.items():
        mine = [r for r in results if r["promise"] == number]
        lines += [f"## {number}. {text}", ""]
        if not mine:
            lines += [without_figures(number), ""]
            continue
        lines += ["| figure | run / asked | how | test | database | date |", "|---|---|---|---|---|---|"]
        for r in mine:
            numbers = "; ".join(f"{c['ran']} / {c['asked']} {c['what']}" for c in r["counts"])
            lines.append(f"| {figure(r)} | {numbers} | {how(r)} | `{r['test']}` | {r['database']} | {r['at']} |")
        lines += ["", f"On {mine[-1]['machine']}.", ""]
    PAGE.write_text("\n".join(lines))


def main() -> None:
    """Run what is asked for, or what has not been run in full."""
    if sys.argv[1:2] == ["--take"]:  # what another run of the tests wrote down
        take(Path(sys.argv[2]), history.commit(ROOT, MADE))
        write()
        return
    asked = [int(a) for a in sys.argv[1:] if a.isdigit()]
    only = next((a for a in sys.argv[1:] if a in ROBOTS), "")
    runs = {(number, database): choice(number, only) for number in asked for database in databases(number)}
    failed = []
    for (number, database), tests in (runs or missing(with_proofs(), kept(), only)).items():
        if not run(tests, database):
            failed.append(f"{number} on {database}")
        write()
    write()
    if failed:
        sys.exit(f"not green: {', '.join(failed)}")


if __name__ == "__main__":
    main()
