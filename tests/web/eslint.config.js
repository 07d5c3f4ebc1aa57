// Run from the project's root, which is then the base of the patterns: .ci/lint web.
import { fileURLToPath } from "node:url";
import js from "@eslint/js";
import globals from "globals";
import ts from "typescript-eslint";

const typed = ["server/web/page/**/*.ts", "tests/web/unit/**/*.ts"];
const unused = ["error", { argsIgnorePattern: "^_", caughtErrors: "none" }];

export default ts.config(
  { linterOptions: { reportUnusedDisableDirectives: "error" } },
  {
    files: typed,
    extends: [js.configs.recommended, ...ts.configs.recommendedTypeChecked],
    languageOptions: { parserOptions: { project: ["tests/web/tsconfig.json"], tsconfigRootDir: fileURLToPath(new URL("../..", import.meta.url)) } },
    rules: {
      eqeqeq: "error",
      "@typescript-eslint/consistent-type-imports": "error",
      "@typescript-eslint/no-unnecessary-condition": ["error", { allowConstantLoopConditions: true }],
      "@typescript-eslint/no-unused-vars": unused,
      "@typescript-eslint/switch-exhaustiveness-check": "error",
      // What would make markup or code of strings: the page's policy lets none of it run.
      "no-eval": "error",
      "no-implied-eval": "off", // the typed rule of the same name is on
      "no-restricted-properties": ["error", ...["innerHTML", "outerHTML", "insertAdjacentHTML"].map((property) => ({ property })),
        { object: "document", property: "write" }],
    },
  },
  {
    // node:test awaits its own tests.
    files: ["tests/web/unit/**/*.ts"],
    rules: { "@typescript-eslint/no-floating-promises": ["error", { allowForKnownSafeCalls: [{ from: "package", name: ["test", "describe", "it"], package: "node:test" }] }] },
  },
  {
    files: ["server/web/*.mjs", "tests/web/**/*.mjs", "tests/web/*.js"],
    extends: [js.configs.recommended],
    // What a browser's page is given to run stands in the tests of browser/.
    languageOptions: { globals: { ...globals.node, ...globals.browser } },
    rules: { eqeqeq: "error", "no-unused-vars": unused },
  },
);
