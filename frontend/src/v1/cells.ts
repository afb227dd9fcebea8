/** `/static/farhand/v1/cells.js`: a grid of cells in three dimensions. It is large: load it by `import()`. */
export { CellGrid } from "../widgets/cell_grid.ts";
