"""Lighthouse's scores of the landing page and of a robot's page on a phone, beside a page without live parts.

The portal has five robots, one of which is simulated and sends pictures, and entries of the log with pictures.

Its phone profile: a screen of 412 px, a slow 4G line and a processor slowed down four times, as Lighthouse simulates
them. Lighthouse is installed from its own lock file on first use.
"""

import json
import os
import subprocess
from pathlib import Path

from benchmarks.stage import cast, database, median, set_up, tell
from tools.setup import QUIETLY, find_node, npm

PAGES = {"landing": "/", "robot": "/robots/mercury/", "story, without live parts": "/story/"}
LIVE = ("landing", "robot")
CATEGORIES = ("performance", "accessibility")
RUNS, GOAL = 3, 95
FOLDER = Path(__file__).parent / "_lighthouse"
FLAGS = "--headless --no-sandbox --disable-gpu"


def main() -> None:
    """Install it, and judge the pages."""
    set_up()
    node = find_node()
    if not (FOLDER / "node_modules").exists():
        npm(node, "ci", *QUIETLY, cwd=FOLDER)
    with database():
        scores = _run(node / "node")
    for name, found in scores.items():
        print(f"{name}: " + ", ".join(f"{category} {found[category]:.0f}" for category in CATEGORIES))
    least = min(scores[name][category] for name in LIVE for category in CATEGORIES)
    tell("lighthouse", least, "the least score of the two live pages", f"at least {GOAL}", least >= GOAL, scores)


def _run(node: Path) -> dict[str, dict[str, float]]:
    from operatorlog.models import Visibility
    from tests.conftest import RedisServer
    from tests.e2e.bare import JOINTS, BarePortal
    from tests.e2e.small import SmallPortal

    redis = RedisServer()
    redis.start()
    robot, _ = cast()
    robot.rig_dir.mkdir(parents=True, exist_ok=True)
    portal = SmallPortal(robot)
    beside = BarePortal(portal.web, {"pa10": JOINTS["pa10"], "puma": JOINTS["pa10"][:6], "irat": (), "srv1": ()})
    try:
        beside.entry(beside.person("cy", "pa10"), "pa10", visibility=Visibility.FEATURED)
        beside.entry(beside.person("eve", "puma"), "puma")
        return {name: _judge(node, f"{portal.url}{address}") for name, address in PAGES.items()}
    finally:
        beside.stop()
        portal.stop()
        redis.stop()


def _judge(node: Path, address: str) -> dict[str, float]:
    """Return the median scores of some runs, 0 to 100; what is wrong with the accessibility is printed."""
    reports = [_report(node, address) for _ in range(RUNS)]
    failed = {
        audit["title"]
        for report in reports
        for reference in report["categories"]["accessibility"]["auditRefs"]
        if (audit := report["audits"][reference["id"]])["score"] == 0 and reference["weight"]
    }
    for title in sorted(failed):
        print(f"{address}: {title}")
    return {name: median([100 * report["categories"][name]["score"] for report in reports]) for name in CATEGORIES}


def _report(node: Path, address: str) -> dict[str, dict[str, dict]]:
    cli = FOLDER / "node_modules/lighthouse/cli/index.js"
    command = [node, cli, address, "--quiet", "--output=json", f"--only-categories={','.join(CATEGORIES)}",
               f"--chrome-flags={FLAGS}"]  # fmt: skip
    env = {**os.environ, "CHROME_PATH": os.environ["FARHAND_CHROMIUM"]}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=True, timeout=300)
    return json.loads(done.stdout)
