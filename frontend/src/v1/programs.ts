/** `/static/farhand/v1/programs.js`: programs in a robot's own language, as text and as blocks. */
import "../widgets/programs.css";

export { parse as parseTask, print as printTask, type TaskStep } from "../widgets/task_text.ts";
export { minutes, type Language, ProgramDesk, type ProgramUse, type StepBlocks } from "../widgets/program_desk.ts";
