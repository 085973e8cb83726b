import "@mantine/core/styles.css";
import "@mantine/notifications/styles.css";
import "./app/app.css";
import "./i18n";
import { Notifications } from "@mantine/notifications";
import { QueryClientProvider } from "@tanstack/react-query";
import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { queryClient } from "./api/queries";
import { App } from "./app/App";
import { Themed } from "./app/Themed";

const root = document.getElementById("root");
if (root === null) throw new Error("index.html has no root");

const TOAST = 290; // px: next to the tool panel of the 3D view

createRoot(root).render(
  <StrictMode>
    <Themed>
      <QueryClientProvider client={queryClient}>
        <Notifications position="bottom-left" limit={4} containerWidth={TOAST} />
        <App />
      </QueryClientProvider>
    </Themed>
  </StrictMode>,
);
