/** What every page loads: the look, where the focus goes, and where one stands. */
import "./style.css";
import "./focus.ts";
import "./turnbar.ts";
