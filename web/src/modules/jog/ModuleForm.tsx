import { Stack, Text } from "@mantine/core";
import { IconPlayerPlay } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { argumentFaults, type Arguments, ArgumentsForm } from "../../widgets/ArgumentsForm";
import { MayButton } from "../../widgets/MayButton";
import { agentFor } from "../devices/agents";
import { type Device, useModule, useModules } from "../queries";
import { hand, run } from "./robotHand";

interface Props {
  device: Device;
  /** The module that the device's kind names for this. */
  module: string;
  disabled: boolean;
}

/** The parameters of a module that moves a device or teaches with it: for kinds without a panel of their own. */
export function ModuleForm({ device, module, disabled }: Props) {
  const { t } = useTranslation("modules");
  const { data: modules = [] } = useModules();
  const agent = agentFor(modules, module, device);
  const { data: details } = useModule(agent ?? "", module);
  const [chosen, setChosen] = useState<Arguments>({});
  if (agent === undefined) return <Text size="sm">{t("list.unknown", { name: module })}</Text>;
  const parameters = details?.parameters ?? [];
  const hardware = parameters.filter(({ kind }) => kind === "hardware");
  const values = hardware[0] && hardware.length === 1 ? { [hardware[0].key]: device.id, ...chosen } : chosen;
  const isValid = Object.keys(argumentFaults(parameters, values)).length === 0;
  return (
    <Stack gap="xs" align="stretch">
      <Text size="sm">{details?.help}</Text>
      <ArgumentsForm parameters={parameters} value={values} onChange={setChosen} />
      <MayButton
        operation="run_module"
        leftSection={<IconPlayerPlay size={14} aria-hidden />}
        disabled={disabled || !isValid || details === undefined}
        onClick={() => hand.once(run(agent, module, values))}
      >
        {module}
      </MayButton>
    </Stack>
  );
}
