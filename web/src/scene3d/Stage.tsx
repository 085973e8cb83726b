import { addAfterEffect, addEffect, useFrame, useThree } from "@react-three/fiber";
import { useEffect, useRef } from "react";
import type { Group } from "three";
import { CameraMan } from "./camera/CameraMan";
import { followDevices, moveDevices } from "./devices";
import { Elements } from "./elements/Elements";
import { Axes } from "./extras/Axes";
import { Contacts } from "./extras/Contacts";
import { Doubts } from "./extras/Doubts";
import { Ghosts } from "./extras/Ghosts";
import { Observations } from "./extras/Observations";
import { Motions } from "./extras/Motions";
import { ReplayClock } from "./extras/ReplayClock";
import { Gizmo } from "./gizmo/Gizmo";
import { Highlight } from "./Highlight";
import { offerHook } from "./hook";
import { LabelMover } from "./overlay/LabelMover";
import type { Palette } from "./palette";
import { Pointer } from "./Pointer";
import { Robots } from "./robots/Robots";
import { Surroundings } from "./Surroundings";
import { drawBy, wake } from "./ticker";

/** The content of the 3D scene. */
export function Stage({ palette }: { palette: Palette }) {
  const matter = useRef<Group>(null);
  useDrawing();
  useEffect(followDevices, []);
  useFrame(() => moveDevices(performance.now()), -3);
  return (
    <>
      <Surroundings palette={palette} />
      <group ref={matter}>
        <Elements palette={palette} />
        <Robots palette={palette} />
      </group>
      <Highlight palette={palette} />
      <Contacts palette={palette} />
      <Doubts palette={palette} />
      <Observations palette={palette} />
      <Motions palette={palette} />
      <Ghosts palette={palette} />
      <Axes />
      <Gizmo palette={palette} />
      <ReplayClock />
      <Pointer among={matter} />
      <CameraMan />
      <LabelMover />
    </>
  );
}

/** Renders on demand, and gives tests access to the view. */
function useDrawing(): void {
  const get = useThree((three) => three.get);
  const gl = useThree((three) => three.gl);
  const camera = useThree((three) => three.camera);
  useEffect(() => {
    const { invalidate, set } = get();
    drawBy(() => invalidate());
    set({ invalidate: () => wake() }); // requests of the libraries, too: all frames keep to one rate
    return () => {
      drawBy(null);
      set({ invalidate });
    };
  }, [get]);
  useEffect(() => offerHook(gl, camera), [gl, camera]);
  useEffect(() => measure(), []);
}

function measure(): () => void {
  let [begun, frames] = [0, 0];
  const endings = [
    addEffect((now) => void (begun = now)),
    addAfterEffect(() => {
      const hook = window.skiros3d;
      if (hook !== undefined && hook.frames !== frames) hook.drawMs = performance.now() - begun;
      frames = hook?.frames ?? 0;
    }),
  ];
  return () => {
    for (const end of endings) end();
  };
}
