/** `/static/farhand/v1/floor_view.js`: a floor in three dimensions. It is large: load it by `import()`. */
export { type Floor, FloorView, type Standing } from "../widgets/floor_view.ts";
