/** The fetched branches of the tree: fetched again only if a change affects them. */

import { create } from "zustand";
import { answer, api, type Schema, isGone } from "../../api/client";
import { type EventInfo, onEvent, onReset } from "../../live/events";
import { useSelection } from "../../selection/selection";
import { byName } from "../../widgets/names";
import { notifyProblem } from "../../widgets/problems";
import { readElement } from "../queries";
import { type Edit, concerned, removed } from "./concerned";
import { TOP } from "./top";

export type Node = Schema<"TreeNode">;

export type Branches = Readonly<Record<string, readonly Node[]>>;

interface State {
  /** The children of each fetched node. */
  branches: Branches;
  /** The expanded nodes. */
  open: string[];
  /** Whether anything was fetched yet. */
  ready: boolean;
}

export const useBranches = create<State>(() => ({ branches: {}, open: [], ready: false }));

const PAGE = 500;
const DEEPEST = 20;

async function readNode(root: string, depth: number, cursor?: string): Promise<Node> {
  return inOrder(await answer(api.GET("/api/v1/tree", { params: { query: { root, depth, limit: PAGE, cursor } } })));
}

function inOrder(node: Node): Node {
  return { ...node, children: node.children.map(inOrder).sort((one, other) => byName(one.id, other.id)) };
}

/** Fetches as much of the tree as fits into one answer; the rest is fetched when expanded. */
export async function readTree(): Promise<void> {
  const top = await readNode(TOP, DEEPEST);
  const branches: Record<string, readonly Node[]> = {};
  const known = new Set<string>();
  const take = (node: Node) => {
    known.add(node.id);
    if (node.next === null && node.children.length === node.children_total) branches[node.id] = node.children;
    node.children.forEach(take);
  };
  take(top);
  const { open, ready, branches: before } = useBranches.getState();
  const first = top.children.flatMap(({ id, children }) => [id, ...children.map((child) => child.id)]);
  const still = ready ? open.filter((id) => known.has(id)) : first;
  const missing = [TOP, ...still].filter((id) => branches[id] === undefined);
  // Long branches are kept until they are fetched again, or the view would jump.
  for (const id of missing) if (before[id] !== undefined) branches[id] = before[id];
  useBranches.setState({ branches, open: still, ready: true });
  await Promise.all(missing.map(readBranch));
}

/** Fetches the children of a node, page by page. */
export async function readBranch(id: string): Promise<void> {
  const children: Node[] = [];
  let cursor: string | undefined;
  do {
    const page = await readNode(id, 1, cursor);
    children.push(...page.children);
    cursor = page.next ?? undefined;
  } while (cursor !== undefined);
  children.sort((one, other) => byName(one.id, other.id));
  useBranches.setState(({ branches }) => ({ branches: { ...branches, [id]: children } }));
}

/** Expands exactly these nodes. */
export function setOpen(open: string[]): void {
  useBranches.setState({ open });
  const { branches } = useBranches.getState();
  for (const id of open) if (branches[id] === undefined) readBranch(id).catch(notifyProblem);
}

/** Expands all ancestors of an element. */
export async function reveal(id: string): Promise<void> {
  const above = await pathTo(id);
  const { branches, open } = useBranches.getState();
  await Promise.all([TOP, ...above].filter((one) => branches[one] === undefined).map(readBranch));
  const closed = above.filter((one) => !open.includes(one));
  if (closed.length > 0) setOpen([...open, ...closed]);
}

async function pathTo(id: string): Promise<string[]> {
  const parents = parentsOf(useBranches.getState().branches);
  const above: string[] = [];
  for (let at = id; ;) {
    const parent = parents.get(at) ?? (await askParent(at));
    if (parent === TOP || above.includes(parent)) return above;
    above.push(parent);
    at = parent;
  }
}

async function askParent(id: string): Promise<string> {
  const { data } = await readElement(id);
  return data.owner ?? data.placement?.place ?? TOP;
}

/** Returns the parent of each node. */
export function parentsOf(branches: Branches): Map<string, string> {
  const parents = new Map<string, string>();
  for (const [parent, children] of Object.entries(branches)) {
    for (const { id } of children) if (!parents.has(id)) parents.set(id, parent);
  }
  return parents;
}

/** Keeps the tree up to date; returns the function that stops it. */
export function followTree(): () => void {
  const readAll = () => void readTree().catch(notifyProblem);
  readAll();
  const endings = [onEvent(take), onReset(readAll)];
  return () => endings.forEach((end) => end());
}

function take({ kind, type, data }: EventInfo): void {
  if (kind === "system" && type === "opened") void readTree().catch(notifyProblem);
  if (kind !== "world") return;
  const edits = (data["edits"] ?? []) as readonly Edit[];
  const gone = removed(edits);
  if (gone.size > 0) forget(gone);
  if (data["all_edits"] !== undefined) void readTree().catch(notifyProblem);
  else readAgain(concerned(edits, parentsOf(useBranches.getState().branches)), gone);
}

function forget(gone: ReadonlySet<string>): void {
  const { hovered } = useSelection.getState(); // the selection is kept: its details show who removed the element
  if (hovered !== null && gone.has(hovered)) useSelection.setState({ hovered: null });
  useBranches.setState(({ branches, open }) => ({
    branches: Object.fromEntries(Object.entries(branches).filter(([id]) => !gone.has(id))),
    open: open.filter((id) => !gone.has(id)),
  }));
}

const waiting = new Set<string>();
let timer: ReturnType<typeof setTimeout> | undefined;
const PAUSE = 60; // ms: a job makes several changes in a row

function readAgain(ids: Iterable<string>, gone: ReadonlySet<string>): void {
  for (const id of ids) if (!gone.has(id)) waiting.add(id);
  gone.forEach((id) => waiting.delete(id));
  timer ??= setTimeout(() => {
    timer = undefined;
    const { branches } = useBranches.getState();
    const now = [...waiting].filter((id) => branches[id] !== undefined);
    waiting.clear();
    now.forEach((id) => void readBranch(id).catch((error: unknown) => isGone(error) || notifyProblem(error)));
  }, PAUSE);
}
