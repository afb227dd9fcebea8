/**
 * `/static/farhand/v1/console.js`: the module for a robot's own console (docs/reference/console-module.md).
 *
 * Names are only added here and in the modules beside it, and their meaning does not change; a changed meaning needs a
 * new version. It loads no style; the heavy parts are modules of their own.
 */
export { CameraView } from "../media/camera_view.ts";
export { Basics, type Console } from "../page/console.ts";
export { blocked, type Facts } from "../page/controls.ts";
export { stick } from "../widgets/gamepad.ts";
export { Jog, named } from "../widgets/jog.ts";
export { facts } from "../page/facts.ts";
export { type Box, objectsAfter, type Placed } from "../socket/objects.ts";
export { RobotPage } from "../page/robot_page.ts";
export { byId, make, say, set, shape } from "../kit/dom.ts";
export { allow, refusal } from "../kit/refusal.ts";
export { fill } from "../kit/render.ts";
export { fromOwn } from "../socket/poses.ts";
export type { CommandInfo, Judgement, PlanAnswer, Still } from "../socket/messages.ts";
export type { PathPacket, PicturePacket, StatePacket, StreamPacket } from "../socket/packets.ts";
export { prefetch } from "../kit/prefetch.ts";
export { request } from "../kit/request.ts";
export { Tabs } from "../kit/tabs.ts";
export { CommandForm } from "../widgets/command_form.ts";
export { DugMap } from "../widgets/dug_map.ts";
export { GoBack } from "../widgets/go_back.ts";
export { PlaceForm, RecentPlaces } from "../widgets/places.ts";
export { HeldButtons } from "../widgets/held_buttons.ts";
export { FINAL } from "../socket/stages.ts";
export const version = 1;
