import type { MantineColor } from "@mantine/core";
import { useTranslation } from "react-i18next";
import type { Mood } from "../widgets/Status";
import classes from "./Timeline.module.css";
import type { Bar } from "./timelineLayout";
import { TOUCH } from "../app/touch";

export const ROW = TOUCH ? 44 : 20; // px
const PLAN = 9; // px: plans are thinner than executed steps

const COLORS: Record<Mood, MantineColor> = {
  waiting: "gray",
  running: "blue",
  paused: "grape",
  asking: "orange",
  good: "green",
  bad: "red",
  stopped: "orange",
  warning: "yellow",
};
const SIGNS: Record<Mood, string> = {
  waiting: "○",
  running: "▶",
  paused: "‖",
  asking: "?",
  good: "✓",
  bad: "✕",
  stopped: "■",
  warning: "!",
};

/** Hatching of bars by state, so that they can be told apart without colours. */
export function Hatches() {
  return (
    <defs>
      <Hatch id="hatch-bad" angle={45} color="red" />
      <Hatch id="hatch-stopped" angle={-45} color="orange" />
      <Hatch id="hatch-old" angle={90} color="gray" />
    </defs>
  );
}

function Hatch({ id, angle, color }: { id: string; angle: number; color: MantineColor }) {
  return (
    <pattern id={id} width={6} height={6} patternUnits="userSpaceOnUse" patternTransform={`rotate(${angle})`}>
      <rect width={6} height={6} style={{ fill: `var(--mantine-color-${color}-light)` }} />
      <line x1={0} x2={0} y1={0} y2={6} style={{ stroke: `var(--mantine-color-${color}-outline)` }} strokeWidth={1.5} />
    </pattern>
  );
}

interface Props {
  bar: Bar;
  x: number;
  y: number;
  width: number;
  chosen: boolean;
  choose: (() => void) | undefined;
}

export function TimelineBar({ bar, x, y, width, chosen, choose }: Props) {
  const { t } = useTranslation("task");
  const label = t(`bar.${bar.kind}`, { title: bar.title, state: t(`stepStates.${bar.state}`), attempt: bar.attempt });
  const thin = bar.kind === "plan" || bar.kind === "old";
  const height = thin ? PLAN : ROW - 3;
  const drawn = (
    <>
      <title>{label}</title>
      <rect x={x} y={y} width={width} height={height} rx={3} style={look(bar)} />
      {!thin && (
        <svg x={x} y={y} width={width} height={height} aria-hidden>
          <text x={5} y={height - 5} className={classes.text}>
            {fitting(SIGNS[bar.mood], `${bar.attempt > 1 ? `${bar.attempt}× ` : ""}${bar.title}`, width)}
          </text>
        </svg>
      )}
    </>
  );
  if (choose === undefined) return <g aria-hidden>{drawn}</g>; // the table has the same content as text
  return (
    <g
      role="button"
      tabIndex={thin ? -1 : 0}
      aria-label={label}
      aria-pressed={chosen}
      className={`${classes.bar} ${chosen ? classes.chosen : ""}`}
      onClick={choose}
      onKeyDown={(event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        choose();
      }}
    >
      {drawn}
    </g>
  );
}

const [PADDING, SIGN, LETTER] = [8, 14, 5.8]; // px
const FEWEST = 8; // letters that tell something

/** What a bar has room for: its sign with its text, with the beginning of it, or alone. */
export function fitting(sign: string, text: string, width: number): string {
  const letters = Math.floor((width - PADDING - SIGN) / LETTER);
  if (letters >= text.length) return `${sign} ${text}`;
  if (letters > FEWEST) return `${sign} ${text.slice(0, letters - 1).trimEnd()}…`;
  return width >= PADDING + SIGN ? sign : "";
}

function look({ kind, mood }: Bar) {
  const color = kind === "old" || kind === "plan" ? "gray" : COLORS[mood];
  const hatch = kind === "old" ? "old" : kind === "actual" && (mood === "bad" || mood === "stopped") ? mood : null;
  return {
    fill: hatch === null ? `var(--mantine-color-${color}-light)` : `url(#hatch-${hatch})`,
    stroke: color === "gray" ? "var(--mantine-color-dimmed)" : `var(--mantine-color-${color}-outline)`,
    strokeDasharray: kind === "expected" ? "4 3" : undefined,
    fillOpacity: kind === "expected" ? 0.4 : undefined,
  };
}
