/** Writes: one at a time for each button, however often it is pressed. */

import {
  type DefaultError,
  type MutateOptions,
  useMutation,
  type UseMutationOptions,
  type UseMutationResult,
} from "@tanstack/react-query";
import { useEffect, useRef } from "react";

/**
 * A mutation that cannot be started again while it runs, so that a double click has one effect.
 *
 * A disabled button is not enough: on a busy machine the second click arrives before the page is rendered.
 */
export function useSingleMutation<Data = unknown, Failure = DefaultError, Input = void, Context = unknown>(
  options: UseMutationOptions<Data, Failure, Input, Context>,
): UseMutationResult<Data, Failure, Input, Context> {
  const mutation = useMutation(options);
  const busy = useRef(false);
  const { status, submittedAt } = mutation;
  // Released after rendering, not at its end: until then its dialog may still receive a click.
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
