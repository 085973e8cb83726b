/** Whether conditions already hold: asked again when they or the world change. */

import { useQueries, useQuery } from "@tanstack/react-query";
import { answer, api, ApiProblem } from "../api/client";
import { keys } from "../api/keys";
import { said } from "../i18n/sentences";
import { problemText } from "../widgets/problems";
import { type CheckedCondition, type GoalOrder, goalOf, type Row, whyAlone } from "./goals";

export interface Verdict {
  state: "incomplete" | "asking" | "holds" | "open" | "wrong";
  /** The deciding reason, or the fault, in the server's words. */
  why: string;
  conditions: readonly CheckedCondition[];
}

const INCOMPLETE: Verdict = { state: "incomplete", why: "", conditions: [] };

function check(order: GoalOrder | null) {
  return {
    queryKey: keys.goals("check", order),
    queryFn: () => answer(api.POST("/api/v1/goals/check", { body: order ?? NOTHING })),
    enabled: order !== null,
  };
}

const NOTHING: GoalOrder = { goal: null, work_master: "", parameters: {}, materials: [] };

interface Asked {
  data?: { holds: boolean; conditions: readonly CheckedCondition[] } | undefined;
  error: unknown;
}

/** Returns the verdict on each row, in order. */
export function useVerdicts(rows: readonly Row[]): Verdict[] {
  const orders = rows.map((row) => {
    const goal = goalOf(row);
    return goal === null ? null : { ...NOTHING, goal };
  });
  const asked = useQueries({ queries: orders.map(check) });
  return asked.map((one, index) => (orders[index] === null ? INCOMPLETE : verdict(one)));
}

/** Returns the verdict on a whole order, such as a filled-in template. */
export function useVerdict(order: GoalOrder | null): Verdict {
  const asked = useQuery(check(order));
  return order === null ? INCOMPLETE : verdict(asked);
}

function verdict({ data, error }: Asked): Verdict {
  if (error && (data === undefined || error instanceof ApiProblem))
    return { state: "wrong", why: problemText(error), conditions: [] };
  if (data === undefined) return { state: "asking", why: "", conditions: [] };
  const why = data.conditions
    .filter(({ holds }) => holds === data.holds)
    .map(({ text, why }) => whyAlone({ text, why: said(why) }));
  return { state: data.holds ? "holds" : "open", why: why.join("; "), conditions: data.conditions };
}
