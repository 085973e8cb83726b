import { SegmentedControl, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { ModuleForm } from "../jog/ModuleForm";
import type { Device } from "../../api/cell";

/** Teaches with the current state of a robot's devices, with the teach modules of their kinds. */
export function Teach({ devices, disabled }: { devices: readonly Device[]; disabled: boolean }) {
  const { t } = useTranslation("modules");
  const [chosen, setChosen] = useState<string>();
  const lessons = devices.flatMap((device) =>
    device.teach.map((module) => ({ device, module, value: `${device.id} ${module.module}` })),
  );
  const lesson = lessons.find(({ value }) => value === chosen) ?? lessons[0];
  if (lesson === undefined) return <Text size="sm">{t("teach.nothing")}</Text>;
  const words = (name: string, of: "lessons" | "hints") =>
    t(`teach.${of}.${name}` as "teach.what", { defaultValue: "" });
  const label = ({ device: { id }, module: { module } }: (typeof lessons)[number]) =>
    `${words(module, "lessons") || module} (${id})`;
  return (
    <Stack gap="xs" align="stretch">
      <SegmentedControl
        size="xs"
        aria-label={t("teach.what")}
        data={lessons.map((one) => ({ value: one.value, label: label(one) }))}
        value={lesson.value}
        onChange={setChosen}
      />
      <ModuleForm
        key={lesson.value}
        device={lesson.device}
        module={lesson.module}
        verb="teach"
        hint={words(lesson.module.module, "hints") || undefined}
        disabled={disabled}
      />
    </Stack>
  );
}
