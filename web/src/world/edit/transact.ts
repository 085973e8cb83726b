import { answer, api, type Schema } from "../../api/client";
import type { Details } from "../queries";

type Operation = Schema<"TransactionOrder">["operations"][number];

/** Writes to an element if it is unchanged since it was displayed. */
export function transact(seen: Details, reason: string, operation: Operation): Promise<Schema<"Written">> {
  const expects = { [seen.id]: seen.version };
  return answer(api.POST("/api/v1/world/transactions", { body: { reason, expects, operations: [operation] } }));
}
