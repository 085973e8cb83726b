import { notifications } from "@mantine/notifications";
import { ApiProblem } from "../api/client";
import i18n from "../i18n";

/** What a failed request says, in words for people. */
export function problemText(error: unknown): string {
  if (error instanceof ApiProblem) return error.message;
  if (error instanceof TypeError) return i18n.t("unreachable"); // fetch could not reach anybody
  return error instanceof Error ? error.message : String(error);
}

/** Shows what was refused, until somebody has read it. */
export function notifyProblem(error: unknown): void {
  notifications.show({ color: "red", title: i18n.t("problem.title"), message: problemText(error), autoClose: 10_000 });
}
