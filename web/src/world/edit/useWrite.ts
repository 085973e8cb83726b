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
      for (const word of ["world", "scenes"]) void client.invalidateQueries({ queryKey: [word] });
      then?.(output);
    },
    onError: notifyProblem,
  });
}
