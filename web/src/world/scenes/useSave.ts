import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, answerWithTag, api } from "../../api/client";
import { keys } from "../../api/keys";
import { useSingleMutation } from "../../api/mutations";
import { problemText } from "../../widgets/problems";
import { notifyDone } from "../../widgets/toasts";
import { useScenes } from "./queries";

export interface Saving {
  save: (name: string) => void;
  busy: boolean;
  /** The reason of a refusal; empty without one. */
  refusal: string;
  /** Whether a saved scene of that name would be replaced, which needs confirmation. */
  asked: boolean;
  replace: () => void;
  close: () => void;
}

/** Saves the current scene; replaces an existing one only after confirmation. */
export function useSave(): Saving {
  const { t } = useTranslation("world");
  const client = useQueryClient();
  const { data: scenes } = useScenes();
  const [asked, setAsked] = useState("");
  const write = useSingleMutation({
    mutationFn: ({ name, tag }: { name: string; tag?: string }) => post(name, tag),
    onSuccess: ({ name }) => {
      for (const queryKey of [keys.scenes(), keys.station("scene")]) void client.invalidateQueries({ queryKey });
      notifyDone(t("scenes.saved", { name }));
    },
  });
  const replace = useSingleMutation({
    mutationFn: async (name: string) => {
      const { tag } = await answerWithTag(api.GET("/api/v1/scenes/{name}", { params: { path: { name } } }));
      setAsked("");
      write.mutate({ name, tag });
    },
  });
  const error = write.error ?? replace.error;
  return {
    save: (name) => {
      const there = scenes?.some((scene) => scene.name === name && scene.source === "saved");
      if (there) setAsked(name);
      else write.mutate({ name });
    },
    busy: write.isPending || replace.isPending,
    refusal: error ? problemText(error) : "",
    asked: asked !== "",
    replace: () => replace.mutate(asked),
    close: () => setAsked(""),
  };
}

function post(name: string, tag: string | undefined) {
  const header = tag === undefined ? {} : { "if-match": tag };
  return answer(api.POST("/api/v1/scenes", { params: { header }, body: { name } }));
}
