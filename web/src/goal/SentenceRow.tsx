import { ActionIcon, Button, Group, Stack, Text, Tooltip } from "@mantine/core";
import { IconBan, IconTrash } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useIsCarried } from "../widgets/carried";
import { ElementPicker } from "../widgets/ElementPicker";
import type { Verdict as Check } from "./checks";
import classes from "./goal.module.css";
import { GoneThings } from "./GoneThings";
import { type Row, textOf, type WordRow } from "./goals";
import type { ConditionWord } from "./sentence";
import { Verdict } from "./Verdict";
import { useSentence } from "./words";

interface Props {
  row: Row;
  /** Meaning of its word; undefined if no robot can do anything for it (any more). */
  word: ConditionWord | undefined;
  verdict: Check;
  onChange: (row: Row) => void;
  onRemove: () => void;
}

/** One condition of the goal, for reading and editing. */
export function SentenceRow({ row, word, verdict, onChange, onRemove }: Props) {
  const { t } = useTranslation("goal");
  const name = textOf(row);
  return (
    <li className={classes.row} aria-label={name}>
      <Group justify="space-between" align="start" wrap="nowrap" gap="xs">
        <Stack gap={4} miw={0} flex={1}>
          {row.kind === "word" && word ? (
            <Sentence row={row} word={word} onChange={onChange} />
          ) : (
            <pre className={classes.code}>{name}</pre>
          )}
          {row.kind === "word" && !word && (
            <Text size="xs" c="orange">
              {t("noSkill")}
            </Text>
          )}
          <Verdict verdict={verdict} />
          {verdict.state === "wrong" && row.kind === "word" && (
            <GoneThings ids={row.arguments.filter((one) => one !== null)} />
          )}
        </Stack>
        <Tooltip label={t("removeCondition")}>
          <ActionIcon color="red" aria-label={`${t("removeCondition")}: ${name}`} onClick={onRemove}>
            <IconTrash size={16} aria-hidden />
          </ActionIcon>
        </Tooltip>
      </Group>
    </li>
  );
}

interface SentenceProps {
  row: WordRow;
  word: ConditionWord;
  onChange: (row: Row) => void;
}

function Sentence({ row, word, onChange }: SentenceProps) {
  const { t } = useTranslation("goal");
  const sentence = useSentence()(word);
  const isCarried = useIsCarried();
  const fill = (slot: number, id: string | null) =>
    onChange({ ...row, arguments: row.arguments.map((old, index) => (index === slot ? id : old)) });
  return (
    <div className={classes.sentence}>
      <Tooltip label={t("notHelp")}>
        <Button
          variant={row.not ? "filled" : "default"}
          color="orange"
          size="compact-xs"
          leftSection={row.not ? <IconBan size={12} aria-hidden /> : undefined}
          onClick={() => onChange({ ...row, not: !row.not })}
        >
          {row.not ? t("unwanted") : t("wanted")}
        </Button>
      </Tooltip>
      {sentence.map((piece) =>
        typeof piece === "string" ? (
          <span key={piece}>{piece.trim()}</span>
        ) : (
          <ElementPicker
            key={piece}
            inline
            label={t("slot", { role: word.roles[piece]?.name ?? "", word: word.name })}
            class_={classAt(word, piece, row.not)}
            abstract={word.abstract && isCarried(classAt(word, piece, row.not))}
            value={row.arguments[piece] ?? null}
            onChange={(id) => fill(piece, id)}
            required
          />
        ),
      )}
    </div>
  );
}

/** Required conditions must be reachable by robots; forbidden ones may be any. */
function classAt({ roles }: ConditionWord, slot: number, not: boolean): string {
  const role = roles[slot];
  return (not ? role?.class : role?.reached) ?? "sk:Element";
}
