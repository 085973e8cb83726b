/** The REST API, typed by its own description; nothing else of this code speaks HTTP. */

import createClient from "openapi-fetch";
import type { components, paths } from "./schema";

/** The schemas of the API by name: `Schema<"Job">`. */
export type Schema<Name extends keyof components["schemas"]> = components["schemas"][Name];

/** Where the pages were loaded from, without the slash at its end: the API is beside them, also behind a proxy. */
export const BASE = new URL(".", document.baseURI).href.replace(/\/$/, "");

export const api = createClient<paths>({
  baseUrl: BASE,
  // Looked up at each request, so that a later replacement counts.
  fetch: (request) => globalThis.fetch(request),
});

/** What the server says when it refuses something (RFC 9457); its text says what would be right. */
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

/** Whether what was asked for is not there (any more). */
export function isGone(error: unknown): boolean {
  return error instanceof ApiProblem && error.status === 404;
}

interface Answered<Data> {
  data?: Data;
  error?: unknown;
  response: Response;
}

/** Returns what a call answers, or throws the problem that it answers. */
export async function answer<Data>(call: Promise<Answered<Data>>): Promise<NonNullable<Data>> {
  return (await answerWithTag(call)).data;
}

/** The same with the ETag, which writes have to say in `If-Match`. */
export async function answerWithTag<Data>(
  call: Promise<Answered<Data>>,
): Promise<{ data: NonNullable<Data>; tag: string }> {
  const { data, error, response } = await call;
  if (!response.ok) throw new ApiProblem(response.status, isProblem(error) ? error : undefined);
  return { data: data as NonNullable<Data>, tag: response.headers.get("ETag") ?? "" };
}

function isProblem(error: unknown): error is Schema<"ProblemDetails"> {
  return typeof error === "object" && error !== null && "title" in error;
}
