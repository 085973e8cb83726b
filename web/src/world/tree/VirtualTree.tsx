import {
  buildProxiedInstance,
  dragAndDropFeature,
  hotkeysCoreFeature,
  type ItemInstance,
  selectionFeature,
  syncDataLoaderFeature,
  type TreeInstance,
} from "@headless-tree/core";
import { useTree } from "@headless-tree/react";
import { ActionIcon } from "@mantine/core";
import { IconChevronDown, IconChevronRight } from "@tabler/icons-react";
import { useVirtualizer } from "@tanstack/react-virtual";
import { type ReactNode, useEffect, useMemo, useRef } from "react";
import classes from "./VirtualTree.module.css";
import { TOUCH } from "../../app/touch";

/** The nodes of a tree, by id. */
export interface TreeSource {
  children: (id: string) => readonly string[];
  name: (id: string) => string;
  /** Whether it has children, fetched or not. */
  folder: (id: string) => boolean;
}

interface Props {
  label: string;
  source: TreeSource;
  /** Ids of expanded nodes; the same array while they are unchanged. */
  open: string[];
  onOpen: (open: string[]) => void;
  selected: string | null;
  onChoose: (id: string) => void;
  onHover?: (id: string | null) => void;
  /** Renders a row. */
  row: (id: string) => ReactNode;
  /** Called when a node is dropped on another; without it, nodes cannot be dragged. */
  onDrop?: (dragged: string, target: string) => void;
}

const ABOVE_ALL = "#tree"; // no element has this id
const ROW = TOUCH ? 44 : 26; // px
const INDENT = 16; // px
const MARGIN = 12; // rows rendered outside of the visible range
const FEATURES = [syncDataLoaderFeature, selectionFeature, hotkeysCoreFeature, dragAndDropFeature];

/** A tree with the keyboard support of the WAI-ARIA pattern, of which only visible rows are rendered. */
export function VirtualTree(props: Props) {
  const { source, onHover } = props;
  const scroller = useRef<HTMLDivElement>(null);
  const scroll = useRef<(index: number) => void>(() => undefined);
  const tree = useSourceTree(props, (index) => scroll.current(index));
  useEffect(() => tree.rebuildTree(), [tree, source, props.open]);
  useShown(tree, props, (index) => scroll.current(index));
  return (
    <div ref={scroller} className={classes.scroller} onMouseLeave={() => onHover?.(null)}>
      <Rows {...props} tree={tree} scroller={scroller} scroll={scroll} />
    </div>
  );
}

function useSourceTree(props: Props, scrollTo: (index: number) => void): TreeInstance<string> {
  const { source, open, onOpen, selected, onChoose, onDrop } = props;
  const selectedItems = useMemo(() => (selected === null ? [] : [selected]), [selected]);
  const ids = (id: string) => [...source.children(id === ABOVE_ALL ? "" : id)];
  return useTree<string>({
    rootItemId: ABOVE_ALL,
    features: FEATURES,
    instanceBuilder: buildProxiedInstance, // 2,000 items with all their methods would take a quarter of a second
    indent: INDENT,
    dataLoader: { getItem: (id) => id, getChildren: ids },
    getItemName: (item) => source.name(item.getId()),
    isItemFolder: (item) => source.folder(item.getId()),
    state: { expandedItems: open, selectedItems },
    setExpandedItems: (next) => onOpen(typeof next === "function" ? next(open) : next),
    setSelectedItems: () => undefined, // single selection, reported by onChoose
    onPrimaryAction: (item) => onChoose(item.getId()),
    scrollToItem: (item) => scrollTo(item.getItemMeta().index),
    canReorder: false,
    canDrag: () => onDrop !== undefined,
    canDrop: (items, { item }) => items[0] !== undefined && mayHold(items[0], item),
    onDrop: (items, { item }) => items[0] && onDrop?.(items[0].getId(), item.getId()),
  });
}

function mayHold(dragged: ItemInstance<string>, target: ItemInstance<string>): boolean {
  const id = target.getId();
  return id !== ABOVE_ALL && id !== dragged.getId() && !target.isDescendentOf(dragged.getId());
}

/** Scrolls to an element that was selected elsewhere. */
function useShown(tree: TreeInstance<string>, { selected, source, open }: Props, scrollTo: (index: number) => void) {
  const shown = useRef<string | null>(null);
  useEffect(() => {
    if (selected === shown.current) return;
    const index = tree.getItems().findIndex((item) => item.getId() === selected);
    if (selected !== null && index < 0) return; // after its branch is fetched
    shown.current = selected;
    if (index >= 0) requestAnimationFrame(() => scrollTo(index)); // after measuring
  }, [tree, selected, source, open, scrollTo]);
}

interface RowsProps extends Props {
  tree: TreeInstance<string>;
  scroller: React.RefObject<HTMLDivElement | null>;
  scroll: React.RefObject<(index: number) => void>;
}

function Rows({ tree, label, scroller, scroll, row, onHover }: RowsProps) {
  const items = tree.getItems();
  // eslint-disable-next-line react-hooks/incompatible-library -- nothing of it is handed to what is memoised
  const rows = useVirtualizer({
    count: items.length,
    getScrollElement: () => scroller.current,
    estimateSize: () => ROW,
    overscan: MARGIN,
    // Rows are keyed by element, or a click could end on another row when rows are inserted above.
    getItemKey: (index) => items[index]?.getId() ?? index,
  });
  useEffect(() => {
    scroll.current = (index) => rows.scrollToIndex(index);
  }, [rows, scroll]);
  return (
    <div {...tree.getContainerProps(label)} style={{ height: rows.getTotalSize(), position: "relative" }}>
      {rows.getVirtualItems().map(({ key, index, start }) => {
        const item = items[index];
        return item && <Row key={key} item={item} top={start} onHover={onHover} content={row(item.getId())} />;
      })}
    </div>
  );
}

interface RowProps {
  item: ItemInstance<string>;
  top: number;
  content: ReactNode;
  onHover?: (id: string | null) => void;
}

function Row({ item, top, content, onHover }: RowProps) {
  const choose = () => {
    item.setFocused();
    item.primaryAction();
  };
  return (
    <div
      {...item.getProps()}
      role="treeitem"
      aria-selected={item.isSelected()}
      tabIndex={item.isFocused() ? 0 : -1}
      className={classes.row}
      data-target={item.isDragTarget() || undefined}
      style={{ height: ROW, transform: `translateY(${top}px)`, paddingLeft: item.getItemMeta().level * INDENT }}
      onClick={choose}
      onKeyDown={(event) => (event.key === "Enter" || event.key === " ") && choose()}
      onMouseEnter={() => onHover?.(item.getId())}
    >
      <Opener item={item} />
      {content}
    </div>
  );
}

function Opener({ item }: { item: ItemInstance<string> }) {
  if (!item.isFolder()) return <span className={classes.leaf} />;
  const open = item.isExpanded();
  const toggle = (event: React.MouseEvent) => {
    event.stopPropagation();
    if (open) item.collapse();
    else item.expand();
  };
  const Icon = open ? IconChevronDown : IconChevronRight;
  // The tree's arrow keys do the same, so it is no tab stop.
  return (
    <ActionIcon component="span" size={18} color="gray" tabIndex={-1} role="presentation" onClick={toggle}>
      <Icon size={14} aria-hidden />
    </ActionIcon>
  );
}
