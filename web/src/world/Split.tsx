import { useElementSize } from "@mantine/hooks";
import type { ReactNode } from "react";
import { Group, Panel, Separator } from "react-resizable-panels";
import classes from "./World.module.css";

interface Props {
  /** Label of the divider. */
  divider: string;
  list: ReactNode;
  details: ReactNode;
}

const WIDE = 760; // px: wide enough for both side by side

/** A list or tree with the details of the selected entry: side by side, or stacked in narrow windows. */
export function Split({ divider, list, details }: Props) {
  const { ref, width } = useElementSize();
  const wide = width >= WIDE;
  return (
    <div ref={ref} className={classes.fill}>
      <Group orientation={wide ? "horizontal" : "vertical"}>
        <Panel defaultSize="45%" minSize="15%" className={classes.part}>
          {list}
        </Panel>
        <Separator className={wide ? classes.upright : classes.level} aria-label={divider} />
        <Panel minSize="20%" className={classes.part}>
          <div className={classes.details}>{details}</div>
        </Panel>
      </Group>
    </div>
  );
}
