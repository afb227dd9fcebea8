/** `/static/farhand/v1/roaming.js`: widgets for a robot that drives about and takes jobs. */
import "../widgets/roaming.css";

export { DrivePad } from "../widgets/drive_pad.ts";
export { type Graph, GraphMap, type Mark, type Spot } from "../widgets/graph_map.ts";
export { JobPanel } from "../widgets/job_panel.ts";
export { landmarks, whereabouts } from "../widgets/plane.ts";
export { SpotList } from "../widgets/spot_list.ts";
export { Stick, type StickBy } from "../widgets/stick.ts";
export type { Push } from "../widgets/stick_rules.ts";
