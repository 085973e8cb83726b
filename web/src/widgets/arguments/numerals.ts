/** Parsing of typed numbers. */

const NUMERAL = /^[+-]?(\d+([.,]\d*)?|[.,]\d+)(e[+-]?\d+)?$/i;
/** Text that may still become a number: a sign, a separator, an exponent without digits. */
const BEGINNING = /^[+-]?(\d*[.,]?\d*)(e[+-]?)?$/i;

/**
 * Parses a number with a decimal point or comma; undefined if empty, NaN if it is not a number.
 *
 * All of the text counts: ignoring an unknown sign would yield another number.
 */
export function numberIn(text: string, whole = false): number | undefined {
  const written = text.trim().replace("−", "-");
  if (written === "") return undefined;
  const number = NUMERAL.test(written) ? Number(written.replace(",", ".")) : Number.NaN;
  return Number.isFinite(number) && (!whole || Number.isInteger(number)) ? number : Number.NaN;
}

/** Whether the text is not a number, and cannot become one by further typing. */
export function isNoNumber(text: string, whole = false): boolean {
  return Number.isNaN(numberIn(text, whole)) && !BEGINNING.test(text.trim().replace("−", "-"));
}

/** The next number up or down, within limits, without binary rounding noise. */
export function stepped(from: number | undefined, step: number, { min = -Infinity, max = Infinity } = {}): number {
  const begun = from === undefined || Number.isNaN(from) ? 0 : from;
  return Math.min(max, Math.max(min, Number((begun + step).toFixed(9))));
}
