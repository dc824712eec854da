// Reads a PNG of eight bits per channel, without interlacing, as browsers write them.

import { inflateSync } from "node:zlib";

const SIGNATURE = "89504e470d0a1a0a";

/** @returns {{width: number, height: number, channels: number, pixels: Uint8Array}} */
export function decode(bytes) {
  if (bytes.subarray(0, 8).toString("hex") !== SIGNATURE) {
    throw new Error("no PNG");
  }
  const data = [];
  let head = null;
  for (let at = 8; at < bytes.length; ) {
    const length = bytes.readUInt32BE(at);
    const kind = bytes.toString("latin1", at + 4, at + 8);
    const body = bytes.subarray(at + 8, at + 8 + length);
    if (kind === "IHDR") {
      head = { width: body.readUInt32BE(0), height: body.readUInt32BE(4), depth: body[8], colour: body[9], interlace: body[12] };
    } else if (kind === "IDAT") {
      data.push(body);
    }
    at += 12 + length;
  }
  const channels = { 2: 3, 6: 4 }[head?.colour];
  if (!channels || head.depth !== 8 || head.interlace !== 0) {
    throw new Error(`a PNG of another kind: ${JSON.stringify(head)}`);
  }
  const { width, height } = head;
  const packed = inflateSync(Buffer.concat(data));
  const stride = width * channels;
  const pixels = new Uint8Array(stride * height);
  for (let y = 0; y < height; y += 1) {
    const filter = packed[y * (stride + 1)];
    for (let x = 0; x < stride; x += 1) {
      const left = x >= channels ? pixels[y * stride + x - channels] : 0;
      const up = y > 0 ? pixels[(y - 1) * stride + x] : 0;
      const corner = x >= channels && y > 0 ? pixels[(y - 1) * stride + x - channels] : 0;
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
      pixels[y * stride + x] = packed[y * (stride + 1) + 1 + x] + guess;
    }
  }
  return { width, height, channels, pixels };
}

function paeth(left, up, corner) {
  const guess = left + up - corner;
  const [a, b, c] = [left, up, corner].map((value) => Math.abs(guess - value));
  return a <= b && a <= c ? left : b <= c ? up : corner;
}

/** Returns the number of pixels with about this colour, [red, green, blue]. */
export function countColour({ channels, pixels }, [red, green, blue], apart = 12) {
  let count = 0;
  for (let i = 0; i < pixels.length; i += channels) {
    const far = Math.max(Math.abs(pixels[i] - red), Math.abs(pixels[i + 1] - green), Math.abs(pixels[i + 2] - blue));
    count += far <= apart ? 1 : 0;
  }
  return count;
}
