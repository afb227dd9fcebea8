/** `/static/farhand/v1/text.js`: texts in the reader's language. */
export { decimals, gettext, language, ngettext, translate } from "../kit/text.ts";
