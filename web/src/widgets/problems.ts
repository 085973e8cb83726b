import { notifications } from "@mantine/notifications";
import { ApiProblem } from "../api/client";
import i18n from "../i18n";
import { said } from "../i18n/sentences";

/** Texts of failed requests for people. */
export function problemText(error: unknown): string {
  if (error instanceof ApiProblem) return error.status === 401 ? i18n.t("loginEnded") : said(error.message);
  if (error instanceof TypeError) return i18n.t("unreachable"); // fetch could not reach the server
  return error instanceof Error ? error.message : String(error);
}

const UNREACHED = new Set([502, 504]); // a proxy that cannot reach its server

/** Whether there was no answer: then the effect is unknown, which is not a refusal. */
export function isUnanswered(error: unknown): boolean {
  return error instanceof ApiProblem ? UNREACHED.has(error.status) : error instanceof TypeError;
}

/**
 * Returns the title of a problem.
 *
 * @param refused - The title for a refusal by the server.
 */
export function problemTitle(error: unknown, refused: string = i18n.t("problem.title")): string {
  return isUnanswered(error) ? i18n.t("problem.unanswered") : refused;
}

/** Shows a refusal, or the lack of an answer, until it is closed. */
export function notifyProblem(error: unknown): void {
  notifications.show({ color: "red", title: problemTitle(error), message: problemText(error), autoClose: 10_000 });
}
