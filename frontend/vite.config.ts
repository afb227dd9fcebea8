import { globSync } from "node:fs";
import { defineConfig } from "vite";

/** A robot's folder brings its console: nothing here knows which robots there are. */
const consoles = globSync("../robots/drivers/*/console/console.ts", { cwd: import.meta.dirname });

export default defineConfig({
  base: "/static/app/",
  build: {
    outDir: "dist",
    manifest: true,
    cssCodeSplit: true,
    rollupOptions: {
      input: ["src/site.ts", "src/plain.ts", "src/landing.ts", "src/admin.ts", "src/turn.ts", "src/pause.ts", ...consoles],
    },
  },
});
