/**
 * Where a page draws the tool of an arm, by the page's own code (run by Node): reads JSON from its input,
 * `facts` of the arm, `layout` of its compact states, `events` as [ms, bytes in hex] in the order of their arrival, and
 * `times` (ms); writes for each time the tool's place (m), null before the first state. All times are of one clock.
 */
import { Prediction } from "../frontend/src/arm/prediction.ts";
import { Chain } from "../frontend/src/motion/chain.ts";
import { decode } from "../frontend/src/socket/decoder.ts";

let text = "";
for await (const part of process.stdin) text += part;
const { facts, layout, events, times } = JSON.parse(text);
const chain = new Chain(facts);
const toolAt = (joints) => {
  const pose = chain.forward(joints);
  return [pose[3], pose[7], pose[11]];
};
let now = 0,
  state = null,
  next = 0;
const prediction = new Prediction(() => now, toolAt);
function take([at, hex]) {
  now = at;
  const { buffer } = Uint8Array.from(Buffer.from(hex, "hex"));
  const packet = decode(buffer, layout, at);
  if (packet && "knots" in packet) prediction.begin(packet);
  else if (packet && "joints" in packet && "moving" in packet) prediction.state((state = packet));
}
const shown = times.map((at) => {
  while (next < events.length && events[next][0] <= at) take(events[next++]);
  now = at;
  const joints = prediction.joints?.predicted ?? state?.joints;
  return joints ? toolAt(joints) : null;
});
console.log(JSON.stringify(shown));
