import { Alert, Button, Group, List, Modal, Stack, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useSelection } from "../../selection/selection";
import { MayButton } from "../../widgets/MayButton";
import { nameOf } from "../../widgets/names";
import { notifyChange } from "../../widgets/undo";
import { useRelations, type RelationInfo, type Tagged } from "../queries";
import { useWrite } from "../edit/useWrite";

type Node = Schema<"TreeNode">;

interface Props {
  tagged: Tagged;
  onClose: () => void;
}

/** Asks for confirmation before an element is removed; lists what is removed with it, and what moves. */
export function RemoveElement({ tagged: { data, tag }, onClose }: Props) {
  const { t } = useTranslation(["world", "common"]);
  const remove = useWrite(
    () =>
      answer(
        api.DELETE("/api/v1/elements/{element}", {
          params: { path: { element: data.id }, header: { "if-match": tag } },
        }),
      ),
    ({ change }) => {
      notifyChange(t("remove.done", { label: data.label }), change?.number);
      const { selected, choose } = useSelection.getState();
      if (selected === data.id) choose(null);
      onClose();
    },
  );
  return (
    <Modal opened onClose={onClose} title={t("remove.title", { label: nameOf(data.id, data.label) })}>
      <Stack>
        <Hanging element={data.id} place={data.placement?.place ?? null} />
        <Text size="sm">{t("remove.undo")}</Text>
        <Group justify="end">
          <Button variant="default" onClick={onClose} data-autofocus>
            {t("common:cancel")}
          </Button>
          <MayButton operation="remove_element" color="red" loading={remove.isPending} onClick={() => remove.mutate()}>
            {t("common:remove")}
          </MayButton>
        </Group>
      </Stack>
    </Modal>
  );
}

function Hanging({ element, place }: { element: string; place: string | null }) {
  const { t } = useTranslation(["world", "common"]);
  const { data } = useQuery({
    queryKey: keys.world("hanging", element),
    queryFn: () => answer(api.GET("/api/v1/tree", { params: { query: { root: element, depth: 20, limit: 200 } } })),
  });
  const { data: relations } = useRelations();
  if (data === undefined) return null;
  const { pieces, guests } = hanging(data, relations ?? []);
  return (
    <>
      {pieces.length > 0 && (
        <Alert color="orange" title={t("remove.pieces", { count: pieces.length })}>
          <Names nodes={pieces} />
        </Alert>
      )}
      {guests.length > 0 && (
        <Alert
          color="blue"
          title={
            place
              ? t("remove.guests", { place, count: guests.length })
              : t("remove.guestsStay", { count: guests.length })
          }
        >
          <Names nodes={guests} />
        </Alert>
      )}
    </>
  );
}

const FEW = 8;

function Names({ nodes }: { nodes: readonly Node[] }) {
  return (
    <List size="sm">
      {nodes.slice(0, FEW).map(({ id, label }) => (
        <List.Item key={id}>{nameOf(id, label)}</List.Item>
      ))}
      {nodes.length > FEW && <List.Item>…</List.Item>}
    </List>
  );
}

/** Sorts the children of a node: parts, which are removed with it, and elements placed at it, which stay. */
function hanging(node: Node, relations: readonly RelationInfo[]): { pieces: Node[]; guests: Node[] } {
  const structure = new Set(relations.filter(({ family }) => family === "structure").map(({ name }) => name));
  const pieces = node.children.filter(({ relation }) => structure.has(relation));
  const guests = node.children.filter(({ relation }) => !structure.has(relation));
  const below = pieces.map((piece) => hanging(piece, relations));
  return {
    pieces: [...pieces, ...below.flatMap((one) => one.pieces)],
    guests: [...guests, ...below.flatMap((one) => one.guests)],
  };
}
