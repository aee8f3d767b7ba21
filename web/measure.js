// Microphone and motion sensors: a live trace, a release, rest, and the answer.
import { el, save, text } from "./dom.js";
import { Release, csv } from "./release.js";

/** @typedef {(row: number[]) => void} Add */
/** @typedef {(error?: unknown) => Promise<void>} Finish */
/**
 * @typedef {object} Sensor
 * @property {string[]} headers
 * @property {{block_s: number, rest_s: number, most_s: number}} limits
 * @property {number} fewest samples that are worth an analysis
 * @property {(add: Add, fail: Finish) => Promise<() => Promise<void>>} open gives what closes it
 */

/** @type {Record<string, Sensor>} */
const SENSORS = {
  microphone: {
    headers: ["time (s)", "sound"],
    limits: { block_s: 0.02, rest_s: 0.25, most_s: 15 },
    fewest: 2000,
    open: openMicrophone,
  },
  motion: {
    headers: ["time (s)", "acceleration x (m/s2)", "acceleration y (m/s2)", "acceleration z (m/s2)"],
    limits: { block_s: 0.5, rest_s: 3, most_s: 180 },
    fewest: 40,
    open: openMotion,
  },
};
/** No event for so long: there is no sensor. */
const SILENT_MS = 3000;

/** Hands every sample to `add`; gives back what closes the sensor. @param {Add} add */
async function openMicrophone(add) {
  if (!navigator.mediaDevices?.getUserMedia) throw new Error("missing");
  const audio = { echoCancellation: false, noiseSuppression: false, autoGainControl: false, channelCount: 1 };
  const stream = await navigator.mediaDevices.getUserMedia({ audio });
  const context = new AudioContext();
  const close = () => {
    stream.getTracks().forEach((track) => track.stop());
    return context.close();
  };
  try {
    await context.audioWorklet.addModule(new URL("recorder.js", import.meta.url));
    const node = new AudioWorkletNode(context, "recorder", { numberOfOutputs: 0 });
    let at = 0;
    node.port.onmessage = ({ data }) => {
      for (const value of data) add([at++ / context.sampleRate, value]);
    };
    context.createMediaStreamSource(stream).connect(node);
    await context.resume();
  } catch (error) {
    await close();
    throw error;
  }
  return close;
}

/** @param {Add} add @param {Finish} fail */
async function openMotion(add, fail) {
  if (!("DeviceMotionEvent" in window)) throw new Error("missing");
  // Asked for on the phones of one maker.
  const { requestPermission } = /** @type {{requestPermission?: () => Promise<string>}} */ (/** @type {unknown} */ (DeviceMotionEvent));
  if (requestPermission && (await requestPermission.call(DeviceMotionEvent)) !== "granted") {
    throw new DOMException("", "NotAllowedError");
  }
  const silent = setTimeout(() => fail(new Error("silent")), SILENT_MS);
  const told = (/** @type {DeviceMotionEvent} */ { acceleration, accelerationIncludingGravity: heavy, timeStamp }) => {
    const a = acceleration?.x === null || !acceleration ? heavy : acceleration;
    if (!a || a.x === null || a.y === null || a.z === null) return;
    clearTimeout(silent);
    add([timeStamp / 1000, a.x, a.y, a.z]);
  };
  addEventListener("devicemotion", told);
  return async () => {
    clearTimeout(silent);
    removeEventListener("devicemotion", told);
  };
}

/** The last seconds, drawn as they come. @param {HTMLCanvasElement} canvas */
function liveTrace(canvas) {
  /** @type {number[]} */
  let values = [];
  let waiting = false;
  const draw = () => {
    waiting = false;
    const { width, height } = canvas;
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, width, height);
    const largest = values.reduce((most, v) => Math.max(most, Math.abs(v)), 1e-9);
    context.strokeStyle = getComputedStyle(canvas).color;
    context.lineWidth = 1.5;
    context.beginPath();
    const step = Math.max(1, Math.floor(values.length / width / 4));
    for (let i = 0; i < values.length; i += step) {
      const x = (i / values.length) * width;
      const y = (0.5 - (0.45 * values[i]) / largest) * height;
      if (i) context.lineTo(x, y);
      else context.moveTo(x, y);
    }
    context.stroke();
  };
  return (/** @type {number} */ value) => {
    values.push(value);
    if (values.length > 60_000) values = values.slice(-48_000);
    if (!waiting) {
      waiting = true;
      requestAnimationFrame(draw);
    }
  };
}

