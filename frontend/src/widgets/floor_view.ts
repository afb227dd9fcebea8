/** A floor in 3D: walls, cuboids and round things with their names, a robot that drives on it, its ghost and a path. */
import {
  AmbientLight, BoxGeometry, BufferGeometry, CanvasTexture, CylinderGeometry, DirectionalLight, EdgesGeometry, Group, Line,
  LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Plane, PlaneGeometry, Raycaster, Scene, Sprite,
  SpriteMaterial, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

/** What stands on the floor (m): a cuboid by its half sides, or something round by its radius. */
export interface Standing { name: string; at: readonly [number, number]; high: number; half?: readonly [number, number]; radius?: number; dark?: boolean }
export interface Floor { width: number; depth: number; standing: readonly Standing[]; marks: readonly { name: string; at: readonly [number, number] }[] }
/** Length, width and height of the robot (m). */
export type Size = readonly [number, number, number];
type Pose = readonly [number, number, number];

const FAST_MS = 25, SLOW_MS = 300; // between two frames
const PATH_M = 0.03; // above the floor
const DRAG_PX = 6; // a press that moved farther turns the view
const COLOURS = { light: { floor: 0xe9dcc4, wall: 0xcdbfa6, line: 0x8b8272, ink: "#2b2f33" }, dark: { floor: 0x34373c, wall: 0x55585e, line: 0x9a9fa8, ink: "#f1ece2" } };

export class FloorView {
  private renderer: WebGLRenderer;
  private scene = new Scene();
  private camera = new PerspectiveCamera(40, 1, 0.1, 100);
  private controls: OrbitControls;
  private world = new Group(); // x right, y up on the floor, z up
  private fixed = new Group();
  private robot: Group;
  private ghostBody: Group;
  private path = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0xb4531b, linewidth: 2 }));
  private asked = false;
  private drawn = 0;
  /** Without a graphics card each frame costs much processor time, so few are drawn. */
  private slow = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true }) === null;
  private dark = matchMedia("(prefers-color-scheme: dark)");

  /** `onPick` gets the place on the floor (m) that was clicked on. */
  constructor(private holder: HTMLElement, private floor: Floor, size: Size, onPick: (x: number, y: number) => void) {
    this.renderer = new WebGLRenderer({ antialias: !this.slow, alpha: true });
    this.renderer.setPixelRatio(this.slow ? 1 : Math.min(2, devicePixelRatio));
    const { domElement } = this.renderer;
    domElement.setAttribute("aria-hidden", "true");
    domElement.style.touchAction = "pan-y";
    holder.prepend(domElement);
    this.world.rotation.x = -Math.PI / 2;
    this.world.position.set(-floor.width / 2, 0, floor.depth / 2);
    this.robot = bodyOf(size, 0x0c6471, 1);
    this.ghostBody = bodyOf(size, 0xb4531b, 0.55);
    this.robot.visible = this.ghostBody.visible = false;
    const lamp = new DirectionalLight(0xffffff, 1.9);
    lamp.position.set(3, 9, 5);
    this.scene.add(this.world, lamp, new AmbientLight(0xffffff, 1.5));
    this.world.add(this.fixed, this.robot, this.ghostBody, this.path);
    this.controls = new OrbitControls(this.camera, domElement);
    this.controls.maxPolarAngle = Math.PI / 2 - 0.05;
    this.controls.enableZoom = this.controls.enablePan = false; // the page is scrolled with the same wheel and fingers
    this.controls.addEventListener("change", () => this.ask());
    this.camera.position.set(0, floor.depth * 1.05, floor.depth * 1.02);
    this.controls.update();
    this.build();
    this.dark.addEventListener("change", () => this.build());
    this.pick(domElement, onPick);
    new ResizeObserver(() => this.size()).observe(holder);
    this.size();
  }

  /** Put the robot where it is (m, m, rad); null while that is not known. */
  show(at: Pose | null): void {
    place(this.robot, at);
    this.ask();
  }

  ghost(at: Pose | null): void {
    place(this.ghostBody, at);
    this.ask();
  }

  /** Draw a path by its corners; null for none. */
  plan(corners: readonly Pose[] | null, good: boolean): void {
    this.path.geometry.dispose();
    this.path.geometry = new BufferGeometry().setFromPoints((corners ?? []).map(([x, y]) => new Vector3(x, y, PATH_M)));
    this.path.visible = (corners?.length ?? 0) > 1;
    this.path.material.color.set(good ? 0xb4531b : 0xc0271f);
    this.ask();
  }

  private build(): void {
    const colours = COLOURS[this.dark.matches ? "dark" : "light"], { width, depth, standing, marks } = this.floor;
    this.fixed.clear();
    const ground = new Mesh(new PlaneGeometry(width, depth), new MeshLambertMaterial({ color: colours.floor }));
    ground.position.set(width / 2, depth / 2, 0);
    this.fixed.add(ground);
    const wall = new MeshLambertMaterial({ color: colours.wall });
    for (const [x, y, w, d] of [[width / 2, depth + 0.05, width + 0.2, 0.1], [-0.05, depth / 2, 0.1, depth], [width + 0.05, depth / 2, 0.1, depth]] as const) {
      const made = new Mesh(new BoxGeometry(w, d, 0.7), wall);
      made.position.set(x, y, 0.35);
      this.fixed.add(made);
    }
    for (const one of standing) this.fixed.add(...thing(one, colours));
    for (const { name, at } of marks) {
      const made = new Mesh(new CylinderGeometry(0.1, 0.1, 0.02, 20), new MeshLambertMaterial({ color: colours.line }));
      made.rotation.x = Math.PI / 2;
      made.position.set(at[0], at[1], 0.01);
      this.fixed.add(made, label(name, [at[0], at[1] - 0.22, 0.06], colours.ink, 0.2));
    }
    this.ask();
  }

  private pick(element: HTMLElement, onPick: (x: number, y: number) => void): void {
    let from: [number, number] | null = null;
    element.addEventListener("pointerdown", (event) => (from = [event.clientX, event.clientY]));
    element.addEventListener("pointerup", (event) => {
      const still = from !== null && Math.hypot(event.clientX - from[0], event.clientY - from[1]) < DRAG_PX;
      from = null;
      if (!still) return;
      const box = element.getBoundingClientRect(), ray = new Raycaster(), hit = new Vector3();
      ray.setFromCamera(new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2), this.camera);
      if (!ray.ray.intersectPlane(new Plane(new Vector3(0, 1, 0), 0), hit)) return;
      const x = hit.x + this.floor.width / 2, y = this.floor.depth / 2 - hit.z;
      if (x >= 0 && y >= 0 && x <= this.floor.width && y <= this.floor.depth) onPick(x, y);
    });
  }

  private size(): void {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.ask();
  }

  private ask(): void {
    if (this.asked) return;
    this.asked = true;
    const pause = this.slow ? SLOW_MS : FAST_MS;
    setTimeout(() => requestAnimationFrame(() => this.draw()), Math.max(0, pause - (performance.now() - this.drawn)));
  }

  private draw(): void {
    this.asked = false;
    this.drawn = performance.now();
    if (this.holder.clientWidth) this.renderer.render(this.scene, this.camera);
  }
}

