import { Group, Text } from "@mantine/core";
import { useEffect, useMemo } from "react";
import { useTranslation } from "react-i18next";
import { isGone } from "../../api/client";
import { useSelection } from "../../selection/selection";
import { notifyProblem } from "../../widgets/problems";
import { nameOf, spoken } from "../../widgets/names";
import { KindIcon } from "../kinds";
import { type Branches, followTree, type Node, reveal, setOpen, useBranches } from "./branches";
import classes from "./SceneTree.module.css";
import { TOP } from "./top";
import { type TreeSource, VirtualTree } from "./VirtualTree";

/** The tree of placements and parts, synchronised with the selection of the 3D view. */
export function SceneTree({ onMove }: { onMove?: (element: string, place: string) => void }) {
  const { t } = useTranslation("world");
  const branches = useBranches((state) => state.branches);
  const open = useBranches((state) => state.open);
  const selected = useSelection((selection) => selection.selected);
  const choose = useSelection((selection) => selection.choose);
  const hover = useSelection((selection) => selection.hover);
  const grown = useMemo(() => grow(branches), [branches]);
  useEffect(followTree, []);
  useRevealed(selected, grown.nodes);
  return (
    <VirtualTree
      label={t("tree.label")}
      source={grown}
      open={open}
      onOpen={setOpen}
      selected={selected}
      onChoose={choose}
      onHover={hover}
      onDrop={onMove}
      row={(id) => <Label node={grown.nodes.get(id)} />}
    />
  );
}

function useRevealed(selected: string | null, nodes: ReadonlyMap<string, Node>) {
  const ready = useBranches((state) => state.ready);
  const there = selected !== null && nodes.has(selected);
  useEffect(() => {
    if (ready && selected !== null) reveal(selected).catch((error: unknown) => isGone(error) || notifyProblem(error));
  }, [ready, selected, there]);
}

interface Grown extends TreeSource {
  nodes: ReadonlyMap<string, Node>;
}

/** Builds one tree from the fetched branches; an element with two parents is shown below the first. */
function grow(branches: Branches): Grown {
  const nodes = new Map<string, Node>();
  const children = new Map<string, string[]>();
  const take = (id: string) => {
    const fresh = (branches[id] ?? []).filter((child) => !nodes.has(child.id));
    fresh.forEach((child) => nodes.set(child.id, child));
    children.set(
      id,
      fresh.map((child) => child.id),
    );
    fresh.forEach((child) => take(child.id));
  };
  take(TOP);
  return {
    nodes,
    children: (id) => children.get(id) ?? [],
    name: (id) => nameOf(id, nodes.get(id)?.label ?? id),
    folder: (id) => (nodes.get(id)?.children_total ?? 0) > 0,
  };
}

function Label({ node }: { node: Node | undefined }) {
  if (node === undefined) return null;
  return (
    <>
      <KindIcon class_={node.class} />
      <Names node={node} />
    </>
  );
}

function Names({ node }: { node: Node }) {
  const hovered = useSelection((selection) => selection.hovered === node.id);
  return (
    <Group gap={6} wrap="nowrap" className={classes.names} data-hovered={hovered || undefined}>
      <Text span size="sm" truncate>
        {node.label}
      </Text>
      {node.label !== node.id && (
        <Text span size="xs" c="dimmed" truncate>
          {node.id}
        </Text>
      )}
      <Text span size="xs" c="dimmed" className={classes.relation}>
        {spoken(node.relation)}
        {node.children_total > 0 && ` · ${node.children_total}`}
      </Text>
    </Group>
  );
}
