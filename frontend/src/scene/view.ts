/** The arm in 3D with the ghost of its tool, which a pointer takes by handles; the objects, and where the camera stands. */
import {
  BufferGeometry,
  type Camera,
  Line,
  LineBasicMaterial,
  type Material,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Object3D,
  RingGeometry,
  Vector3,
} from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import type { URDFJoint } from "urdf-loader";
import { ArmView, LOOK, verticalField } from "../arm/view.ts";
import { setPoints } from "../kit/view_3d.ts";
import type { Pose } from "../motion/chain.ts";
import { turnOf } from "../motion/linear.ts";
import type { Judgement } from "./judge.ts";
import type { Move } from "./moves.ts";
import { ObjectShapes, plateOf } from "./object_shapes.ts";
import type { KnownObject, PlateFacts } from "./known.ts";

/** What a pointer does with the handles. `dragged`: how far since they were taken. */
export interface Handles {
  taken(): void;
  dragged(by: Move): void;
  released(): void;
}
/** A calibrated camera: the place of its lens and a point in the middle of its picture (m), its horizontal field of view. */
export interface CameraPlace {
  name: string;
  place: number[];
  at: number[];
  field_deg: number;
}

const HAND_OPACITY = 0.62;
const HANDLE_SIZE = 1,
  FINGER_SIZE = 1.5; // of the handles, where fingers use them
const PICTURE = 3 / 4; // height of a camera's picture by its width
const RED = 0xd23b2f,
  GREEN = 0x2e9e4f,
  TEAL = 0x1292a3,
  WARM = 0xffb000;
/** Where the camera stands for each viewpoint, from what it looks at (m; x away from the base, y left, z up). */
const VIEWPOINTS: Record<string, [number, number, number]> = { front: [2.3, 0, 0.35], side: [0, -2.3, 0.35], top: [-0.02, 0, 2.4] };
const MIDDLE = [0.35, 0, 0.3] as const;

export class SceneView extends ArmView {
  private handle = new Object3D(); // stands at the ghost, not turned, and goes with the pointer while it is held
  private takenAt = new Vector3(); // where it stood before that
  private handles = handlesOf(this.camera, this.canvas);
  private drop = new Line(new BufferGeometry(), new LineBasicMaterial({ color: TEAL, transparent: true, opacity: 0.7 }));
  private spot = new Mesh(new RingGeometry(0.012, 0.018, 32), new MeshBasicMaterial({ color: TEAL, transparent: true, opacity: 0.8 }));
  private chosen = new Mesh(
    new RingGeometry(0.016, 0.024, 32),
    new MeshBasicMaterial({ color: WARM, depthTest: false, transparent: true }),
  );
  private rubber = new Line(new BufferGeometry(), new LineBasicMaterial({ color: RED }));
  private use: Handles | null = null;
  private wide = 0; // see `look`
  private shapes = new ObjectShapes(this.world, this.arm.links[this.tip], this.ghost.links[this.tip]);
  /** Called when the view is turned, moved or zoomed. */
  onTurned: () => void = () => undefined;
  private pointer = -1; // that holds the handles

  /** Let a pointer take the ghost. Called once. */
  offer(use: Handles): void {
    this.use = use;
    this.emphasizeHand();
    this.spot.position.z = 0.001;
    this.world.add(this.handle, this.drop, this.spot, this.rubber, this.chosen);
    this.place(null);
    const { handles } = this;
    handles.setSpace("local"); // the handle is not turned, so its axes are those of the base
    handles.setSize(matchMedia("(pointer: coarse)").matches ? FINGER_SIZE : HANDLE_SIZE);
    handles.showE = handles.showXYZE = false;
    this.scene.add(handles.getHelper());
    this.listen();
    this.ghostAt(null);
  }

