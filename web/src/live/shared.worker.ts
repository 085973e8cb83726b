/** Runs beside all pages of a browser, and keeps the streams that they share. */

import { Sharing, type Wish } from "./sharing";

declare const self: { onconnect: ((event: MessageEvent) => void) | null };

const sharing = new Sharing();

self.onconnect = ({ ports }) => {
  const [port] = ports;
  if (port) port.onmessage = ({ data }: MessageEvent<Wish>) => sharing.obey(port, data);
};
