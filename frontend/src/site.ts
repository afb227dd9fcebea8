/** What every page loads: the look, and where one stands. */
import "./style.css";
import { follow } from "./arrives.ts";
import "./turnbar.ts";

follow();
