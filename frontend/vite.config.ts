import { globSync } from "node:fs";
import { defineConfig, type Plugin } from "vite";

const BASE = "/static/app/";
/** A robot's folder brings its console: nothing here knows which robots there are. */
const consoles = globSync("../robots/drivers/*/console/console.ts", { cwd: import.meta.dirname });

/** Consoles of other packages import from an address that stays: a file there leads on to the one that was built. */
function published(source: string, address: string): Plugin {
  return {
    name: "published",
    generateBundle(_, bundle) {
      const made = Object.values(bundle).find((one) => one.type === "chunk" && one.isEntry && one.facadeModuleId?.endsWith(source));
      if (!made) throw new Error(`${source} was not built`);
      this.emitFile({ type: "asset", fileName: address, source: `export * from "${BASE}${made.fileName}";\n` });
    },
  };
}

export default defineConfig({
  base: BASE,
  plugins: [published("src/v1/console.ts", "farhand/v1/console.js")],
  build: {
    outDir: "dist",
    manifest: true,
    cssCodeSplit: true,
    rollupOptions: {
      preserveEntrySignatures: "exports-only",
      input: [
        "src/site.ts", "src/plain.ts", "src/landing.ts", "src/admin.ts", "src/turn.ts", "src/pause.ts", "src/replay/page.ts", "src/v1/console.ts",
        ...consoles,
      ],
    },
  },
});
