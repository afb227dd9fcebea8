/** Lets Node's tests import the published modules at the address at which robots' consoles do. */
import { registerHooks } from "node:module";

registerHooks({
  resolve: (name, context, next) => {
    const found = /^\/static\/farhand\/v1\/(\w+)\.js$/.exec(name);
    return next(found ? new URL(`../src/v1/${found[1]}.ts`, import.meta.url).href : name, context);
  },
});
