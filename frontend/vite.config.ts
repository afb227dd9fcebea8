import { globSync } from "node:fs";
import { defineConfig, type Plugin } from "vite";

const BASE = "/static/app/";
/** A robot's folder brings its console: nothing here knows which robots there are. */
const consoles = globSync("../robots/drivers/*/console/console.ts", { cwd: import.meta.dirname });

/** The console module and those beside it. Every console imports them by their addresses. */
const modules = globSync("src/v1/*.ts", { cwd: import.meta.dirname });

/** For consoles of other packages each address stays: a file there leads on to the one that was built, another to its style. */
const published: Plugin = {
  name: "published",
  generateBundle(_, bundle) {
    for (const source of modules) {
      const made = Object.values(bundle).find((one) => one.type === "chunk" && one.isEntry && one.facadeModuleId?.endsWith(source));
      if (made?.type !== "chunk") throw new Error(`${source} was not built`);
      const address = source.replace("src", "farhand").replace(".ts", ""), styles = [...(made.viteMetadata?.importedCss ?? [])];
      this.emitFile({ type: "asset", fileName: `${address}.js`, source: `export * from "${BASE}${made.fileName}";\n` });
      if (styles.length)
        this.emitFile({ type: "asset", fileName: `${address}.css`, source: styles.map((file) => `@import "${BASE}${file}";\n`).join("") });
    }
  },
};

export default defineConfig({
  base: BASE,
  plugins: [published],
  resolve: { alias: [{ find: /^\/static\/farhand\/(v1\/\w+)\.js$/, replacement: `${import.meta.dirname}/src/$1.ts` }] },
  build: {
    outDir: "dist",
    manifest: true,
    cssCodeSplit: true,
    rollupOptions: {
      preserveEntrySignatures: "exports-only",
      input: [
        "src/site.ts", "src/plain.ts", "src/landing.ts", "src/admin.ts", "src/turn.ts", "src/pause.ts", "src/replay/page.ts",
        ...modules, ...consoles,
      ],
    },
  },
});
