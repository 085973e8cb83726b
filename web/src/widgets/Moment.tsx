import { useTranslation } from "react-i18next";

const DAY = 86_400_000; // ms

/** A point in time: the time of day, and the date if it is not today. */
export function Moment({ at }: { at: string | number | null | undefined }) {
  const { i18n } = useTranslation();
  if (at === null || at === undefined) return null;
  const moment = new Date(at);
  return <time dateTime={moment.toISOString()}>{momentText(moment, i18n.language)}</time>;
}

export function momentText(moment: Date, language: string, now = Date.now()): string {
  const near = Math.abs(now - moment.getTime()) < DAY / 2;
  return moment.toLocaleString(
    regional(language),
    near ? { timeStyle: "medium" } : { dateStyle: "medium", timeStyle: "short" },
  );
}

/** The language with the browser's region, if known: it determines the format of times and dates. */
function regional(language: string): string {
  const known = navigator.languages.find((one) => one.startsWith(`${language}-`));
  return known ?? (language === "en" ? "en-GB" : language);
}
