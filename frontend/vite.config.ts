import { defineConfig } from "vite";

export default defineConfig({
  base: "/static/app/",
  build: {
    outDir: "dist",
    manifest: true,
    cssCodeSplit: true,
    rollupOptions: {
      input: ["src/site.ts", "src/consoles/sand.ts", "src/consoles/arm.ts", "src/consoles/plain.ts", "src/landing.ts", "src/admin.ts", "src/turn.ts", "src/pause.ts"],
    },
  },
});
