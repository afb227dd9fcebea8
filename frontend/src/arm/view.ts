/** The arm in 3D: its present pose, the pose at a target, the path between, and the forbidden boxes. */
import {
  BoxGeometry,
  BufferGeometry,
  Color,
  EdgesGeometry,
  GridHelper,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  type Object3D,
  Vector3,
} from "three";
import URDFLoader, { type URDFRobot } from "urdf-loader";
import { disposeContent, setPoints, View3D } from "../kit/view_3d.ts";
import { numbersOf } from "./pose.ts";
import type { Predicted } from "./prediction.ts";

export interface ForbiddenBox {
  name: string;
  low: number[];
  high: number[];
}
const GLIDE_MS = 160;
const TARGET = 0x1292a3,
  EXPECTED = 0xb8791d; // colours of the arm at a target, and where it is expected to be
const REACH = 1.2;
const NEAREST = 0.6; // m from the camera to what it looks at
const FARTHEST = 5;
const CAMERA_AT = [1.55, 1.25, 1.75] as const;
export const LOOK = {
  field: 38,
  near: 0.05,
  far: 20,
  from: CAMERA_AT,
  to: [0.2, 0.45, 0],
  ambient: 1.6,
  lamp: 2.2,
  lampAt: [1.5, 3, 1],
} as const;

/** Return the vertical field of view (degrees) that is `times` as high as one of `field` (degrees) at the same distance. */
export function verticalField(field: number, times: number): number {
  return (360 / Math.PI) * Math.atan(Math.tan((field * Math.PI) / 360) * times);
}