function thing({ name, at: [x, y], high, half, radius = 0.3, dark }: Standing, colours: { line: number; ink: string }): (Mesh | LineSegments | Sprite)[] {
  const shape = half ? new BoxGeometry(2 * half[0], 2 * half[1], high) : new CylinderGeometry(radius, radius, high, 32);
  const look = new MeshLambertMaterial({ color: dark ? 0x23262a : half ? 0x9fc3c8 : 0xb9a684, transparent: !!half && !dark, opacity: half && !dark ? 0.75 : 1 });
  const made = new Mesh(shape, look), edges = new LineSegments(new EdgesGeometry(shape, 30), new LineBasicMaterial({ color: colours.line }));
  for (const part of [made, edges]) {
    if (!half) part.rotation.x = Math.PI / 2;
    part.position.set(x, y, high / 2);
  }
  return [made, edges, label(name, [x, y, high + 0.22], colours.ink, 0.3)];
}

function label(words: string, [x, y, z]: readonly [number, number, number], ink: string, tall: number): Sprite {
  const canvas = document.createElement("canvas"), context = canvas.getContext("2d")!;
  const font = "600 44px system-ui, sans-serif";
  context.font = font;
  canvas.width = Math.ceil(context.measureText(words).width) + 16;
  canvas.height = 60;
  Object.assign(context, { font, fillStyle: ink, textBaseline: "middle", textAlign: "center" });
  context.fillText(words, canvas.width / 2, 30);
  const made = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), depthTest: false }));
  made.scale.set((tall * canvas.width) / canvas.height, tall, 1);
  made.position.set(x, y, z);
  return made;
}

function bodyOf([long, wide, high]: Size, colour: number, opacity: number): Group {
  const group = new Group(), look = new MeshLambertMaterial({ color: colour, transparent: opacity < 1, opacity });
  const hull = new Mesh(new BoxGeometry(long, wide * 0.8, high * 0.6), look);
  hull.position.z = high * 0.55;
  const eye = new Mesh(new BoxGeometry(long * 0.16, wide * 0.3, high * 0.35), new MeshLambertMaterial({ color: 0x2b2f33, transparent: opacity < 1, opacity }));
  eye.position.set(long * 0.42, 0, high * 0.95);
  group.add(hull, eye);
  for (const side of [-1, 1]) for (const end of [-1, 1]) {
    const wheel = new Mesh(new CylinderGeometry(high * 0.28, high * 0.28, wide * 0.18, 18), new MeshLambertMaterial({ color: 0x2b2f33, transparent: opacity < 1, opacity }));
    wheel.position.set(end * long * 0.3, side * wide * 0.45, high * 0.28);
    group.add(wheel);
  }
  return group;
}

function place(body: Group, at: Pose | null): void {
  body.visible = at !== null;
  if (!at) return;
  body.position.set(at[0], at[1], 0);
  body.rotation.z = at[2];
}
