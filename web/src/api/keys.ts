/** Keys of cached queries: their first word determines which events invalidate them (see live/freshness.ts). */

export const keys = {
  me: ["me"] as const,
  names: (...rest: unknown[]) => ["names", ...rest] as const,
  world: (...rest: unknown[]) => ["world", ...rest] as const,
  ontology: (...rest: unknown[]) => ["ontology", ...rest] as const,
  scenes: (...rest: unknown[]) => ["scenes", ...rest] as const,
  jobs: (...rest: unknown[]) => ["jobs", ...rest] as const,
  tasks: (...rest: unknown[]) => ["tasks", ...rest] as const,
  documents: (...rest: unknown[]) => ["documents", ...rest] as const,
  modules: (...rest: unknown[]) => ["modules", ...rest] as const,
  moduleRuns: (...rest: unknown[]) => ["module-runs", ...rest] as const,
  goals: (...rest: unknown[]) => ["goals", ...rest] as const,
  robots: (...rest: unknown[]) => ["robots", ...rest] as const,
  robotModels: (...rest: unknown[]) => ["robot-models", ...rest] as const,
  alarms: (...rest: unknown[]) => ["alarms", ...rest] as const,
  station: (...rest: unknown[]) => ["station", ...rest] as const,
};
