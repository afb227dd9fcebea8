/** What every page loads: the look, where the focus goes, and where one stands. */
import "../style/index.css";
import { pollPendingParts } from "./pending_parts.ts";
import "./focus.ts";
import "../queue/turn_bar.ts";

pollPendingParts();