  private listen(): void {
    const { handles, canvas, holder } = this;
    this.controls.addEventListener("start", () => this.onTurned());
    handles.addEventListener("change", () => {
      canvas.style.cursor = handles.axis ? "grab" : "";
      this.ask();
    });
    handles.addEventListener("objectChange", () => this.use?.dragged(this.way()));
    handles.addEventListener("dragging-changed", ({ value }) => this.holding(value === true));
    canvas.addEventListener("touchstart", (event) => handles.dragging && event.preventDefault(), { passive: false });
    // only the pointer that took the handles moves them; a second finger would make them leap
    const others = (event: PointerEvent): void => {
      if (handles.dragging && event.pointerId !== this.pointer) event.stopPropagation();
      else if (event.type === "pointerdown" && event.target === canvas) this.prepareHandles(event);
    };
    for (const name of ["pointerdown", "pointermove", "pointerup"] as const) holder.addEventListener(name, others, true);
    for (const name of ["pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(name, (event) => event.pointerId === this.pointer && this.letGo());
  }

  /**
   * Prepare the handles for the pointer that takes them. They know the camera and the plane of a drag from the last
   * frame in which something hovered over them; a finger does not hover, and the ghost would leap.
   */
  private prepareHandles({ clientX, clientY, pointerId }: PointerEvent): void {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.pointer = pointerId;
    const at = { x: ((clientX - left) / width) * 2 - 1, y: 1 - ((clientY - top) / height) * 2, button: -1 };
    this.handles.getHelper().updateMatrixWorld(true);
    this.handles.pointerHover(at as unknown as PointerEvent);
    this.handles.getHelper().updateMatrixWorld(true);
  }

  private holding(held: boolean): void {
    this.controls.enabled = !held;
    if (held) this.use?.taken();
    else this.use?.released();
  }

  /** End a drag: the pointer moves nothing until it is pressed again. */
  letGo(): void {
    if (this.handles.dragging) this.handles.pointerUp(null);
  }

  /** Return how far the handle was moved since it was taken. */
  private way(): Move {
    const { x, y, z } = this.handle.position.clone().sub(this.takenAt),
      [u = 0, v = 0, w = 0] = turnOf(this.handle.quaternion.toArray());
    return [x, y, z, u, v, w];
  }

  /** Choose what the handles do. */
  handleMode(mode: "translate" | "rotate"): void {
    this.letGo();
    this.handles.setMode(mode);
    this.ask();
  }

  /** Show the handles at a pose of the tool in the base's frame (4 x 4, row by row); null hides everything of the ghost. */
  ghostAt(pose: Pose | null, judgement: Judgement | null = null, refusal = "", snapped = false): void {
    const shown = pose !== null;
    if (!shown) {
      this.letGo();
      this.handles.detach();
      this.target(null);
    } else {
      const at = new Vector3(pose[3], pose[7], pose[11]);
      if (!this.handles.dragging) this.stand(at);
      if (this.handles.object !== this.handle) this.handles.attach(this.handle);
      this.mark(at, refusal !== "" ? RED : snapped ? GREEN : TEAL);
      this.refused(refusal !== "" || judgement?.verdict === "way");
      const joints = judgement?.joints;
      this.target(joints ? [...joints, ...this.to.slice(joints.length)] : null, judgement?.path.map((place) => [...place]) ?? []);
    }
    for (const part of [this.drop, this.spot]) part.visible = shown;
    this.rubber.visible = shown && this.handles.dragging && refusal !== "";
    this.ask();
  }

  private stand(at: Vector3): void {
    this.handle.position.copy(at);
    this.handle.quaternion.identity();
    this.takenAt.copy(at);
  }

  /** Show how high it is, by a line down to the table; its colour tells whether it is at a surface or has snapped. */
  private mark(at: Vector3, colour: number): void {
    setPoints(this.drop, [at, new Vector3(at.x, at.y, 0)]);
    this.spot.position.set(at.x, at.y, 0.001);
    setPoints(this.rubber, [at, this.handle.position]);
    for (const { material } of [this.drop, this.spot]) material.color.set(colour);
  }

  /** The hand of the ghost is seen better than its arm. */
  private emphasizeHand(): void {
    let part: Object3D | undefined = this.ghost.links[this.tip];
    while (part?.parent && !isTurning(part.parent)) part = part.parent;
    part?.traverse((one) => {
      const { material } = one as { material?: unknown };
      if (material instanceof MeshLambertMaterial) material.opacity = HAND_OPACITY;
    });
  }

  /** Let the arm itself be seen through: 1 is solid. */
  seeThrough(opacity: number): void {
    this.arm.traverse((part) => {
      const { material } = part as { material?: Material };
      if (!material) return;
      material.transparent = opacity < 1;
      material.opacity = opacity;
      material.depthWrite = opacity === 1;
      material.needsUpdate = true;
    });
    this.ask();
  }

  /** Show where the objects are; `isOld`: whether one's place was last known long ago; `age`: when it was seen, in words. */
  objects(objects: readonly KnownObject[], isOld: (one: KnownObject) => boolean, age: (one: KnownObject) => string): void {
    this.shapes.show(objects, isOld, age);
    this.ask();
  }

  /** Show parts of a figure, half transparent, where they belong. */
  goal(parts: readonly KnownObject[]): void {
    this.shapes.goal(parts);
    this.ask();
  }

  /** Show a place that was chosen (m); null hides it. */
  place(at: readonly [number, number, number] | null): void {
    this.chosen.visible = at !== null;
    if (at) this.chosen.position.set(at[0], at[1], at[2] + 0.001);
    this.ask();
  }

  plate(facts: PlateFacts): void {
    this.world.add(plateOf(facts));
    this.ask();
  }

  /** Put the camera to one of the viewpoints `front`, `side`, `top`. */
  viewpoint(name: string): void {
    const way = VIEWPOINTS[name];
    if (way) this.look(new Vector3(...MIDDLE).add(new Vector3(...way)), new Vector3(...MIDDLE));
  }

  /** Put the camera where that calibrated camera of the robot is, so that all of its picture is in the view. */
  asCamera({ place, at, field_deg }: CameraPlace): void {
    this.look(new Vector3(...place), new Vector3(...at), field_deg);
  }

  /** Let the model be seen through where a camera's picture lies behind it; floor and boxes would only hide that. */
  overPicture(shown: boolean): void {
    this.holder.toggleAttribute("data-picture", shown);
    this.grid.visible = this.forbidden.visible = !shown;
    this.ask();
  }

  /** `wide`: the horizontal field of view (degrees) of a picture that has to fit in; 0 for the usual field. */
  private look(from: Vector3, to: Vector3, wide = 0): void {
    this.world.updateMatrixWorld(true);
    this.camera.position.copy(this.world.localToWorld(from));
    this.controls.target.copy(this.world.localToWorld(to));
    this.onTurned();
    this.wide = wide;
    this.fit();
    this.controls.update();
    this.ask();
  }

  protected override fit(): void {
    const { camera, wide } = this;
    if (!wide) return super.fit();
    camera.fov = verticalField(wide, Math.max(PICTURE, 1 / camera.aspect));
    camera.updateProjectionMatrix();
  }

  override zoom(factor: number): void {
    if (factor === 0) {
      this.controls.target.set(...LOOK.to);
      this.wide = 0;
      this.fit();
    }
    super.zoom(factor);
    this.onTurned();
  }
}

function handlesOf(camera: Camera, canvas: HTMLElement): TransformControls {
  const made = new TransformControls(camera, canvas);
  canvas.style.touchAction = "pan-y"; // it allows none, but the page can be scrolled beside the handles
  return made;
}

function isTurning(part: Object3D): boolean {
  const { isURDFJoint, jointType } = part as Partial<URDFJoint>;
  return isURDFJoint === true && jointType !== "fixed";
}
