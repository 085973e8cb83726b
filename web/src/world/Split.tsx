import { useElementSize } from "@mantine/hooks";
import type { ReactNode } from "react";
import { Group, Panel, Separator } from "react-resizable-panels";
import classes from "./World.module.css";

interface Props {
  /** Names the divider. */
  divider: string;
  list: ReactNode;
  details: ReactNode;
}

const WIDE = 760; // px: from here on both have room beside each other

/** A list or tree with the details of what is chosen in it: beside each other, or below where it is narrow. */
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
