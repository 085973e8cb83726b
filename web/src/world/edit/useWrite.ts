import { useQueryClient } from "@tanstack/react-query";
import { useSingleMutation } from "../../api/mutations";
import { notifyProblem } from "../../widgets/problems";

/** Writes to the world, invalidates its queries, and shows refusals. */
export function useWrite<Input = void, Output = unknown>(
  write: (input: Input) => Promise<Output>,
  then?: (output: Output) => void,
) {
  const client = useQueryClient();
  return useSingleMutation({
    mutationFn: write,
    onSuccess: (output) => {
      then?.(output);
      // After rendering: removed elements are no longer shown, and not fetched again.
      setTimeout(() => {
        for (const word of ["world", "scenes"]) void client.invalidateQueries({ queryKey: [word] });
      });
    },
    onError: notifyProblem,
  });
}
