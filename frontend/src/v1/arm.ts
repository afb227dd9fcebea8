/** `/static/farhand/v1/arm.js`: widgets for an arm. */
import "../arm/arm.css";

export { Joints } from "../arm/joints.ts";
export { Prediction } from "../arm/prediction.ts";
export { Position } from "../arm/position.ts";
export { type ArmDescription, deg, type Judge, type Target } from "../arm/types.ts";
