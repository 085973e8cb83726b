import { Button, Loader } from "@mantine/core";
import { useDebouncedValue } from "@mantine/hooks";
import { IconAlertTriangle, IconClick, IconHistory, IconMask } from "@tabler/icons-react";
import { useIsFetching } from "@tanstack/react-query";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { usePretends } from "../../api/cell";
import { keys } from "../../api/keys";
import { useSelection } from "../../selection/selection";
import { problemText } from "../../widgets/problems";
import { useReplay } from "../replay";
import { useLiveView } from "../view";
import classes from "./Overlay.module.css";

const SOON = 700; // ms: faster loading needs no message

/** Notices about the view: it shows a replay, waits for a click, or is outdated. */
export function Notices() {
  return (
    <div className={classes.notices}>
      <ReplayNotice />
      <PickNotice />
      <ProblemNotice />
      <PretenceNotice />
      <ModelNotice />
    </div>
  );
}

function ReplayNotice() {
  const { t } = useTranslation("scene3d");
  const job = useReplay((state) => state.replay?.job);
  const seconds = useReplay((state) => (state.time - (state.replay?.start ?? 0)).toFixed(1));
  const set = useReplay((state) => state.set);
  if (job === undefined) return null;
  return (
    <>
      <div className={classes.notice} data-mood="past" role="note">
        <IconHistory size={16} aria-hidden />
        {t("replay.badge", { job, seconds })}
        <Button size="compact-xs" variant="default" onClick={() => set({ replay: null, speed: 0 })}>
          {t("replay.end")}
        </Button>
      </div>
    </>
  );
}

function PickNotice() {
  const { t } = useTranslation("scene3d");
  const pick = useSelection((state) => state.pick);
  const endPick = useSelection((state) => state.endPick);
  const waits = pick !== null;
  useEffect(() => {
    if (!waits) return;
    const end = (event: KeyboardEvent) => event.key === "Escape" && endPick();
    window.addEventListener("keydown", end);
    return () => window.removeEventListener("keydown", end);
  }, [waits, endPick]);
  if (pick === null) return null;
  return (
    <div className={classes.notice} data-mood="pick" role="status">
      <IconClick size={16} aria-hidden />
      {t("pick.text", { purpose: pick.purpose })}
      <Button size="compact-xs" variant="default" onClick={endPick}>
        {t("pick.end")}
      </Button>
    </div>
  );
}

function PretenceNotice() {
  const { t } = useTranslation("scene3d");
  if (!usePretends()) return null;
  return (
    <div className={classes.notice} role="note">
      <IconMask size={16} aria-hidden />
      {t("pretends")}
    </div>
  );
}

function ProblemNotice() {
  const { t } = useTranslation("scene3d");
  const problem = useLiveView((state) => state.problem);
  if (problem === null) return null;
  return (
    <div className={classes.notice} role="status">
      <IconAlertTriangle size={16} aria-hidden />
      {t("stale", { why: problemText(problem) })}
    </div>
  );
}

/** Shows that the server is still preparing the models of robots, which takes a while the first time. */
function ModelNotice() {
  const { t } = useTranslation("scene3d");
  const robots = useIsFetching({ queryKey: keys.robotModels() });
  const [waited] = useDebouncedValue(robots, SOON);
  if (robots === 0 || waited === 0) return null;
  return (
    <div className={classes.notice} role="status">
      <Loader size={14} aria-hidden />
      {t("preparing", { count: robots })}
    </div>
  );
}
