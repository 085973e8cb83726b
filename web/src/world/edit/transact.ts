import { answer, api, type Schema } from "../../api/client";
import type { Details } from "../queries";

type Operation = Schema<"TransactionOrder">["operations"][number];

/** Writes something that concerns an element, as long as that is what was seen. */
export function transact(seen: Details, reason: string, operation: Operation): Promise<Schema<"Written">> {
  const expects = { [seen.id]: seen.version };
  return answer(api.POST("/api/v1/world/transactions", { body: { reason, expects, operations: [operation] } }));
}
