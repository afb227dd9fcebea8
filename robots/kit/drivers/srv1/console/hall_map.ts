/** The hall from above: walls, cases, exhibits, ways between places; the rover, what its sensors see, and where it goes. */
import { set, shape } from "/static/farhand/v1/console.js";
import { translate } from "/static/farhand/v1/text.js";

export interface Case {
  name: string;
  at: [number, number];
  half: [number, number];
  high: number;
  black?: boolean;
}
export interface Exhibit {
  name: string;
  at: [number, number];
  radius: number;
  high: number;
}
export interface Node {
  name: string;
  at: [number, number];
  to: string[];
}
export interface Hall {
  width: number;
  depth: number;
  case: Case[];
  exhibit: Exhibit[];
  node: Node[];
}
export interface Description {
  hall: Hall;
  body: { length: number; width: number; height: number };
  infrared: { from: [number, number, number]; far: number; stop: number };
  sonar: { from: [number, number, number]; far: number; stop: number; half_cone: number };
}
/** Where the rover is (m, m, rad), how sure it is of that (m), and what its sensors read (m). */
export interface Seen {
  x: number;
  y: number;
  heading: number;
  spread: number;
  infrared: number;
  sonar: number;
}

const EDGE_M = 0.25; // the margin around the floor
const TRAIL = 240; // the most points of the trail
const STEP_M = 0.05; // between two points of the trail
const LINE_PX = 15; // the height of a name
type Point = readonly [number, number];

export class HallMap {
  private rover: SVGGElement;
  private sure: SVGCircleElement;
  private cone: SVGPathElement;
  private beam: SVGLineElement;
  private trail: SVGPolylineElement;
  private goal: SVGGElement;
  private planned: SVGPolylineElement;
  private shadow: SVGGElement;
  private points: Point[] = [];

  constructor(
    private svg: SVGSVGElement,
    private d: Description,
    onPick: (x: number, y: number) => void,
  ) {
    const { hall } = d;
    set(svg, {
      viewBox: `${-EDGE_M} ${-hall.depth - EDGE_M} ${hall.width + 2 * EDGE_M} ${hall.depth + 2 * EDGE_M}`,
      preserveAspectRatio: "xMidYMid meet",
    });
    shape(svg, "rect", { x: 0, y: -hall.depth, width: hall.width, height: hall.depth, class: "floor" });
    const at = new Map(hall.node.map((node) => [node.name, node.at]));
    for (const node of hall.node) for (const name of node.to) if (node.name < name) this.line(node.at, at.get(name)!, "way");
    this.trail = shape(svg, "polyline", { class: "trail", points: "" });
    this.cone = shape(svg, "path", { class: "cone", d: "" });
    this.beam = shape(svg, "line", { class: "beam" });
    for (const one of hall.case) this.drawCase(one);
    for (const { name, at, radius } of hall.exhibit) {
      this.circle(at, radius, "exhibit");
      this.name(name, ...at);
    }
    for (const { at } of hall.node) this.circle(at, 0.09, "node");
    this.planned = shape(svg, "polyline", { class: "planned", points: "" });
    this.goal = shape(svg, "g", { class: "goal", visibility: "hidden" });
    shape(this.goal, "path", { d: "M -0.16 -0.16 L 0.16 0.16 M -0.16 0.16 L 0.16 -0.16" });
    this.shadow = shape(svg, "g", { class: "ghost", visibility: "hidden" });
    this.body(this.shadow);
    this.sure = shape(svg, "circle", { class: "spread", r: 0, cx: 0, cy: 0 });
    this.rover = shape(svg, "g", { class: "rover", visibility: "hidden" });
    this.body(this.rover);
    svg.addEventListener("click", (event) => {
      const matrix = svg.getScreenCTM();
      if (!matrix) return;
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
      onPick(point.x, -point.y);
    });
  }

  /** The lowest element above the driven ways. */
  get first(): SVGElement {
    return this.cone;
  }

