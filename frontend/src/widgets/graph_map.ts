/** A map that a robot draws while it drives, on a canvas: places and links, its pose, a path, marks; a click finds a place. */
import { set } from "../kit/dom.ts";
import { gettext } from "../kit/text.ts";
import { type Box, fittingBox, nearest, Scale } from "./plane.ts";

export interface Spot {
  x: number;
  y: number;
}
export interface Graph {
  spots: ReadonlyMap<number, Spot>;
  links: readonly (readonly [number, number])[];
  /** The path that is being driven; its last place is the goal. */
  route: readonly number[];
  docks: readonly number[];
  dock: Spot | null;
}
/** A numbered x: `now` for the goal that the robot drives to, `own` for the viewer's. */
export interface Mark extends Spot {
  text: string;
  own: boolean;
  now: boolean;
}
export interface Pose extends Spot {
  heading: number;
}

const PAUSE_MS = 80; // between two drawings
const CALM_MS = 1000; // the same where the person prefers reduced motion
const TOUCH_PX = 24;
const NEAR_M = 0.1;
const CROWD = 600; // with more places than this each dot is small
const CENTRED = { textAlign: "center", textBaseline: "middle", lineJoin: "round" };
/** Which of the page's variables a colour of the map is. */
const VARIABLES = { ink: "ink", quiet: "quiet", line: "map-line", card: "card", accent: "accent", route: "stop", dock: "good" };
type Colours = Record<keyof typeof VARIABLES, string>;

export class GraphMap {
  private context: CanvasRenderingContext2D;
  private graph: Graph | null = null;
  private pose: Pose | null = null;
  private marks: readonly Mark[] = [];
  private labels: ReadonlyMap<string, Spot> = new Map();
  private over: number | null = null;
  private box: Box | null = null;
  private scale = new Scale(null, 1, 1);
  private asked = false;
  private drawn = 0;
  private colours: Colours | null = null;
  private calm = matchMedia("(prefers-reduced-motion: reduce)");