export class ArmView extends View3D {
  protected readonly forbidden = new Group();
  protected readonly grid = new GridHelper(3, 30);
  protected readonly arm: URDFRobot;
  protected readonly ghost: URDFRobot;
  private expected: URDFRobot;
  private watched: URDFRobot; // where who drives has sent the arm, for who watches
  private watchedWay = new Line(new BufferGeometry(), new LineBasicMaterial({ color: TARGET }));
  private prediction: { readonly runs: boolean; readonly joints: Predicted | null } = { runs: false, joints: null };
  private path = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0x0c8a9a }));
  private from: number[] = [];
  protected to: number[] = [];
  private since = 0;
  private bad = false;
  private playing = 0;

  /** `names`: for each value of the state, the joints of the URDF that it moves. */
  constructor(
    holder: HTMLElement,
    urdf: string,
    private names: string[][],
    protected tip: string,
    boxes: ForbiddenBox[],
    onTable: (x: number, y: number) => void,
  ) {
    super(holder, LOOK, (x, y) => {
      if (Math.hypot(x, y) < REACH) onTable(x, y);
    });
    this.arm = new URDFLoader().parse(urdf);
    this.ghost = new URDFLoader().parse(urdf);
    this.expected = new URDFLoader().parse(urdf);
    this.watched = new URDFLoader().parse(urdf);
    paint(this.ghost, TARGET);
    paint(this.expected, EXPECTED);
    paint(this.watched, TARGET);
    this.ghost.visible = this.expected.visible = this.watched.visible = this.watchedWay.visible = false;
    this.world.add(this.arm, this.ghost, this.expected, this.watched, this.path, this.watchedWay, this.forbidden);
    this.boxes(boxes);
    const { grid } = this;
    grid.material.transparent = true;
    grid.material.opacity = 0.35;
    this.scene.add(grid);
    this.controls.minDistance = NEAREST;
    this.controls.maxDistance = FARTHEST;
    this.controls.maxPolarAngle = Math.PI / 2 - 0.02;
    this.canvas.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey) return; // a pinch on a trackpad is reported with Ctrl
        event.preventDefault();
        this.zoom(Math.exp(event.deltaY / 300));
      },
      { passive: false },
    );
  }

  /** Draw these forbidden boxes. */
  boxes(boxes: ForbiddenBox[]): void {
    disposeContent(this.forbidden);
    for (const box of boxes) this.forbidden.add(boxOf(box));
    this.ask();
  }

  /** Show the arm's joints (rad, m), interpolated between packets. */
  joints(q: number[]): void {
    if (this.to.length && q.every((v, i) => Math.abs(v - (this.to[i] ?? 0)) < 1e-5)) return;
    this.from = this.calm.matches || !this.to.length ? q : this.now();
    this.to = q;
    this.since = performance.now();
    this.ask();
  }

  /** Show where the arm is expected to be, beside the arm as it was told, until nothing is expected any more. */
  expect(prediction: ArmView["prediction"]): void {
    this.prediction = prediction;
    this.ask();
  }

  /** Return the tool's place (m) at such joints (rad, m); null for a model without that link. */
  toolAt(q: readonly number[]): number[] | null {
    const link = this.expected.links[this.tip];
    if (!link) return null;
    this.pose(this.expected, q);
    this.world.updateMatrixWorld(true);
    return this.world.worldToLocal(new Vector3().setFromMatrixPosition(link.matrixWorld)).toArray();
  }

  /** Show where a target would take the arm (rad, m), and the path of its tool (m); null hides both. */
  target(q: number[] | null, path: number[][] = []): void {
    if (q === null) clearInterval(this.playing);
    this.ghost.visible = q !== null;
    if (q) this.pose(this.ghost, q);
    this.path.visible = q !== null && path.length > 1;
    const points = path.map(([x = 0, y = 0, z = 0]) => new Vector3(x, y, z));
    setPoints(this.path, points);
    this.ask();
  }

  /** Show to people who watch where the arm goes (rad, m), and the path of its tool (m); null hides both. */
  goesTo(q: readonly number[] | null, path: readonly number[][] = []): void {
    this.watched.visible = this.watchedWay.visible = q !== null;
    this.holder.toggleAttribute("data-goes", q !== null);
    if (q) this.pose(this.watched, q);
    setPoints(this.watchedWay, path.map(([x = 0, y = 0, z = 0]) => new Vector3(x, y, z))); // prettier-ignore
    this.ask();
  }

  /** Move the ghost from pose to pose (a tenth of a second each); `at` is called with the index. */
  play(poses: number[][], path: number[][], at: (index: number) => void): void {
    clearInterval(this.playing);
    if (!poses.length) return this.target(null);
    let i = 0;
    const show = (): void => {
      this.target(poses[i] ?? null, path);
      at(i);
    };
    if (this.calm.matches) i = poses.length - 1;
    show();
    this.playing = window.setInterval(() => {
      i += 1;
      if (i < poses.length) show();
      else {
        clearInterval(this.playing);
        at(-1);
      }
    }, 100);
  }

  /** In a view that is higher than wide, see as much to the sides as a square one does. */
  protected override fit(): void {
    this.camera.fov = verticalField(LOOK.field, 1 / Math.min(1, this.camera.aspect));
    this.camera.updateProjectionMatrix();
  }

  /** Move the camera nearer (a factor below 1) or farther; 0 puts it back where it was at the start. */
  zoom(factor: number): void {
    const { position } = this.camera;
    const { target } = this.controls;
    if (factor === 0) position.set(...CAMERA_AT);
    const way = position.clone().sub(target);
    if (factor > 0) position.copy(target).add(way.setLength(Math.min(FARTHEST, Math.max(NEAREST, way.length() * factor))));
    this.controls.update();
    this.ask();
  }

  /** Colour the ghost as refused or not. */
  refused(bad: boolean): void {
    if (bad === this.bad) return;
    this.bad = bad;
    this.ghost.traverse((part) => {
      const { material } = part as { material?: unknown };
      if (material instanceof MeshLambertMaterial) material.color.set(bad ? 0xd23b2f : TARGET);
    });
    this.ask();
  }

  /** Return the tool's position (m) and rotation (roll, pitch, yaw in rad), by the arm's joints; null if not known. */
  tool(): number[] | null {
    const link = this.arm.links[this.tip];
    if (!link || !this.to.length) return null;
    this.pose(this.arm, this.to);
    this.world.updateMatrixWorld(true);
    return numbersOf(new Matrix4().copy(this.world.matrixWorld).invert().multiply(link.matrixWorld));
  }

  private now(): number[] {
    const share = Math.min(1, (performance.now() - this.since) / GLIDE_MS);
    return this.to.map((v, i) => (this.from[i] ?? v) + (v - (this.from[i] ?? v)) * share);
  }

  private pose(robot: URDFRobot, q: readonly number[]): void {
    this.names.forEach((named, i) => {
      for (const name of named) if (name in robot.joints) robot.setJointValue(name, q[i] ?? 0);
    });
  }

  protected override move(): boolean {
    if (!this.to.length) return false;
    this.pose(this.arm, this.now());
    const expected = this.prediction.joints;
    this.expected.visible = expected !== null;
    this.holder.toggleAttribute("data-expected", expected !== null);
    if (expected) this.pose(this.expected, [...expected.predicted, ...this.to.slice(expected.predicted.length)]);
    return this.prediction.runs || performance.now() - this.since < GLIDE_MS;
  }
}

function boxOf(box: ForbiddenBox): Object3D {
  const flatten = box.high[2] === 0 ? -0.02 : 0; // the part below the table's top is not drawn
  const lows = [box.low[0] ?? 0, box.low[1] ?? 0, Math.max(box.low[2] ?? 0, flatten)];
  const size = box.high.map((h, i) => h - (lows[i] ?? 0));
  const [sx = 1, sy = 1, sz = 1] = size;
  const shape = new BoxGeometry(sx, sy, sz);
  const flat = sx > 2; // the table: its edges would only be in the way
  const made = new Group();
  made.add(new Mesh(shape, new MeshBasicMaterial({ color: 0xd23b2f, transparent: true, opacity: flat ? 0.07 : 0.16, depthWrite: false })));
  if (!flat) made.add(new LineSegments(new EdgesGeometry(shape), new LineBasicMaterial({ color: new Color(0xd23b2f) })));
  const middle = lows.map((l, i) => (l + (box.high[i] ?? 0)) / 2);
  made.position.set(middle[0] ?? 0, middle[1] ?? 0, middle[2] ?? 0);
  made.name = box.name;
  return made;
}

function paint(robot: URDFRobot, color: number): void {
  robot.traverse((part) => {
    if (part instanceof Mesh) part.material = new MeshLambertMaterial({ color, transparent: true, opacity: 0.38, depthWrite: false });
  });
}
