"""Commands in bytes that Python and TypeScript write and read alike: `python -m tests.command_vectors` writes them again."""

import json
import subprocess

from robots.kit.contract.command_packet import CommandLayout
from robots.kit.drivers.irat.spec import spec as irat
from robots.kit.drivers.mercury.spec import spec as mercury
from robots.kit.drivers.pa10.spec import spec as pa10
from robots.kit.drivers.srv1.spec import spec as srv1
from tests.environment import ROOT
from tools.setup import FRONTEND, find_node

FILE = ROOT / "tests/vectors/command_packets.json"
VECTORS = json.loads(FILE.read_text())
SPECS = {spec().name: spec() for spec in (pa10, mercury, irat, srv1)}
PACK = """
import { packCommand, packHold } from "./src/socket/command_packet.ts";
let text = "";
for await (const part of process.stdin) text += part;
const { layouts, commands, holds } = JSON.parse(text);
const packed = commands.map((one) => packCommand(layouts[one.robot], one.command, one.now_ms));
packed.push(...holds.map((one) => packHold(layouts[one.robot], one.kind, one.message)));
console.log(JSON.stringify(packed.map((data) => data && Buffer.from(data).toString("hex"))));
"""


def write() -> None:
    """Write the vectors again, after a spec has changed: the browser's code packs, ours reads."""
    layouts = {name: CommandLayout.of(spec).facts() for name, spec in SPECS.items() if name in VECTORS["layouts"]}
    made = {"layouts": layouts, "commands": VECTORS["commands"], "holds": VECTORS["holds"]}
    done = subprocess.run(
        [find_node() / "node", "--input-type=module", "-e", PACK], cwd=FRONTEND, input=json.dumps(made), text=True,
        capture_output=True, check=True,
    )  # fmt: skip
    for one, packed in zip([*made["commands"], *made["holds"]], json.loads(done.stdout), strict=True):
        assert (packed is None) == (one["hex"] is None), one["what"]
        one["hex"] = packed
        if packed is not None and "message" in one:
            hold = CommandLayout.of(SPECS[one["robot"]]).decode_hold(bytes.fromhex(packed))
            one["read"] = {"seq": hold.seq, "held": hold.held, "args": hold.args}
        elif packed is not None:
            read = CommandLayout.of(SPECS[one["robot"]]).decode(bytes.fromhex(packed), one["now_ms"])
            one["read"] = {"kind": read.kind, "seq": read.seq, "args": read.args, "seen_ms": read.seen_ms}
    FILE.write_text(json.dumps(made, indent=1) + "\n")


if __name__ == "__main__":
    write()
