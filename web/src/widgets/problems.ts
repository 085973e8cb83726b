import { notifications } from "@mantine/notifications";
import { ApiProblem } from "../api/client";
import i18n from "../i18n";

/** What a failed request says, in words for people. */
export function problemText(error: unknown): string {
  if (error instanceof ApiProblem) return error.status === 401 ? i18n.t("loginEnded") : withoutKnown(error);
  if (error instanceof TypeError) return i18n.t("unreachable"); // fetch could not reach anybody
  return error instanceof Error ? error.message : String(error);
}

const UNKNOWN = new Set(["NotFound", "UnknownName"]);

/** Lists of known names help programmers, and hide the problem from everybody else. */
function withoutKnown({ message, code }: ApiProblem): string {
  return UNKNOWN.has(code) ? message.replace(/ Known: [^\n]*$/m, "") : message;
}

const UNREACHED = new Set([502, 504]); // a proxy that reaches no server

/** Whether there was no answer: then it is unknown whether it was done, which is no refusal. */
export function isUnanswered(error: unknown): boolean {
  return error instanceof ApiProblem ? UNREACHED.has(error.status) : error instanceof TypeError;
}

/**
 * What stands above the text of a problem.
 *
 * @param refused - What it is where the server refused.
 */
export function problemTitle(error: unknown, refused: string = i18n.t("problem.title")): string {
  return isUnanswered(error) ? i18n.t("problem.unanswered") : refused;
}

/** Shows a refusal, or that there was no answer, until it is closed. */
export function notifyProblem(error: unknown): void {
  notifications.show({ color: "red", title: problemTitle(error), message: problemText(error), autoClose: 10_000 });
}
