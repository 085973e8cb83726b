import "@xyflow/react/dist/style.css";
import dagre from "@dagrejs/dagre";
import { Text } from "@mantine/core";
import { IconFocusCentered } from "@tabler/icons-react";
import {
  ControlButton,
  Controls,
  type Edge,
  Handle,
  type Node,
  type NodeProps,
  Position,
  ReactFlow,
  ReactFlowProvider,
  useReactFlow,
  useStore,
} from "@xyflow/react";
import { useEffect, useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import classes from "./Graph.module.css";
import { type Mood, Status } from "./Status";

export interface GraphNode {
  id: string;
  title: string;
  /** Second line, in smaller type. */
  subtitle?: string;
  /** Its state, shown by icon, colour and text; omitted for nodes without one. */
  state?: { mood: Mood; text: string };
}

export interface GraphEdge {
  from: string;
  to: string;
  /** Label of the edge. */
  label?: string;
}

interface Props {
  label: string;
  nodes: readonly GraphNode[];
  edges: readonly GraphEdge[];
  direction?: "down" | "right";
  chosen?: string | null;
  onChoose?: (id: string) => void;
}

const WIDTH = 190; // px
const HEIGHT = 62; // px
const MARGIN = 16; // px around the graph
/** The zoom below which text of 12 px is smaller than 11 px, and hidden. */
export const READABLE = 11 / 12;

/** A read-only graph: automatic layout, nodes selectable by pointer and keyboard; the wheel scrolls, with Ctrl it zooms. */
export function Graph(props: Props) {
  return (
    <ReactFlowProvider>
      <Drawn {...props} />
    </ReactFlowProvider>
  );
}

type Box = Node<{ node: GraphNode; chosen: boolean; direction: "down" | "right" }, "box">;

const TYPES = { box: BoxNode };
const HIDDEN = { hideAttribution: true };

function Drawn({ label, nodes, edges, direction = "down", chosen = null, onChoose }: Props) {
  const shape = JSON.stringify([nodes.map(({ id }) => id), edges, direction]);
  const places = useMemo(() => layOut(JSON.parse(shape) as Shape), [shape]);
  const boxes = nodes.map((node): Box => {
    const { title, subtitle, state } = node;
    const said = [title, subtitle, state?.text].filter(Boolean).join(", ");
    const position = places.get(node.id) ?? { x: 0, y: 0 };
    const data = { node, chosen: node.id === chosen, direction };
    return { id: node.id, type: "box", position, data, width: WIDTH, height: HEIGHT, ariaLabel: said };
  });
  const lines = edges.map(({ from, to, label: text }): Edge => ({
    ...(text === undefined ? {} : { label: text }),
    id: `${from} ${to}`,
    source: from,
    target: to,
    focusable: false,
  }));
  const bounds = boundsOf(places);
  const { far, leave, follow } = useFollowing(bounds, places, concerned(nodes, chosen));
  const { t } = useTranslation();
  return (
    <section aria-label={label} className={classes.graph} data-far={far || undefined}>
      <ReactFlow
        nodes={boxes}
        edges={lines}
        nodeTypes={TYPES}
        nodesDraggable={false}
        nodesConnectable={false}
        edgesFocusable={false}
        nodesFocusable={onChoose !== undefined}
        elementsSelectable={onChoose !== undefined}
        deleteKeyCode={null}
        minZoom={0.1}
        maxZoom={1.5}
        panOnScroll
        translateExtent={[
          [bounds.x - MARGIN, bounds.y - MARGIN],
          [bounds.x + bounds.width + MARGIN, bounds.y + bounds.height + MARGIN],
        ]}
        proOptions={HIDDEN}
        onMoveStart={(event) => {
          if (event !== null) leave();
        }}
        onNodeClick={(_, { id }) => onChoose?.(id)}
        onNodesChange={(changes) => {
          for (const change of changes) if (change.type === "select" && change.selected) onChoose?.(change.id);
        }}
      >
        <Controls showInteractive={false} onZoomIn={leave} onZoomOut={leave} onFitView={leave}>
          <ControlButton onClick={follow} title={t("graph.follow")} aria-label={t("graph.follow")}>
            <IconFocusCentered aria-hidden style={{ fill: "none" }} />
          </ControlButton>
        </Controls>
      </ReactFlow>
    </section>
  );
}

/** The nodes to look at: those that run, otherwise the chosen one, otherwise the last one that ran; below the first. */
export function concerned([root, ...nodes]: readonly GraphNode[], chosen: string | null): string[] {
  const running = nodes.filter(({ state }) => state?.mood === "running").map(({ id }) => id);
  if (running.length > 0) return running;
  const last = nodes.findLast(({ state }) => state !== undefined && state.mood !== "waiting");
  return [chosen ?? last?.id ?? root?.id ?? ""];
}

/** Shows some nodes in readable size, until the user moves the view. */
function useFollowing(bounds: Rectangle, places: ReadonlyMap<string, Point>, shown: readonly string[]) {
  const { setViewport } = useReactFlow();
  const width = useStore((store) => store.width);
  const height = useStore((store) => store.height);
  const far = useStore(({ transform }) => transform[2] < READABLE);
  const [follows, setFollows] = useState(true);
  const centre = centreOf(shown.flatMap((id) => places.get(id) ?? []));
  const wanted = JSON.stringify(viewOf(bounds, { width, height }, centre));
  useEffect(() => {
    if (follows && width > 0) void setViewport(JSON.parse(wanted) as ReturnType<typeof viewOf>);
  }, [follows, width, wanted, setViewport]);
  return { far, leave: () => setFollows(false), follow: () => setFollows(true) };
}

interface Point {
  x: number;
  y: number;
}

interface Rectangle extends Point {
  width: number;
  height: number;
}

function boundsOf(places: ReadonlyMap<string, Point>): Rectangle {
  const [xs, ys] = [[...places.values()].map(({ x }) => x), [...places.values()].map(({ y }) => y)];
  const [x, y] = [Math.min(...xs), Math.min(...ys)];
  return { x, y, width: Math.max(...xs) + WIDTH - x, height: Math.max(...ys) + HEIGHT - y };
}

function centreOf(places: readonly Point[]): Point {
  const mean = (values: readonly number[]) => values.reduce((sum, one) => sum + one, 0) / Math.max(1, values.length);
  return { x: mean(places.map(({ x }) => x)) + WIDTH / 2, y: mean(places.map(({ y }) => y)) + HEIGHT / 2 };
}

/** The view of a pane [px]: of the whole graph if it is readable like that, otherwise around a point, up to its edges. */
export function viewOf(bounds: Rectangle, pane: Pick<Rectangle, "width" | "height">, around: Point) {
  const whole = Math.min((pane.width - 2 * MARGIN) / bounds.width, (pane.height - 2 * MARGIN) / bounds.height);
  const zoom = whole >= READABLE ? Math.min(1, whole) : 1;
  const along = (start: number, length: number, room: number, at: number) => {
    if (zoom * length + 2 * MARGIN <= room) return (room - zoom * length) / 2 - zoom * start;
    return Math.min(MARGIN - zoom * start, Math.max(room - MARGIN - zoom * (start + length), room / 2 - zoom * at));
  };
  return {
    x: along(bounds.x, bounds.width, pane.width, around.x),
    y: along(bounds.y, bounds.height, pane.height, around.y),
    zoom,
  };
}

type Shape = [ids: string[], edges: GraphEdge[], direction: "down" | "right"];

/** Returns where each node is drawn; children are in their order, left to right (downwards in a graph to the right). */
export function layOut([ids, edges, direction]: Shape): Map<string, { x: number; y: number }> {
  const graph = new dagre.graphlib.Graph();
  graph.setGraph({ rankdir: direction === "down" ? "TB" : "LR", nodesep: 16, ranksep: 34 });
  graph.setDefaultEdgeLabel(() => ({}));
  for (const id of ids) graph.setNode(id, { width: WIDTH, height: HEIGHT });
  for (const { from, to } of edges) graph.setEdge(from, to);
  // The search for few crossings reorders children, even in trees, which have no crossings.
  const isTree = new Set(edges.map(({ to }) => to)).size === edges.length;
  dagre.layout(graph, { disableOptimalOrderHeuristic: isTree });
  return new Map(
    ids.map((id) => {
      const { x, y } = graph.node(id);
      return [id, { x: x - WIDTH / 2, y: y - HEIGHT / 2 }];
    }),
  );
}

function BoxNode({ data: { node, chosen, direction } }: NodeProps<Box>) {
  const [before, after] = direction === "down" ? [Position.Top, Position.Bottom] : [Position.Left, Position.Right];
  const title = [node.title, node.state?.text].filter(Boolean).join(": ");
  return (
    <div className={classes.node} data-chosen={chosen || undefined} data-mood={node.state?.mood} title={title}>
      <Handle type="target" position={before} className={classes.handle} isConnectable={false} />
      <div className={classes.title}>{node.title}</div>
      {node.state !== undefined && <Status mood={node.state.mood} text={node.state.text} />}
      {node.state === undefined && node.subtitle !== undefined && (
        <Text size="xs" truncate>
          {node.subtitle}
        </Text>
      )}
      <Handle type="source" position={after} className={classes.handle} isConnectable={false} />
    </div>
  );
}
