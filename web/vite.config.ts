import react from "@vitejs/plugin-react";
import type { HtmlTagDescriptor, Plugin, Rolldown } from "vite";
import { compression, defineAlgorithm } from "vite-plugin-compression2";
import { defineConfig } from "vitest/config";

const FIRST = ["Scene", "GoalTab"]; // what the first screen needs, though its code asks for it only when it runs

/** Has browsers fetch at once what the first screen needs. */
function preloadFirst(): Plugin {
  const handler = (_html: string, { bundle = {} }: { bundle?: Rolldown.OutputBundle }) => {
    const chunks = Object.values(bundle).filter((output) => output.type === "chunk");
    const first = chunks.filter(({ name }) => FIRST.includes(name));
    const needed = new Set(first.flatMap(({ fileName, imports }) => [fileName, ...imports]));
    const there = chunks.filter(({ isEntry }) => isEntry).flatMap(({ fileName, imports }) => [fileName, ...imports]);
    return [...needed].filter((file) => !there.includes(file)).map(preloadTag);
  };
  return { name: "preload-first", transformIndexHtml: { order: "post", handler } };
}

function preloadTag(fileName: string): HtmlTagDescriptor {
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
  build: { outDir: "skiros_web/pages", emptyOutDir: true, target: "es2022", chunkSizeWarningLimit: 1500 },
  server: { host: "127.0.0.1", proxy: { "/api": { target: "http://127.0.0.1:8000", changeOrigin: true } } },
  test: { environment: "jsdom", globals: true, setupFiles: ["src/testing/setup.ts"], restoreMocks: true },
});
