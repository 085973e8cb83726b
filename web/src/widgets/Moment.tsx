import { useTranslation } from "react-i18next";

const DAY = 86_400_000; // ms

/** A moment as people say it: the time, and the day where that was another one. */
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

/** The language as it is written where the reader lives, if the browser knows: it sets how times and days are written. */
function regional(language: string): string {
  const known = navigator.languages.find((one) => one.startsWith(`${language}-`));
  return known ?? (language === "en" ? "en-GB" : language);
}
