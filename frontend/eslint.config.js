// Consoles stand in the folders of their robots, so it is run from the repository's root: see `make check`.
import { defineConfig } from "eslint/config";
import tseslint from "typescript-eslint";

const PAGES = ["frontend/src/**/*.ts", "robots/**/console/**/*.ts"];
const TOOLS = ["frontend/tests/*.ts", "frontend/vite.config.ts"]; // no tsconfig.json has them

const RULES = {
  eqeqeq: "error",
  "@typescript-eslint/no-unused-vars": ["error", { argsIgnorePattern: "^_" }],
  // with `noUncheckedIndexedAccess` it stands where an index is known to be one
  "@typescript-eslint/no-non-null-assertion": "off",
};

export default defineConfig(
  { linterOptions: { reportUnusedDisableDirectives: "error" } },
  {
    files: PAGES,
    extends: [tseslint.configs.strictTypeChecked],
    languageOptions: { parserOptions: { project: "frontend/tsconfig.json", tsconfigRootDir: `${import.meta.dirname}/..` } },
    rules: {
      ...RULES,
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true, allowBoolean: true }],
      "@typescript-eslint/no-confusing-void-expression": ["error", { ignoreArrowShorthand: true, ignoreVoidReturningFunctions: true }],
      // consoles spread the members of a held motion, which are the object's own; a text is spread into code points
      "@typescript-eslint/no-misused-spread": ["error", { allow: ["string", { from: "file", name: "HeldMotion" }] }],
    },
  },
  {
    files: TOOLS,
    extends: [tseslint.configs.strict],
    rules: { ...RULES, "@typescript-eslint/no-extraneous-class": "off" }, // a browser's class with as much as a test needs
  },
);
