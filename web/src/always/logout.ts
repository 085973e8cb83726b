import { answer, api } from "../api/client";
import { notifyProblem } from "../widgets/problems";

/** Ends the login; nothing that was read or half filled in stays for the next user. */
export async function logout(): Promise<void> {
  try {
    await answer(api.DELETE("/api/v1/session"));
    sessionStorage.clear();
    location.reload();
  } catch (error) {
    notifyProblem(error);
  }
}
