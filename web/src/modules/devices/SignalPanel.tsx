import { Group, Text } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { useSingleMutation } from "../../api/mutations";
import { argumentFaults, type Arguments, ArgumentsForm } from "../../widgets/ArgumentsForm";
import { MayButton } from "../../widgets/MayButton";
import { notifyProblem } from "../../widgets/problems";
import classes from "../modules.module.css";
import { shown } from "../runs/changes";
import { parameterOf, paths, type Point, type Reading, type Signal, type Traces } from "./traces";

interface Props {
  signal: Signal;
  traces: Traces | undefined;
}

const WIDTH = 120; // px
const HEIGHT = 24; // px

/** One signal: value and unit, dimension, frame and source, its last seconds, and a form if it can be set. */
export function SignalPanel({ signal, traces }: Props) {
  const { t } = useTranslation("modules");
  const { name, dimension, frame, help, source, input, unit } = signal;
  const reading = traces?.signals[name];
  const frameText = frame === "own" ? t("devices.ownFrame") : frame && t("devices.frame", { frame });
  const isOwn = name === source || name.startsWith(`${source}.`);
  const about = [help, dimension, frameText, isOwn ? "" : t("devices.from", { source })];
  return (
    <li className={classes.signal} aria-label={name}>
      <div>
        <Text size="sm" fw={600}>
          {name}
        </Text>
        <Text size="xs" c="dimmed">
          {about.filter(Boolean).join(" · ")}
        </Text>
      </div>
      <Text size="sm" className={classes.live}>
        <ValueText reading={reading} unit={unit} />
      </Text>
      <Line points={traces?.points[name] ?? []} />
      {input && <SetSignal signal={signal} value={reading?.value} />}
    </li>
  );
}

function ValueText({ reading, unit }: { reading: Reading | undefined; unit: string }) {
  const { t } = useTranslation("modules");
  if (reading === undefined) return null;
  if (reading.value === null) return <>{t("devices.noValue", { why: reading.reason })}</>;
  if (typeof reading.value === "boolean") return <>{t(reading.value ? "form.yes" : "form.no")}</>;
  return <>{`${shown(reading.value)} ${unit}`.trim()}</>;
}

function Line({ points }: { points: readonly Point[] }) {
  return (
    <svg width={WIDTH} height={HEIGHT} viewBox={`0 -1 ${WIDTH} ${HEIGHT + 2}`} className={classes.line} aria-hidden>
      {paths(points, WIDTH, HEIGHT).map((path, index) => (
        <path key={index} d={path} />
      ))}
    </svg>
  );
}

function SetSignal({ signal, value }: { signal: Signal; value: Reading["value"] | undefined }) {
  const { t } = useTranslation("modules");
  const [draft, setDraft] = useState<Arguments>({});
  const parameters = [parameterOf(signal, value)];
  const wanted = draft[signal.name] as boolean | number | number[] | undefined;
  const isValid = wanted !== undefined && Object.keys(argumentFaults(parameters, draft)).length === 0;
  const set = useSingleMutation({
    mutationFn: (value: boolean | number | number[]) =>
      answer(api.PUT("/api/v1/signals/{name}/value", { params: { path: { name: signal.name } }, body: { value } })),
    onError: notifyProblem,
  });
  return (
    <Group className={classes.wide} align="end" gap="xs">
      <ArgumentsForm parameters={parameters} value={draft} onChange={setDraft} notes={{ [signal.name]: "" }} />
      <MayButton
        operation="set_signal"
        variant="default"
        loading={set.isPending}
        disabled={!isValid}
        aria-label={t("devices.setOne", { name: signal.name })}
        onClick={() => wanted !== undefined && set.mutate(wanted)}
      >
        {t("devices.set")}
      </MayButton>
    </Group>
  );
}
