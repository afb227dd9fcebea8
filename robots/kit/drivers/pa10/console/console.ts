/** The museum arm's console: that of every arm, with program and terminal mode. */
import { ArmConsole } from "/static/farhand/v1/arm.js";
import { RobotPage, type StatePacket } from "/static/farhand/v1/console.js";
import "./terminal.css";
import { Programs } from "./programs.ts";
import { Terminal } from "./terminal.ts";
import { gettext } from "/static/farhand/v1/text.js";

const FINGERS = ["left_finger", "right_finger"]; // the joints of the model for the one width in the state
const page = new RobotPage();

function width(packet: StatePacket): string {
  return `${(1000 * (packet.joints[6] ?? 0)).toFixed(0)} mm`;
}

page.begin(
  new ArmConsole(page, { moved: [FINGERS], posture: (packet) => packet.joints, gripper: width }, (arm) => {
    const programs = new Programs(page, arm, arm.axes);
    new Terminal(page, arm, arm.axes);
    return {
      program: {
        asked: "run",
        empty: gettext("The program has no step."),
        target: () => (programs.text() ? { kind: "program", args: { text: programs.text() } } : null),
        open: () => void programs.open(),
        tellRun: () => programs.tellRun(),
        checked: (answer) => programs.checked(answer),
      },
      terminal: { asked: "jog", target: () => null },
    };
  }),
);
