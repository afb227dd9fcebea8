/** What every page loads: the styles, the care for the focus, and the turn bar. */
import "../style/index.css";
import { pollPendingParts } from "./pending_parts.ts";
import "./focus.ts";
import "./site_menu.ts";
import { tellZone } from "./zone.ts";
import "../queue/turn_bar.ts";

tellZone();
pollPendingParts();
