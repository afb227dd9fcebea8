/**
 * `/static/farhand/v1/console.js`: the module for a robot's own console (docs/reference/console-module.md).
 *
 * Names are only added here and in the modules beside it, and their meaning does not change; a changed meaning needs a
 * new version. It loads no style; the heavy parts are modules of their own.
 */
export { CameraView } from "../camera.ts";
export type { Console } from "../console_parts.ts";
export { blocked, type Facts } from "../controls.ts";
export { stick } from "../gamepad.ts";
export { Jog, named } from "../jog.ts";
export { facts } from "../facts.ts";
export { type Box, objectsAfter, type Placed } from "../objects.ts";
export { RobotPage } from "../page.ts";
export { allow, fill, refusal, say } from "../parts.ts";
export { fromOwn } from "../posture.ts";
export type { CommandInfo, Judgement, PicturePacket, PlanAnswer, StatePacket, Still, StreamPacket } from "../protocol.ts";
export { prefetch } from "../prefetch.ts";
export { request } from "../request.ts";
export { byId, set, shape } from "../svg.ts";
export { Tabs } from "../tabs.ts";
export { Basics } from "../widgets/basics.ts";
export { CommandForm } from "../widgets/command_form.ts";
export { HeldButtons } from "../widgets/held_buttons.ts";
export { FINAL } from "../words.ts";
export const version = 1;