  /** Draw the rover at the place where it believes to be; null while that is not known. */
  show(seen: Seen | null): void {
    set(this.rover, { visibility: seen ? "visible" : "hidden" });
    if (!seen) return;
    const { x, y, heading, spread } = seen;
    set(this.rover, { transform: turned([x, y, heading]) });
    set(this.sure, { cx: place(x), cy: place(-y), r: place(Math.max(0, spread)) });
    this.drawSensors(seen);
    const last = this.points.at(-1);
    if (last && Math.hypot(last[0] - x, last[1] - y) < STEP_M) return;
    this.points = [...this.points.slice(1 - TRAIL), [x, y]];
    set(this.trail, { points: this.points.map(([a, b]) => `${place(a)},${place(-b)}`).join(" ") });
  }

  /** Draw the path of a mission: its corners; null for none. */
  plan(corners: readonly (readonly [number, number, number])[] | null, good: boolean): void {
    set(this.planned, { points: (corners ?? []).map(([x, y]) => `${place(x)},${place(-y)}`).join(" "), "data-good": String(good) });
  }

  /** Draw the ghost that tries a mission; null to take it away. */
  ghost(at: readonly [number, number, number] | null): void {
    set(this.shadow, { visibility: at ? "visible" : "hidden", ...(at ? { transform: turned(at) } : {}) });
  }

  private body(into: SVGGElement): void {
    const { length, width } = this.d.body;
    for (const side of [-1, 1])
      for (const end of [-1, 1]) this.rect(into, [end * length * 0.3, side * width * 0.5], [0.06, 0.035], 0.02, "wheel");
    this.rect(into, [0, 0], [length / 2, width * 0.42], 0.05, "hull");
    const [tip, back, aside] = [length * 0.52, length * 0.12, width * 0.26];
    shape(into, "path", { d: `M ${tip} 0 L ${back} ${-aside} L ${back} ${aside} Z`, class: "nose" });
  }

  /** Mark where the rover is sent; null to take the mark away. */
  mark(at: Point | null): void {
    set(this.goal, { visibility: at ? "visible" : "hidden", ...(at ? { transform: `translate(${place(at[0])} ${place(-at[1])})` } : {}) });
  }

  private drawSensors({ x, y, heading, infrared, sonar }: Seen): void {
    const from = (ahead: number): Point => [x + ahead * Math.cos(heading), -y - ahead * Math.sin(heading)];
    const [a, b] = from(this.d.infrared.from[0]),
      [c, e] = from(this.d.infrared.from[0] + infrared);
    set(this.beam, { x1: place(a), y1: place(b), x2: place(c), y2: place(e), "data-near": String(infrared < this.d.infrared.far) });
    const [u, v] = from(this.d.sonar.from[0]);
    const end = (side: number): string => {
      const way = heading + side * this.d.sonar.half_cone;
      return `${place(u + sonar * Math.cos(way))} ${place(v - sonar * Math.sin(way))}`;
    };
    set(this.cone, { d: `M ${place(u)} ${place(v)} L ${end(1)} A ${place(sonar)} ${place(sonar)} 0 0 1 ${end(-1)} Z` });
  }

  private drawCase({ name, at: [x, y], half: [wide, deep], black }: Case): void {
    this.rect(this.svg, [x, -y], [wide, deep], 0.06, black ? "case black" : "case");
    this.name(name, x, y);
  }

  /** Draw a rectangle by its middle and its half sides (m, y down). */
  private rect(into: SVGElement, [x, y]: Point, [wide, high]: Point, rx: number, name: string): void {
    shape(into, "rect", { x: x - wide, y: y - high, width: 2 * wide, height: 2 * high, rx, class: name });
  }

  private circle([x, y]: Point, r: number, name: string): void {
    shape(this.svg, "circle", { cx: x, cy: -y, r, class: name });
  }

  private line([x1, y1]: Point, [x2, y2]: Point, name: string): void {
    shape(this.svg, "line", { x1, y1: -y1, x2, y2: -y2, class: name });
  }

  private name(words: string, x: number, y: number): void {
    shape(this.svg, "text", { x, y: -y, "font-size": LINE_PX / 60, class: "name" }).textContent = translate(words);
  }
}

function turned([x, y, heading]: readonly [number, number, number]): string {
  return `translate(${place(x)} ${place(-y)}) rotate(${((-heading * 180) / Math.PI).toFixed(1)})`;
}

function place(metres: number): string {
  return metres.toFixed(3);
}
