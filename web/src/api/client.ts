/** The REST API, typed from its OpenAPI description; the only module that uses HTTP. */

import createClient from "openapi-fetch";
import i18n from "../i18n";
import { learn } from "../i18n/sentences";
import type { components, paths } from "./schema";

/** The schemas of the API by name: `Schema<"Job">`. */
export type Schema<Name extends keyof components["schemas"]> = components["schemas"][Name];

/** The address of the pages without its last slash: the API is next to them, even behind a proxy. */
export const BASE = new URL(".", document.baseURI).href.replace(/\/$/, "");

export const api = createClient<paths>({
  baseUrl: BASE,
  // Looked up at each request, so that tests can replace it.
  fetch: (request) => globalThis.fetch(request),
});
api.use({ onRequest: ({ request }) => request.headers.set("Accept-Language", i18n.language) });

/** A refusal by the server (RFC 9457); its text says what is wrong and what would be right. */
export class ApiProblem extends Error {
  readonly status: number;
  readonly code: string;
  readonly details: Schema<"ProblemDetails"> | undefined;

  constructor(status: number, details: Schema<"ProblemDetails"> | undefined) {
    super(details?.detail || details?.title || `HTTP ${status}`);
    this.name = "ApiProblem";
    this.status = status;
    this.code = details?.code ?? "";
    this.details = details;
  }
}

/** Whether the requested resource does not exist (any more). */
export function isGone(error: unknown): boolean {
  return error instanceof ApiProblem && error.status === 404;
}

interface Answered<Data> {
  data?: Data;
  error?: unknown;
  response: Response;
}

/** Returns the answer of a call, or throws its problem. */
export async function answer<Data>(call: Promise<Answered<Data>>): Promise<NonNullable<Data>> {
  return (await answerWithTag(call)).data;
}

/** The same with the ETag, which writes must send as `If-Match`. */
export async function answerWithTag<Data>(
  call: Promise<Answered<Data>>,
): Promise<{ data: NonNullable<Data>; tag: string }> {
  const { data, error, response } = await call;
  learn(data ?? error);
  if (!response.ok) throw new ApiProblem(response.status, isProblem(error) ? error : undefined);
  return { data: data as NonNullable<Data>, tag: response.headers.get("ETag") ?? "" };
}

function isProblem(error: unknown): error is Schema<"ProblemDetails"> {
  return typeof error === "object" && error !== null && "title" in error;
}
