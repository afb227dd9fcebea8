/**
 * Where a page draws the tool of an arm, by the page's own code (run by Node): reads JSON from its input,
 * `facts` of the arm, `layout` of its compact states, `events` as [ms, bytes in hex] in the order of their arrival,
 * `sends` as [ms, pose of 16 numbers, share of full speed, round trip known then (ms)], and `times` (ms); writes for each
 * time the tool's place (m), null before the first state. All times are of one clock.
 */
import { Prediction } from "../frontend/src/arm/prediction.ts";
import { PoseJudge } from "../frontend/src/scene/judge.ts";
import { decode } from "../frontend/src/socket/decoder.ts";

let text = "";
for await (const part of process.stdin) text += part;
const { facts, layout, events, sends, times } = JSON.parse(text);
const judge = new PoseJudge(facts, []);
const toolAt = (joints) => {
  const pose = judge.tool(joints);
  return [pose[3], pose[7], pose[11]];
};
let now = 0,
  state = null,
  next = 0,
  sent = 0;
const prediction = new Prediction(() => now, toolAt);
function take([at, hex]) {
  now = at;
  const { buffer } = Uint8Array.from(Buffer.from(hex, "hex"));
  const packet = decode(buffer, layout, at);
  if (packet && "knots" in packet) prediction.begin(packet);
  else if (packet && "joints" in packet && "moving" in packet) prediction.state((state = packet));
}
function send([at, pose, share, roundTripMs]) {
  now = at;
  const measured = state.joints.slice(0, judge.planner.chain.count);
  prediction.ask(++sent, measured, roundTripMs / 2, (from) => judge.judge({ pose, straight: false, share }, from));
}
const shown = times.map((at) => {
  for (;;) {
    const received = events[next]?.[0] ?? Infinity,
      said = sends[0]?.[0] ?? Infinity;
    if (Math.min(received, said) > at) break;
    if (said < received) send(sends.shift());
    else take(events[next++]);
  }
  now = at;
  const joints = prediction.joints?.predicted ?? state?.joints;
  return joints ? toolAt(joints) : null;
});
console.log(JSON.stringify(shown));
