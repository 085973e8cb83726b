/** The shared worker of all pages of a browser; it keeps the streams that they share. */

import { SharedStreams, type StreamRequest } from "./sharedStreams";

declare const self: { onconnect: ((event: MessageEvent) => void) | null };

const streams = new SharedStreams();

self.onconnect = ({ ports }) => {
  const [port] = ports;
  if (port) port.onmessage = ({ data }: MessageEvent<StreamRequest>) => streams.handle(port, data);
};
