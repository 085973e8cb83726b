import { SegmentedControl, Stack, Text } from "@mantine/core";
import { IconSchool } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { argumentFaults, type Arguments, ArgumentsForm } from "../../widgets/ArgumentsForm";
import { MayButton } from "../../widgets/MayButton";
import { ModuleForm } from "../jog/ModuleForm";
import { hand, teach } from "../jog/robotHand";
import { type Device, type Robot, useModule, useModules } from "../queries";

/** Lessons that the server teaches a robot, with their modules; kinds of device may name further modules. */
const LESSONS = { grasp: "teach_grasp", "driving-pose": "teach_driving_pose", "placing-pose": "teach_placing_pose" };
type Lesson = keyof typeof LESSONS;

/** Teaches a robot from how it stands now. */
export function Teach({ robot, devices, disabled }: { robot: Robot; devices: readonly Device[]; disabled: boolean }) {
  const known: readonly string[] = Object.values(LESSONS);
  return (
    <Stack gap="md">
      <Lessons robot={robot} disabled={disabled} />
      {devices
        .filter(({ teach }) => teach !== "" && !known.includes(teach))
        .map((device) => (
          <ModuleForm key={device.id} device={device} module={device.teach} disabled={disabled} />
        ))}
    </Stack>
  );
}

function Lessons({ robot, disabled }: { robot: Robot; disabled: boolean }) {
  const { t } = useTranslation("modules");
  const [lesson, setLesson] = useState<Lesson>("grasp");
  const [values, setValues] = useState<Arguments>({});
  const parameters = useParameters(robot, LESSONS[lesson]);
  const open = parameters.some(({ key, kind }) => kind === "online" && values[key] === undefined);
  const sound = !open && Object.keys(argumentFaults(parameters, values)).length === 0;
  const choose = (next: string) => {
    setLesson(next as Lesson);
    setValues({});
  };
  return (
    <Stack gap="xs" align="stretch">
      <SegmentedControl
        size="xs"
        aria-label={t("teach.what")}
        data={(Object.keys(LESSONS) as Lesson[]).map((name) => ({ value: name, label: t(`teach.lessons.${name}`) }))}
        value={lesson}
        onChange={choose}
      />
      <Text size="sm">{t(`teach.hints.${lesson}`)}</Text>
      <ArgumentsForm key={lesson} parameters={parameters} value={values} onChange={setValues} />
      <MayButton
        operation="teach_robot"
        leftSection={<IconSchool size={14} aria-hidden />}
        disabled={disabled || !sound}
        onClick={() => hand.once(teach(robot.id, { what: lesson, arguments: values }))}
      >
        {t("teach.here")}
      </MayButton>
    </Stack>
  );
}

function useParameters(robot: Robot, module: string) {
  const { data: modules = [] } = useModules();
  const places = modules.find(({ name }) => name === module)?.agents ?? [];
  const agent = places.find((place) => place.robot === robot.id)?.agent ?? "";
  return useModule(agent, module).data?.parameters ?? [];
}
