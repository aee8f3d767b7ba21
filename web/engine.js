// Calls into the worker that holds the core.

export class Broken extends Error {}
export class Cancelled extends Error {}

/** Why there is no answer, with what would help. */
export class Refused extends Error {
  /** @param {{message: string, hints: Hint[]}} refusal */
  constructor({ message, hints }) {
    super(message);
    this.hints = hints;
  }
}

/** @typedef {{text: string, trace?: Float64Array}} Told */

/** @type {Worker | null} */
let worker = null;
/** The memory of a module never shrinks: one that held so much is ended before the next file. */
const KEPT_BYTES = 50e6;
let spent = false;
/** Whether the larger module is needed, which reads Arrow, HDF5, Parquet, workbooks and packed sound besides. */
let formats = false;
/** What the worker holds once it has done all it was told: a file, and what its answer was asked. */
/** @type {{file: Loaded, reference: Bytes | null, asked: string} | null} */
let held = null;
/** @type {Map<number, {resolve: (told: Told) => void, reject: (error: Error) => void}>} */
let waiting = new Map();
let last = 0;

function start() {
  worker = new Worker(new URL("worker.js", import.meta.url), { type: "module", name: formats ? "formats" : "" });
  const calls = (waiting = new Map());
  const fail = (/** @type {Error} */ error) => {
    end();
    for (const call of calls.values()) call.reject(error);
    calls.clear();
  };
  worker.onmessage = ({ data: { id, broken, ...told } }) => {
    if (broken !== undefined) return fail(new Broken(broken));
    calls.get(id)?.resolve(told);
    calls.delete(id);
  };
  worker.onerror = (event) => {
    event.preventDefault();
    fail(new Broken(event.message || "the worker could not be started"));
  };
}

function end() {
  worker?.terminate();
  worker = null;
  held = null;
  spent = false;
}

/**
 * @param {string} call
 * @param {...(string | Uint8Array)} args
 * @returns {Promise<Told>}
 */
function tell(call, ...args) {
  if (!worker) start();
  const id = ++last;
  return new Promise((resolve, reject) => {
    waiting.set(id, { resolve, reject });
    worker?.postMessage({ id, call, args });
  });
}

/** Hands a file to the worker, unless that is the one it holds. @param {Loaded} file */
function hold(file) {
  const { bytes, name, reference } = file;
  if (held?.file === file && held.reference === reference) return held;
  if (spent && !waiting.size) end();
  const both = [bytes, name, reference?.bytes ?? new Uint8Array(), reference?.name ?? ""];
  // What goes wrong here is told to the call that follows.
  tell("open", ...both).catch(() => {});
  spent ||= both.some((given) => given.length > KEPT_BYTES);
  held = { file, reference, asked: "" };
  return held;
}

/** The text of a function of the core as it stands. @param {string} call @param {...string} args */
export const raw = async (call, ...args) => (await tell(call, ...args)).text;

/** The same for functions that give JSON. @param {string} call @param {...string} args @returns {Promise<any>} */
export const ask = async (call, ...args) => result(await raw(call, ...args));

/** @param {string} text */
function result(text) {
  const told = JSON.parse(text);
  if (told.error) throw new Refused(told.error);
  return told;
}

/**
 * What the core says of a file.
 * @param {Loaded} file
 * @param {"preview" | "analyse"} call
 * @param {string} options
 * @returns {Promise<{told: any, trace?: Float64Array}>}
 */
export async function askOf(file, call, options) {
  hold(file).asked = call === "analyse" ? options : "";
  const { text, trace } = await tell(call, options);
  const told = JSON.parse(text);
  if (!told.error) return { told, trace };
  if (!told.error.with_formats || formats) throw new Refused(told.error);
  formats = true;
  end();
  return askOf(file, call, options);
}

/**
 * A report, figure or table of a file's answer. The answer is made again where the worker has gone on to another.
 * @param {Loaded} file
 * @param {string} what
 * @returns {Promise<string>}
 */
export async function output(file, what) {
  const again = hold(file).asked === file.asked ? null : askOf(file, "analyse", file.asked);
  const [{ text }] = await Promise.all([tell("output", what), again]);
  return result(text);
}

/** Ends whatever runs; the next call starts anew. A worker that waits is kept: its code is compiled. */
export function cancel() {
  if (!waiting.size) return;
  const calls = waiting;
  end();
  waiting = new Map();
  for (const call of calls.values()) call.reject(new Cancelled());
}
