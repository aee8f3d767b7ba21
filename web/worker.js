// The core, away from the thread that draws. One call at a time; whoever cannot wait ends the worker.
const module = self.name === "formats" ? "./slipfit_wasm_formats.js" : "./slipfit_wasm.js";
const ready = import(module).then(async (slipfit) => {
  await slipfit.default();
  return slipfit;
});

/** @type {any} */
let session = null;
/** Calls about the file that the core holds; the others are functions of the core. */
/** @type {Record<string, (...args: any[]) => {text: string, trace?: Float64Array}>} */
const ofSession = {
  open(slipfit, ...file) {
    session?.free();
    session = null;
    session = new slipfit.Session(...file);
    return { text: "" };
  },
  preview: (_, options) => ({ text: session.preview(options) }),
  analyse: (_, options) => ({ text: session.analyse(options), trace: session.trace() }),
  output: (_, what) => ({ text: session.output(what) }),
};

/** Rounds of practice, and the time before each of them for calls that have come. */
const ROUNDS = 8;
const PAUSE_MS = 50;
const PRACTICE_ROWS = 10_000;
/** Whether a file has come. */
let wanted = false;

/** A decay by friction and damping with some noise, as a logger writes it. */
function practice() {
  const rows = ["time (s),x (mm)"];
  for (let i = 0; i < PRACTICE_ROWS; i++) {
    const noise = ((i * 7919) % 1009) / 1009 - 0.5;
    rows.push(`${i / 50},${((10 * Math.exp(-i / PRACTICE_ROWS) - 3) * Math.cos(0.26 * i) + 0.02 * noise).toFixed(4)}`);
  }
  return new TextEncoder().encode(rows.join("\n"));
}

/** Before the first file comes, while nobody waits: what runs often is compiled for speed by then. */
async function practise() {
  const slipfit = await ready;
  const bytes = practice();
  for (let i = 0; i < ROUNDS; i++) {
    await new Promise((done) => setTimeout(done, PAUSE_MS));
    if (wanted) return;
    const own = new slipfit.Session(bytes, "", new Uint8Array(), "");
    own.preview("{}");
    own.analyse("{}");
    own.trace();
    own.free();
  }
}
practise().catch(() => {});

self.onmessage = async ({ data: { id, call, args } }) => {
  try {
    wanted ||= call in ofSession;
    const slipfit = await ready;
    const { text, trace } = ofSession[call]?.(slipfit, ...args) ?? { text: slipfit[call](...args) };
    self.postMessage({ id, text, trace }, { transfer: trace ? [trace.buffer] : [] });
  } catch (error) {
    // A panic ends the instance: the page starts another.
    self.postMessage({ id, broken: String(error) });
  }
};
