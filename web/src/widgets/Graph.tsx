import "@xyflow/react/dist/style.css";
import dagre from "@dagrejs/dagre";
import { Text } from "@mantine/core";
import {
  Controls,
  type Edge,
  Handle,
  type Node,
  type NodeProps,
  Position,
  ReactFlow,
  ReactFlowProvider,
  useReactFlow,
} from "@xyflow/react";
import { useCallback, useEffect, useMemo, useRef } from "react";
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
const MARGIN = 0.08;

/** A read-only graph: automatic layout, pan and zoom, nodes selectable by pointer and keyboard. */
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
  const { moved, fitted } = useFitted(shape);
  return (
    <section aria-label={label} className={classes.graph}>
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
        proOptions={HIDDEN}
        onMoveStart={(event) => {
          if (event !== null) moved();
        }}
        onNodeClick={(_, { id }) => onChoose?.(id)}
        onNodesChange={(changes) => {
          for (const change of changes) if (change.type === "select" && change.selected) onChoose?.(change.id);
        }}
      >
        <Controls showInteractive={false} onFitView={fitted} />
      </ReactFlow>
    </section>
  );
}

/** Fits the view whenever the graph grows, until the user moves it. */
function useFitted(shape: string) {
  const { fitView } = useReactFlow();
  const touched = useRef(false);
  useEffect(() => {
    if (touched.current) return;
    const frame = requestAnimationFrame(() => void fitView({ padding: MARGIN, maxZoom: 1 }));
    return () => cancelAnimationFrame(frame);
  }, [shape, fitView]);
  const moved = useCallback(() => void (touched.current = true), []);
  const fitted = useCallback(() => void (touched.current = false), []);
  return { moved, fitted };
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
  const live = node.state?.mood === "running";
  return (
    <div className={classes.node} data-chosen={chosen || undefined} data-live={live || undefined} title={node.title}>
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
