/** How much drawing may cost here: without a graphics card the robot's control needs the processor more than we do. */

export interface Quality {
  /** Whether the processor draws. */
  software: boolean;
  /** Pixels of the picture per pixel of the page, at most. */
  dpr: number;
  antialias: boolean;
  /** Frames per second, at most. */
  rate: number;
}

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
let known: Quality | undefined;

/** What this machine is fit for; found out once. */
export function quality(): Quality {
  known ??= qualityOf(rendererName());
  return known;
}

export function qualityOf(renderer: string): Quality {
  if (SOFTWARE.test(renderer)) return { software: true, dpr: 1, antialias: false, rate: 25 };
  return { software: false, dpr: Math.min(globalThis.devicePixelRatio || 1, 1.5), antialias: true, rate: 30 };
}

function rendererName(): string {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (gl === null) return "";
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info === null ? gl.RENDERER : info.UNMASKED_RENDERER_WEBGL));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return name;
}

/** Whether there is a way to draw in 3D at all. */
export function canDraw(): boolean {
  return document.createElement("canvas").getContext("webgl2") !== null;
}
