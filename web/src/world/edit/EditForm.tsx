import { Alert, Button, Fieldset, Group, Stack, TextInput } from "@mantine/core";
import { IconLock } from "@tabler/icons-react";
import type { SyntheticEvent } from "react";
import { useTranslation } from "react-i18next";
import { MayButton } from "../../widgets/MayButton";
import { useLock } from "../locks/locks";
import type { Placement, Tagged } from "../queries";
import classes from "../World.module.css";
import { Conflict } from "./Conflict";
import { LABEL, PLACEMENT } from "./draft";
import { PlacementInput } from "./PlacementInput";
import { PropertyFields } from "./PropertyFields";
import { Refused } from "./Refused";
import { Unfit } from "./Unfit";
import { type Editing, useEditing } from "./useEditing";

interface Props {
  tagged: Tagged;
  onDone: () => void;
}

/** Edits an element, with a lock; earlier changes by others are shown, never overwritten. */
export function EditForm({ tagged, onDone }: Props) {
  const { t } = useTranslation(["world", "common"]);
  const editing = useEditing(tagged, onDone);
  const locked = useLock(tagged.data.id);
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    editing.save();
  };
  return (
    <form onSubmit={submit} aria-label={t("edit.label", { label: tagged.data.label })}>
      <Stack gap="xs">
        {locked && (
          <Alert color="orange" icon={<IconLock size={16} />} title={t("edit.locked")}>
            {locked}
          </Alert>
        )}
        <Refused lines={editing.rest} />
        <Fields tagged={tagged} editing={editing} />
        <Group justify="end" className={classes.buttons}>
          <Unfit fields={editing.unfit} class_={tagged.data.class} />
          <Button variant="default" onClick={onDone}>
            {t("common:cancel")}
          </Button>
          <MayButton
            operation="change_element"
            type="submit"
            loading={editing.saving}
            disabled={!editing.changed || editing.unfit.length > 0}
          >
            {t("common:save")}
          </MayButton>
        </Group>
      </Stack>
      {editing.theirs && <Conflict editing={editing} theirs={editing.theirs} onDone={onDone} />}
    </form>
  );
}

function Fields({ tagged, editing }: { tagged: Tagged; editing: Editing }) {
  const { t } = useTranslation(["world", "common"]);
  const { draft, setDraft, errors } = editing;
  const { id, class: class_, placement, abstract } = tagged.data;
  return (
    <>
      <TextInput
        label={t("edit.name")}
        value={String(draft[LABEL])}
        error={errors[LABEL]}
        onChange={(event) => setDraft({ ...draft, [LABEL]: event.currentTarget.value })}
      />
      {placement && !abstract && (
        <Fieldset legend={t("edit.placement")} p="xs">
          <PlacementInput
            guest={{ element: id }}
            class_={class_}
            value={draft[PLACEMENT] as Placement | null}
            error={errors[PLACEMENT]}
            onChange={(value) => setDraft({ ...draft, [PLACEMENT]: value })}
          />
        </Fieldset>
      )}
      <PropertyFields class_={class_} draft={draft} onChange={setDraft} errors={errors} />
      <TextInput
        label={t("edit.reason")}
        description={t("edit.reasonHelp")}
        value={editing.reason}
        onChange={(event) => editing.setReason(event.currentTarget.value)}
      />
    </>
  );
}
