/** A view in three dimensions: drawn when something has changed, turned by dragging, clicked on at the floor. */
import {
  AmbientLight,
  BufferGeometry,
  DirectionalLight,
  Group,
  type Line,
  type Material,
  type Object3D,
  PerspectiveCamera,
  Plane,
  Raycaster,
  Scene,
  type Texture,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

type Point = readonly [number, number, number];
const LEAST_MS = 25,
  MOST_MS = 300, // from one frame to the next
  SHARE = 0.5; // of the time may be drawn, if the processor draws
const SOON_MS = 20; // a shorter pause is left out
const DRAG_PX = 5; // a press that moved farther than this turns the view

interface ViewSettings {
  /** The camera's field of view (degrees), and the distances (m) between which it sees something. */
  field: number;
  near: number;
  far: number;
  /** Where the camera is at first, and what it looks at (m; x to the right, y up, z to the viewer). */
  from: Point;
  to?: Point;
  /** The brightness of the ambient light and of a lamp, and where the lamp is (m). Without them only plain colours are seen. */
  ambient?: number;
  lamp?: number;
  lampAt?: Point;
}

export class View3D {
  protected readonly scene = new Scene();
  /** What a robot calls its world: x and y on the floor, z up (m). */
  protected readonly world = new Group();
  protected readonly camera: PerspectiveCamera;
  protected readonly controls: OrbitControls;
  protected readonly dark = matchMedia("(prefers-color-scheme: dark)");
  protected readonly calm = matchMedia("(prefers-reduced-motion: reduce)");
  protected readonly canvas: HTMLCanvasElement;
  protected readonly holder: HTMLElement;
  private renderer: WebGLRenderer;
  private asked = false;
  private drawn = 0;
  private fence: WebGLSync | null = null; // of the last frame, until it is known how long it took
  private tookMs = 0;
  /** Without a graphics card each frame costs much processor time: fewer are drawn, and with less effort. */
  protected readonly slow = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true }) === null;

  /** `onPick` gets the place on the world's floor that was clicked on (m). Throws an error in a browser without WebGL. */
  constructor(
    holder: HTMLElement,
    { field, near, far, from, to = [0, 0, 0], ambient = 0, lamp = 0, lampAt = [0, 1, 0] }: ViewSettings,
    onPick: (x: number, y: number) => void = () => undefined,
  ) {
    this.holder = holder;
    this.renderer = new WebGLRenderer({ antialias: !this.slow, alpha: true });
    this.renderer.setPixelRatio(Math.min(this.slow ? 1 : 2, devicePixelRatio));
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute("aria-hidden", "true");
    holder.prepend(this.canvas);
    this.world.rotation.x = -Math.PI / 2;
    const light = new DirectionalLight(0xffffff, lamp);
    light.position.set(...lampAt);
    this.scene.add(this.world, light, new AmbientLight(0xffffff, ambient));
    this.camera = new PerspectiveCamera(field, 1, near, far);
    this.camera.position.set(...from);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.canvas.style.touchAction = "pan-y";
    this.controls.target.set(...to);
    this.controls.enableZoom = this.controls.enablePan = false; // the page is scrolled with the same wheel and fingers
    this.controls.addEventListener("change", () => this.ask());
    this.controls.update();
    this.dark.addEventListener("change", () => this.ask());
    this.pick(onPick);
    new ResizeObserver(() => this.size()).observe(holder);
    this.size();
  }

  /** The shortest time from one frame to the next (ms). */
  protected get leastMs(): number {
    return LEAST_MS;
  }

  /** Draw a frame soon. */
  protected ask(): void {
    if (this.asked) return;
    this.asked = true;
    const betweenMs = Math.max(this.leastMs, Math.min(MOST_MS, this.tookMs / SHARE)),
      pause = Math.max(0, betweenMs - (performance.now() - this.drawn));
    const frame = (): unknown => requestAnimationFrame(() => this.draw());
    if (pause > SOON_MS) setTimeout(frame, pause);
    else frame();
  }

  /** Put everything where it is now, before a frame. Returns whether another frame has to follow. */
  protected move(): boolean {
    return false;
  }

  /** Adapt the camera to the size of the view. */
  protected fit(): void {}

  private draw(): void {
    if (this.fence) return void requestAnimationFrame(() => this.draw()); // the last frame is still being drawn
    this.asked = false;
    this.drawn = performance.now();
    if (!this.holder.clientWidth) return; // hidden; its size asks again
    const again = this.move();
    this.renderer.render(this.scene, this.camera);
    if (this.slow) this.measure();
    if (again) this.ask();
  }

  /** Learn how long the processor draws at the last frame, without waiting for it. */
  private measure(): void {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = (): void => {
      const late = performance.now() - this.drawn > MOST_MS;
      if (this.fence && !late && gl.getSyncParameter(this.fence, gl.SYNC_STATUS) !== gl.SIGNALED) return void requestAnimationFrame(look);
      this.tookMs = performance.now() - this.drawn;
      gl.deleteSync(this.fence);
      this.fence = null;
    };
    requestAnimationFrame(look);
  }

  private size(): void {
    const { clientWidth: width, clientHeight } = this.holder,
      height = clientHeight - parseFloat(getComputedStyle(this.holder).paddingBottom); // where buttons may be
    if (!width || height <= 0) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.fit();
    this.ask();
  }

  private pick(onPick: (x: number, y: number) => void): void {
    let down = [0, 0];
    this.canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    this.canvas.addEventListener("click", (event) => {
      if (Math.hypot(event.clientX - down[0]!, event.clientY - down[1]!) > DRAG_PX) return;
      const box = this.canvas.getBoundingClientRect(),
        ray = new Raycaster();
      ray.setFromCamera(
        new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2),
        this.camera,
      );
      const point = ray.ray.intersectPlane(new Plane(new Vector3(0, 1, 0), 0), new Vector3());
      if (point) onPick(...(this.world.worldToLocal(point).toArray().slice(0, 2) as [number, number]));
    });
  }
}

/** Make a line go through these points (m). */
export function setPoints(line: Line, points: readonly Vector3[]): void {
  line.geometry.dispose();
  line.geometry = new BufferGeometry().setFromPoints([...points]);
}

/** Remove everything from a group, and free its memory on the graphics card. */
export function disposeContent(group: Object3D): void {
  group.traverse((part) => {
    const { geometry, material } = part as { geometry?: BufferGeometry; material?: Material & { map?: Texture | null } };
    geometry?.dispose();
    material?.map?.dispose();
    material?.dispose();
  });
  group.clear();
}
