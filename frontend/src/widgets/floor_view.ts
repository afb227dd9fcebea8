/** A floor in 3D: walls, cuboids and round things with their names, a robot that drives on it, its ghost and a path. */
import {
  BoxGeometry,
  BufferGeometry,
  CanvasTexture,
  CircleGeometry,
  ConeGeometry,
  CylinderGeometry,
  EdgesGeometry,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PlaneGeometry,
  RingGeometry,
  Sprite,
  SpriteMaterial,
  Vector3,
} from "three";
import { disposeContent, setPoints, View3D } from "../kit/view_3d.ts";

/** What stands on the floor (m): a cuboid by its half sides, or something round by its radius. */
export interface Standing {
  name: string;
  at: readonly [number, number];
  high: number;
  half?: readonly [number, number];
  radius?: number;
  dark?: boolean;
}
export interface Floor {
  width: number;
  depth: number;
  standing: readonly Standing[];
  marks: readonly { name: string; at: readonly [number, number] }[];
}
/** Length, width and height of the robot (m). */
type Size = readonly [number, number, number];
type Pose = readonly [number, number, number];

const PATH_M = 0.03,
  RING_M = 0.02; // above the floor
const PIN_M = 0.5; // the height of the mark where it goes: showcases hide what lies on the floor
const WALL_M = 0.7;
const FROM = new Vector3(0, 1.05, 1.02); // the direction in which the camera is at first
const LOOK = { field: 40, near: 0.1, far: 100, from: FROM.toArray(), ambient: 1.5, lamp: 1.9, lampAt: [3, 9, 5] } as const;
const TURNED_RAD = 0.01;
const EDGE = 0.96; // of the view, in which the whole floor is
const COLOURS = {
  light: { floor: 0xe9dcc4, wall: 0xcdbfa6, line: 0x8b8272, ink: "#2b2f33", ring: 0x0c6471 },
  dark: { floor: 0x34373c, wall: 0x55585e, line: 0x9a9fa8, ink: "#f1ece2", ring: 0x6cc6d3 },
};

export class FloorView extends View3D {
  private fixed = new Group();
  private robot: Group;
  private ghostBody: Group;
  private goal = pin();
  private turned = false; // whether somebody has turned the view; a click alone does not
  private ringLook = new MeshBasicMaterial();
  private polar = 0; // the camera's polar angle after `fit` (rad)
  private path = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0xb4531b, linewidth: 2 }));

  /** `onPick` gets the place on the floor (m) that was clicked on. */
  constructor(
    holder: HTMLElement,
    private floor: Floor,
    size: Size,
    onPick: (x: number, y: number) => void,
  ) {
    const { width, depth } = floor;
    super(holder, LOOK, (x, y) => {
      if (x >= 0 && y >= 0 && x <= width && y <= depth) onPick(x, y);
    });
    this.world.position.set(-width / 2, 0, depth / 2);
    this.controls.maxPolarAngle = Math.PI / 2 - 0.05;
    this.controls.addEventListener("end", () => {
      const { controls, polar } = this;
      this.turned = Math.hypot(controls.getAzimuthalAngle(), controls.getPolarAngle() - polar) > TURNED_RAD;
    });
    this.robot = bodyOf(size, 0x0c6471, 1);
    this.robot.add(...ring(size, this.ringLook));
    this.ghostBody = bodyOf(size, 0xb4531b, 0.55);
    this.robot.visible = this.ghostBody.visible = this.goal.visible = false;
    this.world.add(this.fixed, this.robot, this.ghostBody, this.goal, this.path);
    this.build();
    this.fit();
    this.dark.addEventListener("change", () => this.build());
  }

  /** Show the robot at this pose (m, m, rad); null while its pose is not known. */
  show(at: Pose | null): void {
    place(this.robot, at);
    this.ask();
  }

  ghost(at: Pose | null): void {
    place(this.ghostBody, at);
    this.ask();
  }

  /** Mark the place (m) to which the robot drives; null for none. */
  mark(at: readonly [number, number] | null): void {
    place(this.goal, at && [...at, 0]);
    this.holder.toggleAttribute("data-goes", at !== null);
    this.ask();
  }

  /** Draw a path by its corners; null for none. */
  plan(corners: readonly Pose[] | null, good: boolean): void {
    const points = (corners ?? []).map(([x, y]) => new Vector3(x, y, PATH_M));
    setPoints(this.path, points);
    this.path.visible = (corners?.length ?? 0) > 1;
    this.path.material.color.set(good ? 0xb4531b : 0xc0271f);
    this.ask();
  }

  /** Move the camera as near as the whole floor can be seen, until somebody has turned the view. */
  protected override fit(): void {
    // eslint-disable-next-line @typescript-eslint/no-unnecessary-condition -- the size is told before there is a floor
    if (!this.floor || this.turned) return;
    const { width, depth } = this.floor;
    const corners = [-1, 1].flatMap((x) => [-1, 1].map((z) => new Vector3((x * width) / 2, z < 0 ? WALL_M : 0, (z * depth) / 2)));
    const seen = (): boolean =>
      corners.every((corner) => {
        const { x, y } = corner.clone().project(this.camera);
        return Math.abs(x) < EDGE && Math.abs(y) < EDGE;
      });
    for (let far = depth; far < 10 * depth; far *= 1.02) {
      this.camera.position.copy(FROM).setLength(far);
      this.camera.lookAt(this.controls.target);
      this.camera.updateMatrixWorld();
      if (seen()) break;
    }
    this.controls.update();
    this.polar = this.controls.getPolarAngle();
  }

  private build(): void {
    const colours = COLOURS[this.dark.matches ? "dark" : "light"],
      { width, depth, standing, marks } = this.floor;
    disposeContent(this.fixed);
    this.ringLook.color.set(colours.ring);
    const ground = new Mesh(new PlaneGeometry(width, depth), new MeshLambertMaterial({ color: colours.floor }));
    ground.position.set(width / 2, depth / 2, 0);
    this.fixed.add(ground);
    const wall = new MeshLambertMaterial({ color: colours.wall });
    for (const [x, y, w, d] of [
      [width / 2, depth + 0.05, width + 0.2, 0.1],
      [-0.05, depth / 2, 0.1, depth],
      [width + 0.05, depth / 2, 0.1, depth],
    ] as const) {
      const made = new Mesh(new BoxGeometry(w, d, WALL_M), wall);
      made.position.set(x, y, WALL_M / 2);
      this.fixed.add(made);
    }
    for (const one of standing) this.fixed.add(...thing(one, colours));
    for (const { name, at } of marks) {
      const made = new Mesh(new CylinderGeometry(0.1, 0.1, 0.02, 20), new MeshLambertMaterial({ color: colours.line }));
      made.rotation.x = Math.PI / 2;
      made.position.set(at[0], at[1], 0.01);
      this.fixed.add(made, label(name, [at[0], at[1] - 0.3, 0.16], colours.ink, 0.24, true));
    }
    this.ask();
  }
}

