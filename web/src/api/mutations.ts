/** Writes: one at a time from one place, however often its button is pressed. */

import {
  type DefaultError,
  type MutateOptions,
  useMutation,
  type UseMutationOptions,
  type UseMutationResult,
} from "@tanstack/react-query";
import { useEffect, useRef } from "react";

/**
 * A mutation that is not begun again while it runs: a double click means one thing, not two.
 *
 * A disabled button is not enough: on a busy machine the second click comes before the page was drawn again.
 */
export function useSingleMutation<Data = unknown, Failure = DefaultError, Input = void, Context = unknown>(
  options: UseMutationOptions<Data, Failure, Input, Context>,
): UseMutationResult<Data, Failure, Input, Context> {
  const mutation = useMutation(options);
  const busy = useRef(false);
  const { status, submittedAt } = mutation;
  // Not when it ends, but when that is drawn: until then its dialog may still be there to be clicked at.
  useEffect(() => {
    if (status !== "pending") busy.current = false;
  }, [status, submittedAt]);
  const mutate = (input: Input, then?: MutateOptions<Data, Failure, Input, Context>) => {
    if (busy.current) return;
    busy.current = true;
    mutation.mutate(input, then);
  };
  return { ...mutation, mutate: mutate as typeof mutation.mutate };
}
