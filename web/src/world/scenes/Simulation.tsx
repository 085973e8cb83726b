import { Alert, DataList, Group, SegmentedControl, Slider, Stack, Text } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useSimulation } from "../../api/cell";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useMay } from "../../api/session";
import { MayButton } from "../../widgets/MayButton";
import { notifyProblem } from "../../widgets/problems";
import { Status } from "../../widgets/Status";
import { ConfirmDialog } from "../../widgets/ConfirmDialog";

type State = Schema<"SimulationState">;

const LOOKED_AT = 2000; // ms: time has no events

/** The pace of the simulation, and its reset. */
export function Simulation() {
  const { data: state } = useSimulation(LOOKED_AT);
  if (state === undefined) return null;
  return (
    <Stack gap="xs">
      <Facts state={state} />
      {state.pace !== null && <Pace key={state.pace} pace={state.pace} />}
      <Reset state={state} />
    </Stack>
  );
}

function Facts({ state }: { state: State }) {
  const { t } = useTranslation("world");
  return (
    <>
      <Group gap="xs">
        {state.halted ? (
          <Status mood="stopped" text={t("simulation.halted", { why: state.halted })} />
        ) : (
          <Status mood={state.running ? "running" : "paused"} text={t(`simulation.running.${state.running}`)} />
        )}
        <Text size="sm">{state.resting ? t("simulation.resting") : t("simulation.busy")}</Text>
      </Group>
      <DataList size="sm" labelWidth={110}>
        <Fact label={t("simulation.driver")} value={state.driver} />
        <Fact label={t("simulation.time")} value={`${state.time.toFixed(1)} s`} />
        <Fact
          label={t("simulation.pace")}
          value={state.pace === null ? t("simulation.lockstep") : t("simulation.times", { pace: state.pace })}
        />
      </DataList>
      {state.stale.length > 0 && (
        <Alert color="yellow" title={t("simulation.stale")}>
          {state.stale.map((line) => (
            <div key={line}>{line}</div>
          ))}
        </Alert>
      )}
    </>
  );
}

function Fact({ label, value }: { label: string; value: string }) {
  return (
    <DataList.Item>
      <DataList.ItemLabel>{label}</DataList.ItemLabel>
      <DataList.ItemValue>{value}</DataList.ItemValue>
    </DataList.Item>
  );
}

const [SLOWEST, FASTEST] = [0.05, 20];
const USUAL = [0.25, 1, 2, 5, FASTEST];

function Pace({ pace }: { pace: number }) {
  const { t } = useTranslation("world");
  const may = useMay("set_pace");
  const client = useQueryClient();
  // Paces differ by factors, so the slider is logarithmic.
  const [power, setPower] = useState(() => Math.log2(pace));
  const set = (next: number) => {
    const wanted = Math.min(FASTEST, Math.max(SLOWEST, Number(next.toPrecision(2))));
    answer(api.PUT("/api/v1/simulation/pace", { body: { pace: wanted } }))
      .then(() => client.invalidateQueries({ queryKey: keys.station("simulation") }))
      .catch(notifyProblem);
  };
  const name = (value: number) => (value === FASTEST ? t("simulation.max") : `${value} ×`);
  return (
    <Group gap="md">
      <SegmentedControl
        size="xs"
        aria-label={t("simulation.usual")}
        disabled={!may}
        value={String(pace)}
        onChange={(value) => set(Number(value))}
        data={USUAL.map((value) => ({ value: String(value), label: name(value) }))}
      />
      <Slider
        flex={1}
        miw={160}
        thumbLabel={t("simulation.pace")}
        disabled={!may}
        min={Math.log2(SLOWEST)}
        max={Math.log2(FASTEST)}
        step={0.05}
        label={(value) => `${(2 ** value).toPrecision(2)} ×`}
        value={power}
        onChange={setPower}
        onChangeEnd={(value) => set(2 ** value)}
      />
    </Group>
  );
}

function Reset({ state }: { state: State }) {
  const { t } = useTranslation("world");
  const [asked, setAsked] = useState(false);
  const client = useQueryClient();
  const reset = () => {
    answer(api.POST("/api/v1/simulation/reset", { params: { query: { force: !state.resting } } }))
      .then(() => client.invalidateQueries())
      .catch(notifyProblem);
  };
  return (
    <Group>
      <MayButton operation="reset_simulation" variant="default" onClick={() => setAsked(true)}>
        {t("simulation.reset")}
      </MayButton>
      {asked && (
        <ConfirmDialog
          title={t("simulation.resetTitle")}
          text={state.resting ? t("simulation.resetText") : t("simulation.resetForce")}
          action={state.resting ? t("simulation.reset") : t("simulation.stopAndReset")}
          onConfirm={reset}
          onClose={() => setAsked(false)}
        />
      )}
    </Group>
  );
}
