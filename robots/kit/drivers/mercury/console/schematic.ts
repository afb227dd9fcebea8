/** The map from above: base, links, sand, what the camera sees, and a ghost of the target. */
import { set, shape, type Still } from "/static/farhand/v1/console.js";
import { forward, onSand, reach, target, type Arm, type Description, type Map2 } from "./scara.ts";

const MM = 1000;
const NEAR_RAD = 1e-4; // less than a tenth of a millimetre
const PAUSE_MS = 20; // between two frames: some thirty a second, because each is laid out and painted
const FADES_MS = 84; // the time constant of the drawn motion

export class Schematic {
  /** For what was dug and found there, in mm. */
  readonly dug: SVGGElement;
  private links: SVGPolylineElement;
  private ghost: SVGPolylineElement;
  private ghostRing: SVGCircleElement;
  private tool: SVGCircleElement;
  private elbow: SVGCircleElement;
  private view: SVGPolygonElement;
  private cursor: [number, number] | null = null;
  private shown = [0, 0];
  private wanted = [0, 0];
  private gliding = false;
  private drawn = 0;

  constructor(
    private svg: SVGSVGElement,
    private d: Description,
    onPick: (x: number, y: number) => void,
  ) {
    const { x, y } = d.sand;
    set(svg, { viewBox: "-330 -640 660 700", preserveAspectRatio: "xMidYMid meet" });
    const outer = (d.arm.link1 + d.arm.link2) * MM;
    const [left, right, low, high] = [...x, ...y].map((metres) => metres * MM) as [number, number, number, number];
    const sand = { x: left, y: -high, width: right - left, height: high - low, rx: 4, class: "sand" };
    const tray = { x: left - 28, y: -high - 28, width: sand.width + 56, height: sand.height + 56, rx: 10, class: "tray" };
    shape(svg, "path", { d: `M ${-outer} 0 A ${outer} ${outer} 0 0 1 ${outer} 0`, class: "reach" });
    shape(svg, "rect", tray);
    shape(svg, "rect", sand);
    this.dug = shape(svg, "g", {});
    for (let gx = Math.ceil(left / 100) * 100; gx <= right; gx += 100)
      shape(svg, "line", { x1: gx, x2: gx, y1: -low, y2: -high, class: "grid" });
    for (let gy = Math.ceil(low / 100) * 100; gy <= high; gy += 100)
      shape(svg, "line", { x1: left, x2: right, y1: -gy, y2: -gy, class: "grid" });
    this.view = shape(svg, "polygon", { class: "view", points: "" });
    this.ghost = shape(svg, "polyline", { class: "ghost-arm", points: "" });
    this.ghostRing = shape(svg, "circle", { class: "ghost-ring", r: 14, cx: 0, cy: 9999 });
    this.links = shape(svg, "polyline", { class: "arm", points: "" });
    shape(svg, "circle", { cx: 0, cy: 0, r: 34, class: "base" });
    this.elbow = shape(svg, "circle", { r: 17, class: "joint" });
    this.tool = shape(svg, "circle", { r: 12, class: "tool" });
    svg.addEventListener("click", (event) => {
      const at = this.point(event);
      if (at) onPick(...at);
    });
    svg.addEventListener("keydown", (event) => this.key(event, onPick));
    this.begin();
  }

  private point(event: MouseEvent): [number, number] | null {
    const matrix = this.svg.getScreenCTM();
    if (!matrix) return null;
    const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    return [p.x / MM, -p.y / MM];
  }

  private key(event: KeyboardEvent, onPick: (x: number, y: number) => void): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return; // the browser's own, as Alt and an arrow
    const step = event.shiftKey ? 0.05 : 0.01;
    const keys: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const way = keys[event.key];
    if (!way) return;
    event.preventDefault();
    const from = this.cursor ?? forward(this.d, this.wanted).tool;
    const { x, y } = this.d.sand;
    onPick(Math.min(x[1], Math.max(x[0], from[0] + step * way[0])), Math.min(y[1], Math.max(y[0], from[1] + step * way[1])));
  }

  /** Show the joints; they are drawn gliding, so that five packets a second look like a motion. */
  joints(q: number[]): void {
    this.wanted = q;
    if (this.shown[0] === 0 && this.shown[1] === 0) this.shown = [...q];
    this.begin();
  }

  /** Draw frames until the drawing has reached the arm; a page at rest draws nothing. */
  private begin(): void {
    if (this.gliding) return;
    this.gliding = true;
    this.drawn = performance.now();
    requestAnimationFrame(() => this.glide());
  }

  private glide(): void {
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const left = this.shown.map((s, i) => (this.wanted[i] ?? 0) - s);
    const near = calm || left.every((l) => Math.abs(l) < NEAR_RAD);
    const now = performance.now();
    const share = near ? 1 : 1 - Math.exp((this.drawn - now) / FADES_MS);
    this.drawn = now;
    this.shown = this.shown.map((s, i) => s + (left[i] ?? 0) * share);
    const arm = forward(this.d, this.shown);
    this.draw(this.links, arm);
    set(this.elbow, { cx: arm.elbow[0] * MM, cy: -arm.elbow[1] * MM });
    set(this.tool, { cx: arm.tool[0] * MM, cy: -arm.tool[1] * MM });
    this.gliding = !near;
    if (!near) setTimeout(() => requestAnimationFrame(() => this.glide()), PAUSE_MS);
  }

  private draw(line: SVGPolylineElement, arm: Arm): void {
    const points = [[0, 0], arm.elbow, arm.tool].map(([x = 0, y = 0]) => `${x * MM},${-y * MM}`);
    set(line, { points: points.join(" ") });
  }

  /** Draw what the newest picture covers. */
  covers(still: Still | null, map: Map2 | null): void {
    if (!still || !map) return set(this.view, { points: "" });
    const { width: w, height: h } = still;
    const corner = (u: number, v: number): string => {
      const [x, y] = target(map, still.pose, u, v, w, h);
      return `${x * MM},${-y * MM}`;
    };
    set(this.view, { points: [corner(0, 0), corner(w - 1, 0), corner(w - 1, h - 1), corner(0, h - 1)].join(" ") });
  }

  /** Show the ghost of a target; null hides it. */
  aim(at: [number, number] | null): void {
    this.cursor = at;
    const arm = at ? reach(this.d, at[0], at[1]) : null;
    if (!at || !arm || !onSand(this.d, at[0], at[1])) {
      set(this.ghost, { points: "" });
      set(this.ghostRing, { cx: (at?.[0] ?? 0) * MM, cy: at ? -at[1] * MM : 9999, class: "ghost-ring refused" });
      return;
    }
    this.draw(this.ghost, arm);
    set(this.ghostRing, { cx: at[0] * MM, cy: -at[1] * MM, class: "ghost-ring" });
  }
}
