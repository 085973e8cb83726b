import { Button, Code, CopyButton, Popover, Stack } from "@mantine/core";
import { IconCheck, IconCopy, IconTerminal2 } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { BASE } from "../../api/client";
import { useMe } from "../../api/session";
import classes from "../modules.module.css";
import { cliCommand, curlCommand, type Wanted } from "../shellWords";

/** The same run as a command to copy. */
export function CopyAs({ wanted }: { wanted: Wanted }) {
  const { t } = useTranslation("modules");
  const { data: me } = useMe();
  return (
    <>
      <Command title={t("copy.cli")} hint={t("copy.cliHint")} text={cliCommand(wanted)} />
      <Command title={t("copy.curl")} text={curlCommand(wanted, BASE, me?.keys_needed ?? false)} />
    </>
  );
}

function Command({ title, text, hint }: { title: string; text: string; hint?: string }) {
  const { t } = useTranslation("modules");
  return (
    <Popover position="bottom-end" withArrow trapFocus>
      <Popover.Target>
        <Button variant="default" leftSection={<IconTerminal2 size={14} aria-hidden />}>
          {title}
        </Button>
      </Popover.Target>
      <Popover.Dropdown>
        <Stack gap="xs" align="start">
          <Code block className={classes.code}>
            {text}
          </Code>
          {hint}
          <CopyButton value={text}>
            {({ copied, copy }) => (
              <Button
                onClick={copy}
                leftSection={copied ? <IconCheck size={14} aria-hidden /> : <IconCopy size={14} aria-hidden />}
              >
                {copied ? t("copy.copied") : t("copy.copy")}
              </Button>
            )}
          </CopyButton>
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}
