import { useQueryClient } from "@tanstack/react-query";
import { useSingleMutation } from "../../api/mutations";
import { notifyProblem } from "../../widgets/problems";

/** Writes to the world; what was read of it is old then, and a refusal is shown. */
export function useWrite<Input = void, Output = unknown>(
  write: (input: Input) => Promise<Output>,
  then?: (output: Output) => void,
) {
  const client = useQueryClient();
  return useSingleMutation({
    mutationFn: write,
    onSuccess: (output) => {
      then?.(output);
      // After the page was drawn again: what is gone and no longer shown is not read.
      setTimeout(() => {
        for (const word of ["world", "scenes"]) void client.invalidateQueries({ queryKey: [word] });
      });
    },
    onError: notifyProblem,
  });
}
