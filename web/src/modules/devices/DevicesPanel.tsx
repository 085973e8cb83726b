import { Badge, Button, Group, Paper, Stack, Table, Text, Title } from "@mantine/core";
import { useQuery, useQueryClient } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { useSingleMutation } from "../../api/mutations";
import { MayButton } from "../../widgets/MayButton";
import { notifyProblem } from "../../widgets/problems";
import { Status } from "../../widgets/Status";
import classes from "../modules.module.css";
import type { View } from "../places";
import { type Device, useDevices } from "../../api/cell";
import { shown } from "../runs/changes";
import { SignalPanel } from "./SignalPanel";
import { extended, type Signal, type Traces } from "./traces";

type Show = (view: View, ...rest: string[]) => void;

const READ_EVERY = 500; // ms
const MOST = 200; // signals fetched at once

/** All devices of the cell, of any kind, with their signals; and all other signals. */
export function DevicesPanel({ show }: { show: Show }) {
  const { t } = useTranslation("modules");
  const { data: devices } = useDevices(5000);
  const { data: signals = [] } = useQuery({
    queryKey: keys.robots("signals"),
    queryFn: async () => (await answer(api.GET("/api/v1/signals"))).items,
  });
  const traces = useTraces(signals);
  const ids = new Set(devices?.map(({ id }) => id));
  const others = signals.filter(({ source }) => !ids.has(source));
  return (
    <Stack gap="sm" p="sm">
      <Text size="xs" c="dimmed" className={classes.live}>
        {traces && t("devices.readAt", { time: traces.time.toFixed(2), cycle: traces.cycle })}
      </Text>
      {devices?.length === 0 && <Text size="sm">{t("devices.none")}</Text>}
      {devices?.map((device) => (
        <DeviceCard
          key={device.id}
          device={device}
          signals={signals.filter(({ source }) => source === device.id)}
          traces={traces}
          show={show}
        />
      ))}
      {others.length > 0 && (
        <Paper withBorder p="sm" component="section" aria-label={t("devices.others")}>
          <Title order={3} size="h5">
            {t("devices.others")}
          </Title>
          <SignalList signals={others} traces={traces} />
        </Paper>
      )}
    </Stack>
  );
}

/** Polls the values of signals while they are shown. */
function useTraces(signals: readonly Signal[]): Traces | undefined {
  const client = useQueryClient();
  const names = signals.slice(0, MOST).map(({ name }) => name);
  const queryKey = keys.robots("signal values", names);
  const { data } = useQuery({
    queryKey,
    queryFn: async () => {
      const readings = await answer(api.GET("/api/v1/signals/values", { params: { query: { name: names } } }));
      return extended(client.getQueryData<Traces>(queryKey), readings);
    },
    enabled: names.length > 0,
    refetchInterval: READ_EVERY,
    structuralSharing: false,
  });
  return data;
}

interface CardProps {
  device: Device;
  signals: readonly Signal[];
  traces: Traces | undefined;
  show: Show;
}

function DeviceCard({ device, signals, traces, show }: CardProps) {
  const { t } = useTranslation("modules");
  const { id, kind, robot, open } = device;
  return (
    <Paper withBorder p="sm" component="section" aria-label={id}>
      <Group gap="xs">
        <Title order={3} size="h5">
          {id}
        </Title>
        <Badge variant="default" tt="none">
          {kind}
        </Badge>
        <Text size="sm" c="dimmed">
          {robot ?? t("devices.noRobot")}
        </Text>
        <Status mood={open ? "good" : "stopped"} text={t(open ? "devices.isOpen" : "devices.isClosed")} />
        <OpenOrClose device={device} />
        <ByHand device={device} name="jog" show={show} />
        <ByHand device={device} name="teach" show={show} />
      </Group>
      {signals.length > 0 ? (
        <SignalList signals={signals} traces={traces} />
      ) : (
        <Text size="xs">{t("devices.noSignals")}</Text>
      )}
      <details>
        <summary>{t("devices.description")}</summary>
        <Table fz="xs" verticalSpacing={2}>
          <Table.Tbody>
            {Object.entries(device.description).map(([name, value]) => (
              <Table.Tr key={name}>
                <Table.Th>{name}</Table.Th>
                <Table.Td>{shown(value)}</Table.Td>
              </Table.Tr>
            ))}
          </Table.Tbody>
        </Table>
      </details>
    </Paper>
  );
}

function SignalList({ signals, traces }: { signals: readonly Signal[]; traces: Traces | undefined }) {
  return (
    <ul className={classes.signals}>
      {signals.map((signal) => (
        <SignalPanel key={signal.name} signal={signal} traces={traces} />
      ))}
    </ul>
  );
}

function OpenOrClose({ device: { id, open } }: { device: Device }) {
  const { t } = useTranslation("modules");
  const client = useQueryClient();
  const change = useSingleMutation({
    mutationFn: () => {
      const params = { path: { id } };
      return answer(
        open ? api.POST("/api/v1/devices/{id}/close", { params }) : api.POST("/api/v1/devices/{id}/open", { params }),
      );
    },
    onError: notifyProblem,
    onSettled: () => client.invalidateQueries({ queryKey: keys.robots("devices") }),
  });
  return (
    <MayButton
      operation={open ? "close_device" : "open_device"}
      variant="default"
      size="compact-xs"
      loading={change.isPending}
      aria-label={t(open ? "devices.closeOne" : "devices.openOne", { id })}
      onClick={() => change.mutate()}
    >
      {t(open ? "devices.close" : "devices.open")}
    </MayButton>
  );
}

interface ByHandProps {
  device: Device;
  name: "jog" | "teach";
  show: Show;
}

/** Opens jogging or teaching for a device; hidden if no skill manager offers a module for it. */
function ByHand({ device, name, show }: ByHandProps) {
  const { t } = useTranslation("modules");
  const { module, agent } = device[name][0] ?? { agent: null };
  if (agent === null) return null;
  return (
    <Button
      variant="default"
      size="compact-xs"
      title={module}
      aria-label={t(`devices.${name}One`, { id: device.id })}
      onClick={() => (device.robot === null ? show("try", agent, module) : show("jog", device.robot))}
    >
      {t(`devices.${name}`)}
    </Button>
  );
}
