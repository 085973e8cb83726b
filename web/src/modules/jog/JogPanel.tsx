import { Accordion, Alert, Select, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useMay } from "../../api/session";
import { Teach } from "../teach/Teach";
import { Learned } from "../teach/Learned";
import type { View } from "../places";
import { type RobotInfo as Robot, useDevices, useRobots } from "../../api/cell";
import { JogBar } from "./JogBar";
import { panelsOf } from "./panels";
import { useHindrance } from "./useHindrance";
import { nameOf } from "../../widgets/names";

interface Props {
  /** Id of the robot; undefined for the first one. */
  chosen: string | undefined;
  show: (view: View, ...rest: string[]) => void;
}

/** Jogging a robot, and teaching at its current pose. */
export function JogPanel({ chosen, show }: Props) {
  const { t } = useTranslation("modules");
  const { data: robots = [] } = useRobots();
  const robot = robots.find(({ id }) => id === chosen) ?? robots[0];
  if (robot === undefined) return <Text p="sm">{t("jog.noRobot")}</Text>;
  return (
    <>
      {robots.length > 1 && (
        <Select
          m="sm"
          label={t("robot")}
          allowDeselect={false}
          data={robots.map(({ id, label }) => ({ value: id, label: nameOf(id, label) }))}
          value={robot.id}
          onChange={(id) => id !== null && show("jog", id)}
        />
      )}
      <ByHand key={robot.id} robot={robot} alone={robots.length === 1} />
    </>
  );
}

function ByHand({ robot, alone }: { robot: Robot; alone: boolean }) {
  const { t } = useTranslation("modules");
  const hindrance = useHindrance(robot, alone);
  const may = useMay("jog_device");
  const disabled = hindrance !== "" || !may;
  const { data: devices } = useDevices(5000);
  if (devices === undefined) return null;
  const own = devices.filter((device) => device.robot === robot.id);
  const panels = own.flatMap((device) => panelsOf({ device, disabled, t }));
  const handiest = [...own].sort((one, other) => other.jog.length - one.jog.length);
  const first = handiest[0]?.id;
  return (
    <Stack gap="xs">
      <JogBar devices={own} disabled={disabled} />
      {disabled && (
        <Alert mx="sm" color="yellow" title={t("jog.notNow")} role="status">
          {may ? hindrance : t("jog.mayNot")}
        </Alert>
      )}
      <Accordion
        multiple
        defaultValue={panels.filter(({ device }) => device === first).map(({ value }) => value)}
        variant="default"
      >
        {panels.map(({ value, title, content }) => (
          <Section key={value} value={value} title={title}>
            {content}
          </Section>
        ))}
        <Section value="teach" title={t("teach.title")}>
          <Teach devices={handiest} disabled={disabled} />
        </Section>
        <Section value="learned" title={t("learned.title")}>
          <Learned />
        </Section>
      </Accordion>
    </Stack>
  );
}

function Section({ value, title, children }: { value: string; title: string; children: React.ReactNode }) {
  return (
    <Accordion.Item value={value}>
      <Accordion.Control>{title}</Accordion.Control>
      <Accordion.Panel>{children}</Accordion.Panel>
    </Accordion.Item>
  );
}