/** @typedef {(name: string, bytes: Uint8Array<ArrayBuffer>) => Promise<void>} Analyse takes a finished record */

/** Fills the section. @param {HTMLElement} host @param {Analyse} analyse */
export function setUp(host, analyse) {
  host.append(el("h2", {}, text("measure.title")));
  if (!window.isSecureContext) host.append(el("p", { class: "error" }, text("measure.secure")));
  for (const name of Object.keys(SENSORS)) host.append(sensor(name, analyse));
}

/** @param {string} name @param {Analyse} analyse */
function sensor(name, analyse) {
  const { headers, limits, fewest, open } = SENSORS[name];
  const said = el("p", { role: "status", "aria-live": "polite", id: `${name}-status` });
  const canvas = el("canvas", { width: 900, height: 140, role: "img", "aria-label": `${text(`measure.${name}`)}: ${text("measure.trace")}` });
  const start = el("button", { type: "button", id: `${name}-start` }, text("measure.start"));
  const stop = el("button", { type: "button", id: `${name}-stop`, disabled: true }, text("measure.stop"));
  const keep = el("button", { type: "button", id: `${name}-save`, disabled: true }, text("measure.save"));
  let content = "";

  keep.addEventListener("click", () => save(text("measure.names")[name], content, "text/csv"));
  start.addEventListener("click", async () => {
    start.disabled = true;
    keep.disabled = true;
    const release = new Release(limits);
    const trace = liveTrace(canvas);
    /** @type {(() => Promise<void>) | null} */
    let close = null;
    let ended = false;
    /** @type {Finish} */
    const finish = async (error) => {
      if (ended) return;
      ended = true;
      stop.disabled = true;
      await close?.();
      start.disabled = false;
      if (error) {
        said.textContent = why(error);
        return;
      }
      const { rows } = release;
      if (rows.length < fewest) {
        said.textContent = text("measure.short");
        return;
      }
      content = csv(headers, rows);
      keep.disabled = false;
      said.textContent = text("measure.done")(rows.length, rows[rows.length - 1][0] - rows[0][0]);
      await analyse(text("measure.names")[name], new TextEncoder().encode(content));
    };
    /** @type {Add} */
    const add = (row) => {
      if (ended) return;
      trace(row.slice(1).reduce((most, v) => (Math.abs(v) > Math.abs(most) ? v : most), 0));
      const before = release.state;
      const state = release.add(row);
      if (state === "recording") {
        const told = text("measure.recording")(release.seconds);
        if (before !== state || release.rows.length % 500 === 0) said.textContent = told;
      }
      if (state === "done") finish();
    };
    stop.onclick = () => finish();
    try {
      close = await open(add, finish);
      if (ended) return void (await close());
      stop.disabled = false;
      said.textContent = text("measure.waiting");
    } catch (error) {
      finish(error);
    }
  });
  return el(
    "section",
    { class: "sensor" },
    el("h3", {}, text(`measure.${name}`)),
    el("p", {}, text(`measure.${name}Help`)),
    el("div", { class: "buttons" }, start, stop, keep),
    said,
    canvas,
  );
}

/** @param {unknown} problem @returns {string} */
function why(problem) {
  const error = problem instanceof Error || problem instanceof DOMException ? problem : new Error(String(problem));
  if (!window.isSecureContext) return text("measure.secure");
  if (error.name === "NotAllowedError" || error.name === "SecurityError") return text("measure.refused");
  if (error.message === "silent") return text("measure.silent");
  if (error.message === "missing" || error.name === "NotFoundError") return text("measure.missing");
  return `${text("measure.missing")} (${error.message})`;
}
