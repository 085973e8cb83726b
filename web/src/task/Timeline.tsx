import { ActionIcon, Group, Stack, Switch, Text, Tooltip } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";
import { IconArrowAutofitWidth, IconTable, IconZoomIn, IconZoomOut } from "@tabler/icons-react";
import { scaleLinear, type ScaleLinear } from "d3-scale";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useReplay } from "../scene3d/replay";
import type { Skills } from "../api/cell";
import classes from "./Timeline.module.css";
import { Hatches, ROW, TimelineBar } from "./TimelineBar";
import { type Bar, type Lane, layOut, type TimelineLayout } from "./timelineLayout";
import { TimelineTable } from "./TimelineTable";
import type { Run } from "./trace";
import { useNow } from "./useRun";
import { useWheelZoom, useZoom, type Zoom, zoomByKey } from "./useZoom";
import { span } from "./words";
import { useStation } from "../live/station";

interface Props {
  /** Id of the job, or name of the task. */
  name: string;
  run: Run;
  skills: Skills;
  paused: boolean;
  /** Explains why the timeline is empty. */
  nothing: string;
  chosen: string | null;
  choose: (step: string) => void;
}

const NAME = 16; // px, of the line with the name of a lane
const AXIS = 20; // px
const GAP = 6; // px

/** Plan and execution by subsystem; while running, with the present and the expected end. */
export function Timeline({ run, ...rest }: Props) {
  if (run.end === null) return <LiveTimeline run={run} {...rest} />;
  return <DrawnTimeline run={run} now={run.end} {...rest} />;
}

function LiveTimeline(props: Props) {
  return <DrawnTimeline {...props} now={Math.max(useNow() + props.run.shift, props.run.begun)} />;
}

function DrawnTimeline({ name, run, skills, paused, nothing, now, chosen, choose }: Props & { now: number }) {
  const { t } = useTranslation("task");
  const layout = layOut(run, skills, now, paused);
  const rate = useStation(({ rate: measured }) => (measured === null ? null : Number(measured.toPrecision(1))));
  const zoom = useZoom(layout, layout.readable, run.end === null ? now : null);
  const [table, showTable] = useState(false);
  if (layout.lanes.length === 0) return <Text c="dimmed">{nothing}</Text>;
  return (
    <Stack gap={4}>
      <Group gap={4}>
        <Tools zoom={zoom} live={run.end === null} table={table} showTable={showTable} />
        <Text size="sm" ml="auto" role="status">
          {summary(layout, now, t)}
        </Text>
      </Group>
      {table ? (
        <TimelineTable run={run} layout={layout} chosen={chosen} choose={choose} />
      ) : (
        <Picture
          layout={layout}
          zoom={zoom}
          origin={run.begun}
          now={run.end === null ? now : null}
          name={name}
          chosen={chosen}
          choose={choose}
        />
      )}
      {!table && (
        <Text size="xs" c="dimmed">
          {t("timeline.legend")}
          {layout.lanes.some(({ bars }) => bars.some(({ kind }) => kind === "old")) && ` ${t("timeline.legendOld")}`}
        </Text>
      )}
    </Stack>
  );

  /** How long simulated seconds take a person who waits; empty if that is the same. */
  function onTheWall(simulated: number): string {
    if (rate === null || rate === 0 || rate === 1) return "";
    return t("timeline.wall", { left: span(simulated / rate) });
  }

  function summary({ eta }: TimelineLayout, at: number, say: typeof t): string {
    const took = span(at - run.begun);
    if (run.end !== null) return say("timeline.took", { time: took });
    return eta === null
      ? say("timeline.since", { time: took })
      : say("timeline.eta", { time: took, left: span(eta - at), wall: onTheWall(eta - at) });
  }
}

interface ToolsProps {
  zoom: Zoom;
  live: boolean;
  table: boolean;
  showTable: (on: boolean) => void;
}

function Tools({ zoom, live, table, showTable }: ToolsProps) {
  const { t } = useTranslation("task");
  const buttons = [
    { name: t("timeline.in"), icon: IconZoomIn, act: () => zoom.zoom(1.5) },
    { name: t("timeline.out"), icon: IconZoomOut, act: () => zoom.zoom(1 / 1.5) },
    { name: t("timeline.all"), icon: IconArrowAutofitWidth, act: zoom.all },
  ];
  return (
    <>
      {!table &&
        buttons.map(({ name, icon: Icon, act }) => (
          <Tooltip key={name} label={name}>
            <ActionIcon aria-label={name} onClick={act}>
              <Icon size={16} />
            </ActionIcon>
          </Tooltip>
        ))}
      <Tooltip label={t("timeline.table")}>
        <ActionIcon
          aria-label={t("timeline.table")}
          aria-pressed={table}
          variant={table ? "light" : "subtle"}
          onClick={() => showTable(!table)}
        >
          <IconTable size={16} />
        </ActionIcon>
      </Tooltip>
      {live && !table && (
        <Switch
          size="xs"
          label={t("timeline.follow")}
          checked={zoom.follows}
          onChange={(event) => zoom.follow(event.currentTarget.checked)}
        />
      )}
    </>
  );
}

interface PictureProps extends Pick<Props, "name" | "chosen" | "choose"> {
  layout: TimelineLayout;
  zoom: Zoom;
  origin: number;
  /** The present [s, run time]; null for ended runs. */
  now: number | null;
}

