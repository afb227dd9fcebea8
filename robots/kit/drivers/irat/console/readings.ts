/** The table of readings beside the picture. */
import { byId, fill, type RobotPage, say } from "/static/farhand/v1/console.js";

/** Show the robot's values in words. */
export function showReadings(page: RobotPage): void {
  const told = (name: string, words: (value: number) => string): string => {
    const value = page.value(name);
    return value === undefined ? "not known" : words(value);
  };
  const charge = page.value("charge");
  byId<HTMLMeterElement>("charge").value = charge ?? 0;
  say(byId("charge-said"), `Battery ${told("charge", (v) => `${v.toFixed(0)} %`)}, ${told("battery", (v) => `${v.toFixed(1)} V`)}`);
  fill(byId("readings").querySelector("tbody")!, [
    ["Now", page.state?.mode || "not known"],
    ["Charging", told("charging", (v) => (v > 0 ? "yes, current flows" : "no"))],
    ["Remembered places", told("experiences", (v) => v.toFixed(0))],
    ["Map", told("map", (v) => `number ${v.toFixed(0)}`)],
    ["Dock seen from", told("docks", (v) => `${v.toFixed(0)} places`)],
    ["Driven", told("driven", (v) => `${v.toFixed(1)} m`)],
  ]);
}
