import { answer, api } from "../api/client";
import { notifyProblem } from "../widgets/problems";

/** Logs out; deletes all data and unfinished forms, so that nothing is left for the next user. */
export async function logout(): Promise<void> {
  try {
    await answer(api.DELETE("/api/v1/session"));
    sessionStorage.clear();
    location.reload();
  } catch (error) {
    notifyProblem(error);
  }
}
