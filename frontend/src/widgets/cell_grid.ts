/** Activity of cells that stand in a grid of three dimensions, in three.js: bright where it is great. */
import { BoxGeometry, Color, EdgesGeometry, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, MeshBasicMaterial } from "three";
import { View3D } from "../kit/view_3d.ts";

const LEAST_MS = 90; // from one frame to the next
const CALM_MS = 1000;

export class CellGrid extends View3D {
  private cells: InstancedMesh;
  private frame: LineSegments<EdgesGeometry, LineBasicMaterial>;
  private ramp: Color[] = [];

  /** `counts`: cells along x, y and z; z goes from left to right, y up. Levels go from 0 to `most`. */
  constructor(
    holder: HTMLElement,
    private counts: readonly [number, number, number],
    private most: number,
  ) {
    const [nx, ny, nz] = counts;
    super(holder, { field: 34, near: 0.1, far: 300, from: [-nz * 0.24, ny * 1.25, nz * 1.5] });
    this.cells = new InstancedMesh(new BoxGeometry(0.86, 0.86, 0.86), new MeshBasicMaterial(), nx * ny * nz);
    this.cells.count = 0;
    this.cells.frustumCulled = false;
    this.frame = new LineSegments(new EdgesGeometry(new BoxGeometry(nz, ny, nx)), new LineBasicMaterial());
    this.scene.add(this.cells, this.frame);
    this.dark.addEventListener("change", () => this.paint());
    this.paint();
  }

  /** Show these levels; the number of a cell is (z * ny + y) * nx + x. */
  show(levels: Uint8Array): void {
    const [nx, ny, nz] = this.counts;
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
    this.frame.material.color = named("quiet");
    this.ask();
  }

  protected override get leastMs(): number {
    return this.calm.matches ? CALM_MS : LEAST_MS;
  }

  protected override fit(): void {
    this.camera.fov = this.camera.aspect > 1.3 ? 34 : 46;
    this.camera.updateProjectionMatrix();
  }
}
