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

/** The names that there are instead help whoever writes a program, and hide what is wrong from everybody else. */
function withoutKnown({ message, code }: ApiProblem): string {
  return UNKNOWN.has(code) ? message.replace(/ Known: [^\n]*$/m, "") : message;
}

const UNREACHED = new Set([502, 504]); // a proxy that reaches no server

/** Whether nobody answered: then nobody knows whether it was done, which is no refusal. */
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

/** Shows what was refused, or what nobody answered, until somebody has read it. */
export function notifyProblem(error: unknown): void {
  notifications.show({ color: "red", title: problemTitle(error), message: problemText(error), autoClose: 10_000 });
}
