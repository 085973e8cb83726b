/** Numbers as people write them. */

const NUMERAL = /^[+-]?(\d+([.,]\d*)?|[.,]\d+)(e[+-]?\d+)?$/i;
/** What may still become a number: a sign, a separator, an exponent that has no digits yet. */
const BEGINNING = /^[+-]?(\d*[.,]?\d*)(e[+-]?)?$/i;

/**
 * Reads a number, written with a point or a comma; undefined where nothing is written, NaN for what is no number.
 *
 * Nothing is left out of what was written: a number with a sign that is not understood would become another number.
 */
export function numberIn(text: string, whole = false): number | undefined {
  const written = text.trim().replace("−", "-");
  if (written === "") return undefined;
  const number = NUMERAL.test(written) ? Number(written.replace(",", ".")) : Number.NaN;
  return Number.isFinite(number) && (!whole || Number.isInteger(number)) ? number : Number.NaN;
}

/** Whether what is written is no number, and does not become one if it is only gone on with. */
export function isNoNumber(text: string, whole = false): boolean {
  return Number.isNaN(numberIn(text, whole)) && !BEGINNING.test(text.trim().replace("−", "-"));
}

/** The next number upwards or downwards, within limits, without the noise of binary fractions. */
export function stepped(from: number | undefined, step: number, { min = -Infinity, max = Infinity } = {}): number {
  const begun = from === undefined || Number.isNaN(from) ? 0 : from;
  return Math.min(max, Math.max(min, Number((begun + step).toFixed(9))));
}
