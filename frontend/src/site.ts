/** What every page loads: the look, and where one stands. */
import "./style.css";
import "./turnbar.ts";
