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
let renderer: string | null | undefined;

/** What this machine is fit for; found out once. */
export function quality(): Quality {
  known ??= qualityOf(rendererName() ?? "");
  return known;
}

/** Whether there is a way to draw in 3D at all. */
export function canDraw(): boolean {
  return rendererName() !== null;
}

export function qualityOf(renderer: string): Quality {
  if (SOFTWARE.test(renderer)) return { software: true, dpr: 1, antialias: false, rate: 25 };
  return { software: false, dpr: Math.min(globalThis.devicePixelRatio || 1, 1.5), antialias: true, rate: 30 };
}

/** The renderer; null for none. Asked once: a context of its own takes long to make, and a browser has few. */
function rendererName(): string | null {
  renderer ??= nameFrom(document.createElement("canvas").getContext("webgl2"));
  return renderer;
}

function nameFrom(gl: WebGL2RenderingContext | null): string | null {
  if (gl === null) return null;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info === null ? gl.RENDERER : info.UNMASKED_RENDERER_WEBGL));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return name;
}
