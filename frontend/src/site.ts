/** What every page loads: the look. */
import "./style.css";
