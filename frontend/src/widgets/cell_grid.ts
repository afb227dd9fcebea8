/** Activity of cells that stand in a grid of three dimensions, in three.js: bright where it is great. */
import {
  BoxGeometry,
  Color,
  EdgesGeometry,
  InstancedMesh,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  MeshBasicMaterial,
  PerspectiveCamera,
  Scene,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const FAST_MS = 90; // between two frames
const SLOW_MS = 350;
const CALM_MS = 1000;

export class CellGrid {
  private renderer: WebGLRenderer;
  private scene = new Scene();
  private camera = new PerspectiveCamera(34, 1, 0.1, 300);
  private cells: InstancedMesh;
  private frame: LineSegments;
  private ramp: Color[] = [];
  private asked = false;
  private drawn = 0;
  /** Without a graphics card each frame costs much processor time, so few are drawn. */
  private slow = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true }) === null;
  private calm = matchMedia("(prefers-reduced-motion: reduce)");

  /** `size`: cells along x, y and z; z goes from left to right, y up. Levels go from 0 to `most`. */
  constructor(
    private holder: HTMLElement,
    private size: readonly [number, number, number],
    private most: number,
  ) {
    const [nx, ny, nz] = size;
    this.renderer = new WebGLRenderer({ antialias: !this.slow, alpha: true });
    this.renderer.setPixelRatio(this.slow ? Math.min(1, devicePixelRatio) : Math.min(2, devicePixelRatio));
    const { domElement } = this.renderer;
    domElement.setAttribute("aria-hidden", "true");
    domElement.style.touchAction = "pan-y";
    holder.prepend(domElement);
    this.cells = new InstancedMesh(new BoxGeometry(0.86, 0.86, 0.86), new MeshBasicMaterial(), nx * ny * nz);
    this.cells.count = 0;
    this.cells.frustumCulled = false;
    this.frame = new LineSegments(new EdgesGeometry(new BoxGeometry(nz, ny, nx)), new LineBasicMaterial());
    this.scene.add(this.cells, this.frame);
    this.camera.position.set(-nz * 0.24, ny * 1.25, nz * 1.5);
    const controls = new OrbitControls(this.camera, domElement);
    controls.enableZoom = controls.enablePan = false;
    controls.addEventListener("change", () => this.ask());
    controls.update();
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.paint());
    this.paint();
    new ResizeObserver(() => this.fit()).observe(holder);
    this.fit();
  }

  /** Show these levels; the number of a cell is (z * ny + y) * nx + x. */
  show(levels: Uint8Array): void {
    const [nx, ny, nz] = this.size;
    const at = new Matrix4();
    let count = 0;
    for (const [number, level] of levels.entries()) {
      if (!level) continue;
      const x = number % nx,
        y = Math.floor(number / nx) % ny,
        z = Math.floor(number / (nx * ny));
      const wide = 0.4 + (0.6 * level) / this.most;
      at.makeScale(wide, wide, wide).setPosition(z - (nz - 1) / 2, y - (ny - 1) / 2, x - (nx - 1) / 2);
      this.cells.setMatrixAt(count, at);
      this.cells.setColorAt(count, this.ramp[level]!);
      count += 1;
    }
    this.cells.count = count;
    this.cells.instanceMatrix.needsUpdate = true;
    if (this.cells.instanceColor) this.cells.instanceColor.needsUpdate = true;
    this.ask();
  }

  private paint(): void {
    const style = getComputedStyle(this.holder);
    const named = (name: string): Color => new Color(style.getPropertyValue(`--${name}`).trim());
    const faint = named("cell-faint"),
      bright = named("cell-bright");
    this.ramp = Array.from({ length: this.most + 1 }, (_, level) => faint.clone().lerp(bright, level / this.most));
    (this.frame.material as LineBasicMaterial).color = named("quiet");
    this.ask();
  }

  private fit(): void {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.fov = width / height > 1.3 ? 34 : 46;
    this.camera.updateProjectionMatrix();
    this.ask();
  }

  private ask(): void {
    if (this.asked) return;
    this.asked = true;
    const least = this.calm.matches ? CALM_MS : this.slow ? SLOW_MS : FAST_MS;
    setTimeout(
      () =>
        requestAnimationFrame(() => {
          this.asked = false;
          this.drawn = performance.now();
          this.renderer.render(this.scene, this.camera);
        }),
      Math.max(0, least - (performance.now() - this.drawn)),
    );
  }
}
