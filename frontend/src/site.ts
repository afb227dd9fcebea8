/** What every page loads: the look, where the focus goes, and where one stands. */
import "./style.css";
import { follow } from "./arrives.ts";
import "./focus.ts";
import "./turnbar.ts";

follow();
