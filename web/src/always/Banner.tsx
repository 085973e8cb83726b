import { Group, Text } from "@mantine/core";
import type { TablerIcon } from "@tabler/icons-react";
import type { ReactNode } from "react";
import classes from "./always.module.css";

interface Props {
  tone: "red" | "orange";
  icon: TablerIcon;
  title: string;
  children: ReactNode;
  /** Buttons for the possible actions. */
  actions?: ReactNode;
}

/** A message across the page, announced at once by screen readers; small, since there may be several. */
export function Banner({ tone, icon: Icon, title, children, actions }: Props) {
  return (
    <div role="alert" className={classes.banner} data-tone={tone}>
      <Icon size={20} aria-hidden className={classes.bannerIcon} />
      <div className={classes.bannerText}>
        <Text span size="sm" fw={700}>
          {title}
        </Text>{" "}
        <Text span size="sm">
          {children}
        </Text>
      </div>
      {actions && <Group gap={6}>{actions}</Group>}
    </div>
  );
}
