/**
 * `/static/farhand/v1/console.js`: the module for a robot's own console (docs/reference/console-module.md).
 *
 * Names are only added here, and their meaning does not change; a changed meaning needs a new version.
 */
export { CameraView } from "../camera.ts";
export { blocked } from "../controls.ts";
export { Jog, named } from "../jog.ts";
export { facts } from "../facts.ts";
export { objectsAfter } from "../objects.ts";
export { RobotPage } from "../page.ts";
export { allow, refusal, say } from "../parts.ts";
export { fromOwn } from "../posture.ts";
export { shape } from "../svg.ts";
export { Tabs } from "../tabs.ts";
export { CommandForm } from "../widgets/command_form.ts";
export { HeldButtons } from "../widgets/held_buttons.ts";
export const version = 1;
