/** Which subsystem runs the modules that a kind of device names. */

import type { Device, Summary } from "../queries";

/** Returns the subsystem that jogs or teaches with a device; undefined where no skill manager offers the module. */
export function agentFor(modules: readonly Summary[], module: string, { id, robot }: Device): string | undefined {
  const places = modules.find(({ name }) => name === module)?.agents ?? [];
  const fitting = places.find(({ agent }) => agent === id) ?? places.find((place) => place.robot === robot);
  return (fitting ?? (robot === null ? places[0] : undefined))?.agent;
}
