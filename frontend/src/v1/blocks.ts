/** `/static/farhand/v1/blocks.js`: programs as blocks. It is large: load it by `import()`. */
export { TaskBlocks } from "../widgets/task_desk.ts";
export { Blockly, type BlockState, choiceField, defineStep, numberField, StepWorkspace, workspace } from "../widgets/blockly.ts";
