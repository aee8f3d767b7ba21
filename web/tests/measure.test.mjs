// Microphone and motion sensors, fed by a file and by events.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, open, serve, settled } from "./site.mjs";
import { Release, csv } from "../release.js";

const RATE = 48_000;
/** A struck glass: silence, then 900 Hz that falls to a tenth in half a second. */
const FREQUENCY = 900;
const DECAY = 4.6;

/** Sound of 16 bits as a WAV file. */
function wav(samples) {
  const header = Buffer.alloc(44);
  header.write("RIFF", 0);
  header.writeUInt32LE(36 + 2 * samples.length, 4);
  header.write("WAVEfmt ", 8);
  header.writeUInt32LE(16, 16);
  header.writeUInt16LE(1, 20);
  header.writeUInt16LE(1, 22);
  header.writeUInt32LE(RATE, 24);
  header.writeUInt32LE(2 * RATE, 28);
  header.writeUInt16LE(2, 32);
  header.writeUInt16LE(16, 34);
  header.write("data", 36);
  header.writeUInt32LE(2 * samples.length, 40);
  const body = Buffer.alloc(2 * samples.length);
  samples.forEach((x, i) => body.writeInt16LE(Math.round(32_000 * Math.max(-1, Math.min(1, x))), 2 * i));
  return Buffer.concat([header, body]);
}

/** Noise from a linear congruence: the same every time. */
function noise(seed) {
  let state = seed;
  return () => (state = (state * 1_103_515_245 + 12_345) % 2_147_483_648) / 2_147_483_648 - 0.5;
}

/** Waits until the live trace of a sensor is drawn. */
const untilTraced = (page, sensor) =>
  page.waitForFunction((name) => {
    const canvas = document.getElementById(`${name}-status`).parentElement.querySelector("canvas");
    return canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some((v) => v > 0);
  }, sensor, { timeout: 10_000 });

let server;
before(async () => {
  server = await serve();
});
after(() => server?.close());

test("a struck glass is recorded from release to rest, and answered", async () => {
  const hiss = noise(1);
  const samples = Array.from({ length: 6 * RATE }, (_, i) => {
    const t = i / RATE - 2;
    return 0.0006 * hiss() + (t > 0 ? 0.7 * Math.exp(-DECAY * t) * Math.sin(2 * Math.PI * FREQUENCY * t) : 0);
  });
  const file = join(mkdtempSync(join(tmpdir(), "slipfit-")), "glass.wav");
  writeFileSync(file, wav(samples));
  const browser = await launch(["--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream", `--use-file-for-fake-audio-capture=${file}%noloop`]);
  try {
    const { page, problems } = await open(browser, server.address, { permissions: ["microphone"] });
    await page.click("#tab-measure");
    await page.click("#microphone-start");
    const { json, error } = await settled(page, "microphone.csv", 60_000);
    assert.equal(error, null);
    const { parameters } = JSON.parse(json);
    assert.ok(Math.abs(parameters.frequency_hz.value - FREQUENCY) < 0.5, JSON.stringify(parameters.frequency_hz));
    assert.ok(Math.abs(parameters.decay_rate_per_s.value - DECAY) < 0.1 * DECAY, JSON.stringify(parameters.decay_rate_per_s));
    await page.click("#tab-measure");
    const [saved] = await Promise.all([page.waitForEvent("download"), page.click("#microphone-save")]);
    assert.equal(saved.suggestedFilename(), "microphone.csv");
    assert.ok(readFileSync(await saved.path(), "utf8").startsWith("time (s),sound\n0,"));
    await untilTraced(page, "microphone");
    assert.deepEqual(problems, []);
  } finally {
    await browser.close();
  }
});

test("a refused microphone is told in words, and may be tried again", async () => {
  const browser = await launch(["--use-fake-device-for-media-stream", "--deny-permission-prompts"]);
  try {
    const { page } = await open(browser, server.address, { permissions: [] });
    await page.click("#tab-measure");
    await page.click("#microphone-start");
    await page.waitForFunction(() => document.querySelector("#microphone-status").textContent.includes("refused"));
    assert.ok(await page.isEnabled("#microphone-start"));
  } finally {
    await browser.close();
  }
});

test("motion events become a record; without any it is said", async () => {
  const browser = await launch();
  try {
    const { page } = await open(browser, server.address);
    await page.click("#tab-measure");
    await page.click("#motion-start");
    await page.waitForFunction(() => document.querySelector("#motion-status").textContent.includes("No motion"), null, { timeout: 10_000 });
    await page.click("#motion-start");
    // A browser may ask for a permission first; events sent before it listens are lost.
    await page.waitForFunction(() => document.querySelector("#motion-status").textContent.includes("Waiting"));
    await page.evaluate(() => {
      // A phone on a string, sampled at 60 Hz; the clock of an event is set by the test.
      let state = 7;
      const hiss = () => (state = (state * 1_103_515_245 + 12_345) % 2_147_483_648) / 2_147_483_648 - 0.5;
      for (let i = 0; i < 60 * 60; i++) {
        const t = i / 60 - 4;
        const swing = t > 0 ? 3 * Math.exp(-0.12 * t) * Math.cos(2 * Math.PI * 0.9 * t) : 0;
        const event = new Event("devicemotion");
        Object.defineProperty(event, "acceleration", { value: { x: swing + 0.01 * hiss(), y: 0.01 * hiss(), z: 0.01 * hiss() } });
        Object.defineProperty(event, "timeStamp", { value: 1000 * (i / 60) });
        dispatchEvent(event);
      }
    });
    if (await page.isEnabled("#motion-stop")) await page.click("#motion-stop");
    const { json, error } = await settled(page, "motion.csv", 30_000);
    assert.equal(error, null);
    const { parameters, input } = JSON.parse(json);
    assert.equal(input.kind, "acceleration");
    assert.ok(Math.abs(parameters.frequency_hz.value - 0.9) < 0.01, JSON.stringify(parameters.frequency_hz));
    assert.ok(Math.abs(parameters.decay_rate_per_s.value - 0.12) < 0.02, JSON.stringify(parameters.decay_rate_per_s));
    await untilTraced(page, "motion");
  } finally {
    await browser.close();
  }
});

test("a release begins the record shortly before it, rest ends it", () => {
  const release = new Release({ block_s: 0.02, rest_s: 0.25, most_s: 15 });
  const hiss = noise(3);
  let i = 0;
  while (release.state !== "done" && i < 10 * RATE) {
    const t = i / RATE - 1;
    release.add([i++ / RATE, 0.001 * hiss() + (t > 0 ? Math.exp(-5 * t) * Math.sin(2000 * t) : 0)]);
  }
  assert.equal(release.state, "done");
  const [first, last] = [release.rows[0][0], release.rows.at(-1)[0]];
  assert.ok(first > 0.7 && first < 1, String(first));
  assert.ok(last > 2 && last < 4, String(last));
  const text = csv(["time (s)", "sound"], release.rows);
  assert.ok(text.startsWith("time (s),sound\n0,"));
  assert.equal(text.trimEnd().split("\n").length, release.rows.length + 1);
});

test("silence alone is no release", () => {
  const release = new Release({ block_s: 0.02, rest_s: 0.25, most_s: 15 });
  const hiss = noise(5);
  for (let i = 0; i < 5 * RATE; i++) release.add([i / RATE, 0.001 * hiss()]);
  assert.equal(release.state, "waiting");
});
