/** `/static/farhand/v1/arm_view.js`: an arm in three dimensions. It is large: load it by `import()`. */
export { ArmView, type ForbiddenBox } from "../arm/view.ts";
