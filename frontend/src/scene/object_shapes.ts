/** The objects around an arm as shapes with labels: those that are held ride on the tool, and a copy on the ghost's. */
import {
  BoxGeometry,
  type BufferGeometry,
  CanvasTexture,
  Color,
  CylinderGeometry,
  EdgesGeometry,
  Group,
  InstancedMesh,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  Sprite,
  SpriteMaterial,
} from "three";
import { translate } from "../kit/text.ts";
import { disposeContent } from "../kit/view_3d.ts";
import type { KnownObject, PlateFacts } from "./known.ts";
import { matrixOf } from "./matrices.ts";

const PALE = 0.4; // opacity of an object whose place was last known long ago,
const GOAL = 0.35; // of a part of a figure where it belongs
const COPY = 0.5; // and of the copy on the ghost
const PLATE = 0x848e96,
  STUD_M = 0.003; // height of a stud
const LABEL_M = 0.03; // height of a label
const LABEL_PX = 48;

export class ObjectShapes {
  private lying = new Group();
  private carried = new Group();
  private copies = new Group();
  private goals = new Group();

  /** `world`: in the base's frame; `tool`, `ghost`: the tips of the arm and of its ghost. */
  constructor(world: Object3D, tool: Object3D | undefined, ghost: Object3D | undefined) {
    world.add(this.lying, this.goals);
    tool?.add(this.carried);
    ghost?.add(this.copies);
  }

  /** Show these objects; `isOld`: whether one's place was last known long ago; `age`: when it was seen, in words. */
  show(objects: readonly KnownObject[], isOld: (one: KnownObject) => boolean, age: (one: KnownObject) => string = () => ""): void {
    for (const group of [this.lying, this.carried, this.copies]) disposeContent(group);
    for (const one of objects) {
      const shape = placed(one, isOld(one) ? PALE : 1);
      shape.add(labelOf(one, one.held ? "" : age(one)));
      if (!one.held || !one.planned) (one.held ? this.carried : this.lying).add(shape);
      if (one.held) this.copies.add(placed(one, COPY));
    }
  }

  /** Show parts of a figure where they belong. */
  goal(parts: readonly KnownObject[]): void {
    disposeContent(this.goals);
    for (const one of parts) this.goals.add(placed(one, GOAL));
  }
}

/** Return a plate with its studs. */
export function plateOf({ place, studs: [columns, rows], pitch, thick }: PlateFacts): Object3D {
  const made = new Group(),
    material = new MeshLambertMaterial({ color: PLATE }),
    board = new Mesh(new BoxGeometry(columns * pitch, rows * pitch, thick), material),
    studs = new InstancedMesh(new CylinderGeometry(pitch * 0.3, pitch * 0.3, STUD_M, 10).rotateX(Math.PI / 2), material, columns * rows);
  board.position.z = thick / 2;
  for (let n = 0; n < columns * rows; n++) {
    const x = ((n % columns) - (columns - 1) / 2) * pitch,
      y = (Math.floor(n / columns) - (rows - 1) / 2) * pitch;
    studs.setMatrixAt(n, new Matrix4().makeTranslation(x, y, thick + STUD_M / 2));
  }
  made.add(board, studs);
  made.position.set(...place);
  return made;
}

function placed({ facts, pose }: KnownObject, opacity: number): Object3D {
  const geometry = geometryOf(facts),
    color = new Color().setRGB(...facts.colour, "srgb"),
    made = new Mesh(geometry, new MeshLambertMaterial({ color, transparent: opacity < 1, opacity, depthWrite: opacity === 1 }));
  made.add(new LineSegments(new EdgesGeometry(geometry, 30), new LineBasicMaterial({ color: 0x2b2b2b, transparent: true, opacity: 0.5 })));
  made.applyMatrix4(matrixOf(pose));
  return made;
}

function geometryOf({ shape, size: [x, y, z] }: KnownObject["facts"]): BufferGeometry {
  return shape === "box" ? new BoxGeometry(x, y, z) : new CylinderGeometry(x / 2, x / 2, z, 24).rotateX(Math.PI / 2);
}

/** Return the object's name, which stays above it and turns with the view. */
function labelOf({ facts, pose }: KnownObject, age: string): Object3D {
  const text = [translate(facts.name), age].filter(Boolean).join(", ");
  const canvas = document.createElement("canvas"),
    pen = canvas.getContext("2d");
  if (!pen) return new Group();
  const font = `600 ${LABEL_PX * 0.6}px sans-serif`;
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + LABEL_PX / 2;
  canvas.height = LABEL_PX;
  pen.font = font; // a new size has reset it
  pen.fillStyle = "rgb(255 255 255 / 85%)";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.fillStyle = "#1d2426";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(text, canvas.width / 2, LABEL_PX / 2);
  const label = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), depthTest: false, transparent: true }));
  label.scale.set((LABEL_M * canvas.width) / LABEL_PX, LABEL_M, 1);
  const above = facts.size[2] / 2 + LABEL_M; // straight up, however it lies
  label.position.set(pose[8]! * above, pose[9]! * above, pose[10]! * above);
  return label;
}
