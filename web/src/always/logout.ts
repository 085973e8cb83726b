import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import { notifyProblem } from "../widgets/problems";

/** Ends the login; nothing that was read stays in the page. */
export async function logout(): Promise<void> {
  try {
    await answer(api.DELETE("/api/v1/session"));
    await queryClient.resetQueries({ queryKey: keys.me });
    queryClient.removeQueries({ predicate: ({ queryKey }) => queryKey[0] !== keys.me[0] });
  } catch (error) {
    notifyProblem(error);
  }
}
