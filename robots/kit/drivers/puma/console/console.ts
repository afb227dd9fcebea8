/** The console of the PUMA 560: that of every arm. Its gripper is pneumatic, and tells only what its valve was set to. */
import { ArmConsole } from "/static/farhand/v1/arm.js";
import { RobotPage, type StatePacket } from "/static/farhand/v1/console.js";

const FINGERS = ["left_finger", "right_finger"];
const OPEN_M = 0.03;
const page = new RobotPage();

function closed(packet: StatePacket): boolean {
  return (packet.values[0] ?? 0) > 0.5;
}

page.begin(
  new ArmConsole(page, {
    moved: [FINGERS],
    posture: (packet) => [...packet.joints, closed(packet) ? 0 : OPEN_M],
    gripper: (packet) => (closed(packet) ? "valve closed" : "valve open"),
  }),
);
