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

/** @type {Worker | null} */
let worker = null;
/** The memory of a module never shrinks: one that held so much is ended before the next file. */
const KEPT_BYTES = 50e6;
let spent = false;
/** Whether the larger module is needed, which reads Arrow, HDF5 and Parquet besides. */
let columns = false;
/** @type {Map<number, {resolve: (text: string) => void, reject: (error: Error) => void}>} */
let waiting = new Map();
let last = 0;

function start() {
  worker = new Worker(new URL("worker.js", import.meta.url), { type: "module", name: columns ? "columns" : "" });
  const calls = (waiting = new Map());
  const fail = (/** @type {Error} */ error) => {
    for (const call of calls.values()) call.reject(error);
    calls.clear();
  };
  worker.onmessage = ({ data: { id, text, broken } }) => {
    const call = calls.get(id);
    if (!call) return;
    calls.delete(id);
    if (broken === undefined) {
      call.resolve(text);
    } else {
      end();
      call.reject(new Broken(broken));
    }
  };
  worker.onerror = (event) => {
    event.preventDefault();
    end();
    fail(new Broken(event.message || "the worker could not be started"));
  };
}

function end() {
  worker?.terminate();
  worker = null;
  spent = false;
}

/**
 * Calls a function of the core with text and bytes; its text as it stands.
 * @param {string} call
 * @param {...(string | Uint8Array)} args
 * @returns {Promise<string>}
 */
export function raw(call, ...args) {
  if (!worker) start();
  spent ||= args.some((given) => given.length > KEPT_BYTES);
  const id = ++last;
  return new Promise((resolve, reject) => {
    waiting.set(id, { resolve, reject });
    worker?.postMessage({ id, call, args });
  });
}

/**
 * The same for functions that give JSON.
 * @param {string} call
 * @param {...(string | Uint8Array)} args
 * @returns {Promise<any>}
 */
export async function ask(call, ...args) {
  const result = JSON.parse(await raw(call, ...args));
  if (!result.error) return result;
  if (!result.error.with_columns || columns) throw new Refused(result.error);
  columns = true;
  end();
  return ask(call, ...args);
}

/** Ends whatever runs; the next call starts anew. A worker that waits is kept: its code is compiled. */
export function cancel() {
  if (!waiting.size && !spent) return;
  const calls = waiting;
  end();
  waiting = new Map();
  for (const call of calls.values()) call.reject(new Cancelled());
}
