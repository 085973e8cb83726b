/** Limits the cost of rendering: without a graphics card the robot's control needs the processor more. */

export interface Quality {
  /** Whether rendering is done in software. */
  software: boolean;
  /** Maximum ratio of rendered pixels to CSS pixels. */
  dpr: number;
  antialias: boolean;
  /** Maximum frame rate [Hz]. */
  rate: number;
}

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
let known: Quality | undefined;
let renderer: string | null | undefined;

/** The capability of this machine; determined once. */
export function quality(): Quality {
  known ??= qualityOf(rendererName() ?? "");
  return known;
}

/** Whether 3D rendering is available. */
export function canDraw(): boolean {
  return rendererName() !== null;
}

export function qualityOf(renderer: string): Quality {
  if (SOFTWARE.test(renderer)) return { software: true, dpr: 1, antialias: false, rate: 25 };
  return { software: false, dpr: Math.min(globalThis.devicePixelRatio || 1, 1.5), antialias: true, rate: 30 };
}

/** The name of the renderer; null for none. Determined once: contexts take long to create, and browsers limit them. */
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