  /** `onPick` gets the place that was clicked on; null for a click where no place is near. */
  constructor(
    private canvas: HTMLCanvasElement,
    onPick: (place: number | null) => void,
  ) {
    this.context = canvas.getContext("2d")!;
    new ResizeObserver(() => this.ask()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.colours = null;
      this.ask();
    });
    canvas.addEventListener("click", (event) => onPick(this.at(event)));
    canvas.addEventListener("pointermove", (event) => this.point(event.pointerType === "mouse" ? this.at(event) : null));
    canvas.addEventListener("pointerleave", () => this.point(null));
  }

  /** Show another graph. `whole`: nothing of the one before is left. */
  show(graph: Graph, whole: boolean): void {
    this.graph = graph;
    if (whole) this.box = null;
    this.ask();
  }

  place(pose: Pose | null): void {
    this.pose = pose;
    this.ask();
  }

  mark(marks: readonly Mark[], labels: ReadonlyMap<string, Spot>): void {
    this.marks = marks;
    this.labels = labels;
    this.ask();
  }

  private at(event: MouseEvent): number | null {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = this.scale.toPlane(event.clientX - box.left, event.clientY - box.top);
    return this.graph ? nearest(this.graph.spots, x, y, Math.max(NEAR_M, TOUCH_PX / this.scale.pixels)) : null;
  }

  private point(place: number | null): void {
    if (place === this.over) return;
    this.over = place;
    this.canvas.style.cursor = place === null ? "" : "pointer";
    this.ask();
  }

  private ask(): void {
    if (this.asked) return;
    this.asked = true;
    const pause = this.calm.matches ? CALM_MS : PAUSE_MS;
    setTimeout(() => requestAnimationFrame(() => this.draw()), Math.max(0, pause - (performance.now() - this.drawn)));
  }

  private draw(): void {
    this.asked = false;
    this.drawn = performance.now();
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const ratio = Math.min(2, devicePixelRatio);
    set(this.canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    this.colours ??= coloursOf(this.canvas);
    const c = this.context;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    const spots = [...(this.graph?.spots.values() ?? [])];
    this.box = fittingBox(this.box, this.pose ? [...spots, this.pose] : spots);
    this.scale = new Scale(this.box, width, height);
    if (this.graph) this.drawGraph(this.graph, this.colours);
    if (this.pose) this.drawPose(this.pose, this.colours);
    for (const mark of this.marks) this.drawMark(mark, this.colours);
  }

  private drawGraph(graph: Graph, colours: Colours): void {
    const links = graph.links.map(([a, b]) => [graph.spots.get(a), graph.spots.get(b)]);
    this.lines(links, colours.line, 1.5);
    const small = graph.spots.size > CROWD ? 1.3 : 2.6;
    this.dots(graph.spots.values(), colours.quiet, small);
    const at = (id: number): Spot[] => [graph.spots.get(id)].filter((spot) => spot !== undefined);
    this.dots(graph.docks.flatMap(at), colours.dock, small + 1.8);
    if (graph.dock) this.drawDock(graph.dock, colours);
    const way = graph.route.flatMap(at),
      pairs = way.slice(1).map((spot, i) => [way[i], spot]);
    this.lines(pairs, colours.route, 3.5);
    this.letters(colours);
    const over = this.over === null ? undefined : graph.spots.get(this.over);
    if (over) this.ring(over, 9, colours.accent);
  }

  private drawDock(dock: Spot, colours: Colours): void {
    const c = this.context;
    const [x, y] = this.scale.toScreen(dock.x, dock.y);
    Object.assign(c, CENTRED, { strokeStyle: colours.dock, lineWidth: 2.5, font: "600 12px system-ui, sans-serif" });
    c.strokeRect(x - 7, y - 7, 14, 14);
    const text = gettext("dock"),
      half = c.measureText(text).width / 2 + 3,
      { clientWidth: width, clientHeight: height } = this.canvas;
    // away from the middle, where paths are; not cut off at the sides
    this.words(text, Math.max(half, Math.min(width - half, x)), y + (y < height / 2 ? -17 : 17), colours.dock, colours);
  }

  private lines(pairs: Iterable<readonly (Spot | undefined)[]>, colour: string, wide: number): void {
    const c = this.context;
    c.beginPath();
    for (const [a, b] of pairs)
      if (a && b) {
        c.moveTo(...this.scale.toScreen(a.x, a.y));
        c.lineTo(...this.scale.toScreen(b.x, b.y));
      }
    Object.assign(c, { strokeStyle: colour, lineWidth: wide, lineCap: "round" });
    c.stroke();
  }

  private dots(spots: Iterable<Spot>, colour: string, size: number): void {
    const c = this.context;
    c.beginPath();
    for (const spot of spots) {
      const [x, y] = this.scale.toScreen(spot.x, spot.y);
      c.moveTo(x + size, y);
      c.arc(x, y, size, 0, 7);
    }
    c.fillStyle = colour;
    c.fill();
  }

  private letters(colours: Colours): void {
    const c = this.context;
    Object.assign(c, CENTRED, { font: "600 13px system-ui, sans-serif" });
    for (const [text, spot] of this.labels) {
      const [x, y] = this.scale.toScreen(spot.x, spot.y);
      this.dots([spot], colours.ink, 3.5);
      this.words(text, x + 11, y - 9, colours.ink, colours);
    }
  }

  private words(text: string, x: number, y: number, colour: string, colours: Colours): void {
    const c = this.context;
    Object.assign(c, { lineWidth: 4, strokeStyle: colours.card, fillStyle: colour });
    c.strokeText(text, x, y);
    c.fillText(text, x, y);
  }

  private ring(spot: Spot, size: number, colour: string): void {
    const c = this.context;
    c.beginPath();
    c.arc(...this.scale.toScreen(spot.x, spot.y), size, 0, 7);
    Object.assign(c, { strokeStyle: colour, lineWidth: 2.5 });
    c.stroke();
  }

  private drawPose(pose: Pose, colours: Colours): void {
    const c = this.context;
    const [x, y] = this.scale.toScreen(pose.x, pose.y);
    c.save();
    c.translate(x, y);
    c.rotate(-pose.heading);
    c.beginPath();
    c.moveTo(14, 0);
    c.lineTo(-9, 8.5);
    c.lineTo(-5, 0);
    c.lineTo(-9, -8.5);
    c.closePath();
    Object.assign(c, { fillStyle: colours.accent, strokeStyle: colours.card, lineWidth: 3, lineJoin: "round" });
    c.stroke();
    c.fill();
    c.restore();
  }

  private drawMark(mark: Mark, colours: Colours): void {
    const c = this.context;
    const [x, y] = this.scale.toScreen(mark.x, mark.y);
    const colour = mark.now ? colours.route : colours.ink;
    if (mark.own) this.ring(mark, 12, colours.accent);
    c.beginPath();
    for (const way of [1, -1]) {
      c.moveTo(x - 6, y - 6 * way);
      c.lineTo(x + 6, y + 6 * way);
    }
    for (const stroke of [
      { lineWidth: 6, strokeStyle: colours.card },
      { lineWidth: 3, strokeStyle: colour },
    ]) {
      Object.assign(c, { ...stroke, lineCap: "round" });
      c.stroke();
    }
    Object.assign(c, CENTRED, { font: "700 15px system-ui, sans-serif", textAlign: "left" });
    this.words(mark.text, x + (mark.own ? 15 : 10), y + 11, colour, colours);
  }
}

function coloursOf(element: Element): Colours {
  const style = getComputedStyle(element);
  const colours = Object.entries(VARIABLES).map(([colour, name]) => [colour, style.getPropertyValue(`--${name}`).trim()]);
  return Object.fromEntries(colours) as Colours;
}