type Colours = { line: number; ink: string };

function thing({ name, at, high, half, radius = 0.3, dark }: Standing, colours: Colours): (Mesh | LineSegments | Sprite)[] {
  const [x, y] = at;
  const shape = half ? new BoxGeometry(2 * half[0], 2 * half[1], high) : new CylinderGeometry(radius, radius, high, 32);
  const glass = half !== undefined && !dark;
  const color = dark ? 0x23262a : half ? 0x9fc3c8 : 0xb9a684;
  const look = new MeshLambertMaterial({ color, transparent: glass, opacity: glass ? 0.75 : 1 });
  const made = new Mesh(shape, look),
    edges = new LineSegments(new EdgesGeometry(shape, 30), new LineBasicMaterial({ color: colours.line }));
  for (const part of [made, edges]) {
    if (!half) part.rotation.x = Math.PI / 2;
    part.position.set(x, y, high / 2);
  }
  return [made, edges, label(name, [x, y, high + 0.22], colours.ink, 0.3)];
}

/** `behind`: things in front of the label hide it. */
function label(words: string, [x, y, z]: readonly [number, number, number], ink: string, tall: number, behind = false): Sprite {
  const canvas = document.createElement("canvas"),
    context = canvas.getContext("2d")!;
  const font = "600 44px system-ui, sans-serif";
  context.font = font;
  canvas.width = Math.ceil(context.measureText(words).width) + 16;
  canvas.height = 60;
  Object.assign(context, { font, fillStyle: ink, textBaseline: "middle", textAlign: "center" });
  context.fillText(words, canvas.width / 2, 30);
  const made = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), depthTest: behind, depthWrite: false }));
  made.scale.set((tall * canvas.width) / canvas.height, tall, 1);
  made.position.set(x, y, z);
  return made;
}

function bodyOf([long, wide, high]: Size, colour: number, opacity: number): Group {
  const group = new Group(),
    look = new MeshLambertMaterial({ color: colour, transparent: opacity < 1, opacity });
  const hull = new Mesh(new BoxGeometry(long, wide * 0.8, high * 0.6), look);
  hull.position.z = high * 0.55;
  const dark = new MeshLambertMaterial({ color: 0x2b2f33, transparent: opacity < 1, opacity });
  const eye = new Mesh(new BoxGeometry(long * 0.16, wide * 0.3, high * 0.35), dark);
  eye.position.set(long * 0.42, 0, high * 0.95);
  group.add(hull, eye);
  for (const side of [-1, 1])
    for (const end of [-1, 1]) {
      const wheel = new Mesh(new CylinderGeometry(high * 0.28, high * 0.28, wide * 0.18, 18), dark);
      wheel.position.set(end * long * 0.3, side * wide * 0.45, high * 0.28);
      group.add(wheel);
    }
  return group;
}

/** A ring around the robot with a tip where it looks, because the robot is small in its hall. */
function ring([long]: Size, look: MeshBasicMaterial): Mesh[] {
  const around = new Mesh(new RingGeometry(long * 1.15, long * 1.4, 40), look),
    tip = new Mesh(new CircleGeometry(long * 0.45, 3), look);
  tip.position.x = long * 1.6;
  for (const part of [around, tip]) part.position.z = RING_M;
  return [around, tip];
}

/** A ring on the floor with a pin above it. */
function pin(): Group {
  const group = new Group(),
    look = new MeshBasicMaterial({ color: 0xb4531b });
  const around = new Mesh(new RingGeometry(0.24, 0.34, 40), look),
    cone = new Mesh(new ConeGeometry(0.14, PIN_M, 20), look);
  around.position.z = RING_M;
  cone.rotation.x = -Math.PI / 2; // its tip shows to the floor
  cone.position.z = PIN_M / 2 + RING_M;
  group.add(around, cone);
  return group;
}

function place(body: Group, at: Pose | null): void {
  body.visible = at !== null;
  if (!at) return;
  body.position.set(at[0], at[1], 0);
  body.rotation.z = at[2];
}
