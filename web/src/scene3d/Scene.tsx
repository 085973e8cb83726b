import { Alert, useComputedColorScheme } from "@mantine/core";
import { Canvas, type RootState } from "@react-three/fiber";
import { type KeyboardEvent, useEffect, useId } from "react";
import { useTranslation } from "react-i18next";
import { useCamera, type Viewpoint } from "./camera/camera";
import { PosePanel } from "./gizmo/PosePanel";
import { Compass } from "./overlay/Compass";
import { Labels } from "./overlay/Labels";
import { Notices } from "./overlay/Notices";
import { Summary } from "./overlay/Summary";
import { Toolbar } from "./overlay/Toolbar";
import { paletteOf } from "./palette";
import { canDraw, quality } from "./quality";
import "./quiet";
import classes from "./Scene.module.css";
import { Stage } from "./Stage";
import { followView } from "./view";

const KEYS: Record<string, Viewpoint> = { o: "overview", t: "top", r: "follow", f: "selection", Home: "overview" };

/** The live 3D view: robots, elements, and the uncertainty of their poses. */
export default function Scene() {
  const { t } = useTranslation("scene3d");
  if (!canDraw()) return <Alert m="md">{t("noWebGL")}</Alert>;
  return (
    <div className={classes.scene}>
      <Picture />
      <Labels />
      <Compass />
      <Toolbar />
      <Notices />
      <PosePanel />
    </div>
  );
}

function Picture() {
  const { t } = useTranslation("scene3d");
  const scheme = useComputedColorScheme();
  const words = useId();
  const { dpr, antialias } = quality();
  useEffect(followView, []); // here, because the canvas mounts its children only after it was measured
  return (
    // The view handles keys itself: they turn the camera.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-element-interactions
    <div
      className={classes.picture}
      data-picture
      role="application"
      aria-label={t("picture")}
      aria-describedby={words}
      // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
      tabIndex={0}
      onKeyDown={look}
    >
      <Canvas
        flat
        frameloop="demand"
        dpr={dpr}
        gl={{ antialias, powerPreference: "high-performance" }}
        onCreated={trustShaders}
        camera={{ fov: 38, near: 0.1, far: 80, up: [0, 0, 1], position: [4, -7, 6] }}
      >
        <Stage palette={paletteOf(scheme)} />
      </Canvas>
      <Summary id={words} />
    </div>
  );
}

/** Checking each shader program would block the page until the graphics driver, or its software substitute, is done. */
function trustShaders({ gl }: RootState): void {
  gl.debug.checkShaderErrors = import.meta.env.DEV;
}

function look({ key, ctrlKey, metaKey, altKey }: KeyboardEvent): void {
  const viewpoint = KEYS[key];
  if (viewpoint !== undefined && !ctrlKey && !metaKey && !altKey) useCamera.getState().look(viewpoint);
}
