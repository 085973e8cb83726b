import { Box, Group, Text, UnstyledButton } from "@mantine/core";
import type { ReactNode } from "react";
import classes from "./task.module.css";

interface Props {
  title: ReactNode;
  note: ReactNode;
  state?: ReactNode;
  current: boolean;
  open: () => void;
}

/** An entry of a list that can be opened. */
export function Entry({ title, note, state, current, open }: Props) {
  return (
    <UnstyledButton className={classes.entry} aria-current={current || undefined} onClick={open}>
      <Text size="sm" fw={600} truncate>
        {title}
      </Text>
      <Group gap={6} wrap="nowrap">
        {state !== undefined && <Box flex="none">{state}</Box>}
        <Text size="xs" truncate>
          {note}
        </Text>
      </Group>
    </UnstyledButton>
  );
}
