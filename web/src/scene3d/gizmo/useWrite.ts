import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { useSingleMutation } from "../../api/mutations";
import { changeSince, notifyChange } from "../../widgets/undo";
import { seenFrom } from "../pose";
import type { MapPose } from "../tools";
import { type Movable, poseInMap } from "./useMovable";

const DIGITS = 6;

/** Writes the believed pose of an element, unless another person has changed it. */
export function useWriteBelief(id: string) {
  const { t } = useTranslation("scene3d");
  return useSingleMutation({
    mutationFn: ({ pose, movable }: { pose: MapPose; movable: Movable }) => {
      const frame = movable.frame === null ? null : poseInMap(movable.frame);
      const inFrame = rounded(seenFrom(pose, frame));
      const value = { ...inFrame, frame: frame === null ? null : movable.frame };
      const params = { path: { element: id }, header: { "if-match": movable.tag } };
      return answer(
        api.PATCH("/api/v1/elements/{element}", { params, body: { properties: { "sk:pose": value }, reason: "" } }),
      );
    },
    onSuccess: (now, { movable }) => notifyChange(t("moved", { label: now.label }), changeSince(movable, now)),
  });
}

/** Moves the simulated body without informing the robots. */
export function useMoveBody(id: string) {
  return useSingleMutation({
    mutationFn: async (pose: MapPose) => {
      const params = { path: { element: id } };
      const { error, response } = await api.PUT("/api/v1/simulation/bodies/{element}/pose", {
        params,
        body: rounded(pose),
      });
      if (!response.ok) await answer(Promise.resolve({ error, response }));
    },
  });
}

function rounded({ position, orientation }: MapPose): MapPose {
  const round = (value: number) => Number(value.toFixed(DIGITS));
  const [x, y, z, w] = orientation;
  return { position: [round(position[0]), round(position[1]), round(position[2])], orientation: [x, y, z, w] };
}
