import { globSync } from "node:fs";
import { defineConfig, type Plugin } from "vite";

const BASE = "/static/app/";
const WORKER = "src/push/worker.ts";
/** A robot's folder brings its console: nothing here knows which robots there are. */
const consoles = globSync("../robots/kit/drivers/*/console/console.ts", { cwd: import.meta.dirname });
/** The console module and those beside it. As entries they are copies, so that no console of ours loads all that they export. */
const modules = globSync("src/v1/*.ts", { cwd: import.meta.dirname }).map((source) => `${source}?published`);

/** Consoles of other packages import from addresses that stay: a file there leads on to what was built, one beside it to its style. */
const published: Plugin = {
  name: "published",
  generateBundle(_, bundle) {
    const styles = (file: string): string[] => {
      const chunk = bundle[file];
      return chunk?.type === "chunk" ? [...chunk.imports.flatMap(styles), ...(chunk.viteMetadata?.importedCss ?? [])] : [];
    };
    for (const source of modules) {
      const made = Object.values(bundle).find((one) => one.type === "chunk" && one.isEntry && one.facadeModuleId?.endsWith(source));
      if (!made) throw new Error(`${source} was not built`);
      const address = source.replace("src/", "farhand/").replace(".ts?published", "");
      const rules = [...new Set(styles(made.fileName))].map((file) => `@import "${BASE}${file}";\n`).join("");
      this.emitFile({ type: "asset", fileName: `${address}.js`, source: `export * from "${BASE}${made.fileName}";\n` });
      if (rules) this.emitFile({ type: "asset", fileName: `${address}.css`, source: rules });
    }
  },
};

export default defineConfig({
  base: BASE,
  plugins: [published],
  // our own consoles import the module from that address, too, as tsconfig.json says it
  resolve: { alias: [{ find: /^\/static\/farhand\/(v1\/\w+)\.js$/, replacement: `${import.meta.dirname}/src/$1.ts` }] },
  build: {
    outDir: "dist",
    manifest: true,
    cssCodeSplit: true,
    rollupOptions: {
      preserveEntrySignatures: "exports-only",
      treeshake: { moduleSideEffects: [{ test: /v1.console\.ts$/, sideEffects: false }] }, // it only says what others export
      input: [
        "src/page/site.ts",
        "src/page/landing.ts",
        "src/page/embed.ts",
        "src/page/turn_form.ts",
        "src/page/turn_steps.ts",
        "src/page/retry_pause.ts",
        "src/page/send_form.ts",
        "src/page/password.ts",
        "src/page/orientation.ts",
        "src/widgets/plain_console.ts",
        "src/replay/page.ts",
        "src/admin/robot_form.ts",
        "src/admin/first_page.ts",
        "src/admin/review.ts",
        WORKER,
        "src/admin/labels.ts",
        ...modules,
        ...consoles,
      ],
      // the portal serves the service worker from its root, under one name
      output: { entryFileNames: ({ facadeModuleId }) => (facadeModuleId?.endsWith(WORKER) ? "push-worker.js" : "assets/[name]-[hash].js") },
    },
  },
});
