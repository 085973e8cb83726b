import { Stack, Text } from "@mantine/core";
import { IconPlayerPlay, IconSchool } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../../i18n/sentences";
import { argumentFaults, type Arguments, ArgumentsForm } from "../../widgets/ArgumentsForm";
import { MayButton } from "../../widgets/MayButton";
import { type Device } from "../../api/cell";
import { useModule } from "../queries";
import { jogger, jog, teach } from "./robotJogger";

interface Props {
  device: Device;
  /** One of the modules that the device's kind names. */
  module: Device["jog"][number];
  verb: "jog" | "teach";
  /** Its title for people; the module's help if missing. */
  hint?: string | undefined;
  disabled: boolean;
}

const DOES = {
  jog: { step: jog, operation: "jog_device" },
  teach: { step: teach, operation: "teach_device" },
} as const;

/** The form of a module that jogs or teaches with a device, without the device parameter. */
export function ModuleForm({ device, module: { module, agent }, verb, hint, disabled }: Props) {
  const { t } = useTranslation("modules");
  const { data: details } = useModule(agent ?? "", module);
  const [values, setValues] = useState<Arguments>({});
  if (agent === null) return <Text size="sm">{t("list.unknown", { name: module })}</Text>;
  const all = details?.parameters ?? [];
  const own = all.find(({ kind }) => kind === "hardware");
  const parameters = all.filter((parameter) => parameter !== own);
  const isOpen = parameters.some(({ key, kind }) => kind === "online" && values[key] === undefined);
  const isValid = details !== undefined && !isOpen && Object.keys(argumentFaults(parameters, values)).length === 0;
  const { step, operation } = DOES[verb];
  const Icon = verb === "jog" ? IconPlayerPlay : IconSchool;
  return (
    <Stack gap="xs" align="stretch">
      <Text size="sm">{hint ?? said(details?.help ?? "")}</Text>
      <ArgumentsForm parameters={parameters} value={values} onChange={setValues} />
      <MayButton
        operation={operation}
        leftSection={<Icon size={14} aria-hidden />}
        disabled={disabled || !isValid}
        onClick={() => jogger.once(step(device.id, module, values))}
      >
        {verb === "jog" ? module : t("teach.here")}
      </MayButton>
    </Stack>
  );
}