function Picture({ name, layout, zoom, origin, now, chosen, choose }: PictureProps) {
  const { t } = useTranslation("task");
  const { ref: sized, width } = useElementSize<HTMLDivElement>();
  const scale = scaleLinear([zoom.start, zoom.end], [0, Math.max(width, 1)]);
  const ref = useWheelZoom<SVGSVGElement>((x) => scale.invert(x), zoom.zoom);
  const tops = laneTops(layout.lanes);
  const height = (tops.at(-1) ?? 0) + AXIS;
  return (
    <div ref={sized}>
      {/* A timeline can be moved and zoomed by keys; each of its bars is a button. */}
      <svg
        ref={ref}
        className={classes.timeline}
        height={height}
        role="group"
        aria-label={t("timeline.label")}
        aria-roledescription={t("timeline.role")}
        onKeyDown={(event) => {
          if (zoomByKey(event.key, zoom)) event.preventDefault();
        }}
      >
        <Hatches />
        <Axis scale={scale} height={height} origin={origin} />
        {layout.replanned.map((at) => (
          <g key={at}>
            <title>{t("timeline.replanned")}</title>
            <line className={classes.eta} x1={scale(at)} x2={scale(at)} y1={0} y2={height - AXIS} />
            <text className={classes.tick} x={scale(at) + 3} y={10}>
              ↻
            </text>
          </g>
        ))}
        {layout.lanes.map((lane, index) => (
          <DrawnLane
            key={lane.agent}
            lane={lane}
            top={tops[index] ?? 0}
            scale={scale}
            chosen={chosen}
            choose={choose}
          />
        ))}
        <Mark at={layout.eta} scale={scale} height={height} className={classes.eta} title={t("timeline.end")} />
        <Mark at={now} scale={scale} height={height} className={classes.now} title={t("timeline.now")} />
        <Cursor name={name} scale={scale} height={height} />
      </svg>
    </div>
  );
}

/** Top of each lane, and bottom of the last one [px]. */
function laneTops(lanes: readonly Lane[]): number[] {
  const tops = [GAP];
  for (const lane of lanes) tops.push((tops.at(-1) ?? 0) + NAME + lane.rows * ROW + GAP);
  return tops;
}

interface LaneProps extends Pick<Props, "chosen" | "choose"> {
  lane: Lane;
  top: number;
  scale: ScaleLinear<number, number>;
}

const NARROWEST = 3; // px

function DrawnLane({ lane, top, scale, chosen, choose }: LaneProps) {
  const { t } = useTranslation("task");
  const [, right] = scale.range() as [number, number];
  const seen = lane.bars.filter((bar) => scale(bar.end) >= 0 && scale(bar.start) <= right);
  return (
    <g role="group" aria-label={t("timeline.lane", { agent: lane.agent || t("timeline.nobody") })}>
      <text className={classes.name} x={2} y={top + NAME - 5}>
        {lane.agent || t("timeline.nobody")}
      </text>
      {seen.map((bar) => (
        <TimelineBar
          key={bar.key}
          bar={bar}
          x={scale(bar.start)}
          y={rowTop(top, bar)}
          width={Math.max(NARROWEST, scale(bar.end) - scale(bar.start))}
          chosen={bar.step !== null && bar.step === chosen && bar.kind === "actual"}
          choose={bar.step === null ? undefined : () => choose(bar.step ?? "")}
        />
      ))}
    </g>
  );
}

const THIN_ROW = 12; // px: plans are thin, so attempts start higher

function rowTop(top: number, bar: Bar): number {
  return top + NAME + (bar.row === 0 ? 0 : THIN_ROW + (bar.row - 1) * ROW);
}

function Axis({ scale, height, origin }: { scale: ScaleLinear<number, number>; height: number; origin: number }) {
  const [, right] = scale.range() as [number, number];
  const [start, end] = scale.domain() as [number, number];
  const shown = scaleLinear([start - origin, end - origin], [0, right]);
  return (
    <g aria-hidden>
      {shown.ticks(Math.max(2, right / 80)).map((tick) => (
        <g key={tick}>
          <line className={classes.grid} x1={shown(tick)} x2={shown(tick)} y1={0} y2={height - AXIS} />
          <text className={classes.tick} x={shown(tick)} y={height - 6} textAnchor={anchor(shown(tick), right)}>
            {`${tick} s`}
          </text>
        </g>
      ))}
    </g>
  );
}

const LABEL = 18; // px: half the width of an axis label at most

/** Keeps the outer labels within the drawing. */
function anchor(x: number, right: number): "start" | "middle" | "end" {
  if (x < LABEL) return "start";
  return x > right - LABEL ? "end" : "middle";
}

/** The current time of this job's replay; a component of its own, since it changes often. */
function Cursor({ name, ...drawn }: Pick<Props, "name"> & Pick<MarkProps, "scale" | "height">) {
  const { t } = useTranslation("task");
  const at = useReplay(({ replay, time }) => (replay?.job === name ? time : null));
  return <Mark {...drawn} at={at} className={classes.cursor} title={t("timeline.replayed")} />;
}

interface MarkProps {
  at: number | null;
  scale: ScaleLinear<number, number>;
  height: number;
  className: string | undefined;
  title: string;
}

function Mark({ at, scale, height, className, title }: MarkProps) {
  if (at === null) return null;
  return (
    <line className={className} x1={scale(at)} x2={scale(at)} y1={0} y2={height - AXIS}>
      <title>{title}</title>
    </line>
  );
}
