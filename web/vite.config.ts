import react from "@vitejs/plugin-react";
import type { HtmlTagDescriptor, Plugin, Rolldown } from "vite";
import { compression, defineAlgorithm } from "vite-plugin-compression2";
import { defineConfig } from "vitest/config";

const FIRST = ["Scene", "GoalTab"]; // loaded dynamically, but needed by the first screen

/** Lets browsers preload the chunks of the first screen. */
function preloadFirst(): Plugin {
  const handler = (_html: string, { bundle = {} }: { bundle?: Rolldown.OutputBundle }) => {
    const chunks = Object.values(bundle).filter((output) => output.type === "chunk");
    const needed = closure(chunks, ({ name }) => FIRST.includes(name));
    const there = closure(chunks, ({ isEntry }) => isEntry);
    return [...needed].filter((chunk) => !there.has(chunk)).map(preloadTag);
  };
  return { name: "preload-first", transformIndexHtml: { order: "post", handler } };
}

/** The wanted chunks with all their imports. */
function closure(
  chunks: Rolldown.OutputChunk[],
  wanted: (chunk: Rolldown.OutputChunk) => boolean,
): Set<Rolldown.OutputChunk> {
  const found = new Set(chunks.filter(wanted));
  for (const { imports } of found) {
    for (const chunk of chunks) if (imports.includes(chunk.fileName)) found.add(chunk);
  }
  return found;
}

function preloadTag({ fileName }: Rolldown.OutputChunk): HtmlTagDescriptor {
  return { tag: "link", attrs: { rel: "modulepreload", crossorigin: true, href: `./${fileName}` }, injectTo: "head" };
}

export default defineConfig({
  base: "./", // the pages work below any prefix of a proxy
  plugins: [
    react(),
    preloadFirst(),
    compression({
      algorithms: [defineAlgorithm("gzip", { level: 9 }), defineAlgorithm("brotliCompress")],
      include: /\.(html|js|css|svg|json)$/,
    }),
  ],
  build: { outDir: "python/skiros_web/pages", emptyOutDir: true, target: "es2022", chunkSizeWarningLimit: 1500 },
  server: { host: "127.0.0.1", proxy: { "/api": { target: "http://127.0.0.1:8000", changeOrigin: true } } },
  test: { environment: "jsdom", globals: true, setupFiles: ["src/testing/setup.ts"], restoreMocks: true },
});
