/** `/static/farhand/v1/arm.js`: widgets for an arm, and its whole console. */
import "../arm/arm.css";
import "../widgets/programs.css"; // of its task mode

export { ArmConsole } from "../scene/arm_console.ts";
export { Joints } from "../arm/joints.ts";
export { Prediction } from "../arm/prediction.ts";
export { Position } from "../arm/position.ts";
export { type ArmDescription, type ArmMode, type ArmParts, deg, type Judge, type Target } from "../arm/types.ts";
