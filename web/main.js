// The page: files in, answers out.
import { answered, hints } from "./answer.js";
import { el, fillTexts, text } from "./dom.js";
import { Broken, Cancelled, Refused, askOf, cancel, output, raw } from "./engine.js";
import { setUp as setUpMeasure } from "./measure.js";
import { optionsForm } from "./options.js";
import { setUp as setUpSimulate } from "./simulate.js";

/** A page of 32 bits holds a file and what is made of it. */
const MOST_BYTES = 700e6;
const EXAMPLES = [
  ["pendulum", "classroom_pendulum.csv"],
  ["fork", "tuning_fork_9nN.csv"],
  ["viscous", "viscous_decay.csv"],
  ["beat", "two_modes.csv"],
  ["resonance", "tuning_fork_9nN_sweep.csv", "tuning_fork_free_sweep.csv"],
  ["levels", "tuning_fork_9nN_levels.csv"],
];

/** What stands in index.html. @param {string} id */
const part = (id) => /** @type {HTMLElement} */ (document.getElementById(id));
/** @param {string} message */
const status = (message) => void (part("status").textContent = message);
/** @type {Loaded[]} */
const files = [];
/** @type {Loaded | null} */
let current = null;
/** @type {Plot[]} */
let kept = [];
/** Counts runs, so that one overtaken by another says nothing any more. */
let run = 0;

function linkOptions() {
  try {
    const given = new URLSearchParams(location.hash.slice(1)).get("options");
    return given ? JSON.parse(given) : {};
  } catch {
    return {};
  }
}

/** @param {Record<string, any>} options */
const link = (options) => {
  const page = new URL(location.href);
  page.hash = Object.keys(options).length ? new URLSearchParams({ options: JSON.stringify(options) }).toString() : "";
  return page.href;
};

/** @param {string} name @param {Uint8Array<ArrayBuffer>} bytes @returns {Loaded} */
const loaded = (name, bytes) => ({ name, bytes, options: {}, reference: null, seen: null, asked: "", answer: null, json: null, error: null, formOpen: false, took: 0 });

/**
 * Takes in a file and analyses it.
 * @param {string} name
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @param {{options?: Record<string, any>, reference?: Bytes | null, begun?: number}} how `begun` is when it was dropped
 */
export async function take(name, bytes, { options = linkOptions(), reference = null, begun = performance.now() } = {}) {
  const file = { ...loaded(name, bytes), options: { ...options }, reference };
  files.push(file);
  current = file;
  listFiles();
  await work(file, begun);
}

/** @param {string} name @param {number} size */
const tooLarge = (name, size) => text("work.tooLarge")(name, `${Math.round(size / 1e6)} MB`);

/** @param {Iterable<File>} list */
async function takeFiles(list) {
  show("analyse");
  for (const chosen of list) {
    if (chosen.size > MOST_BYTES) {
      await select(refusedFile(chosen.name, tooLarge(chosen.name, chosen.size)), false);
      continue;
    }
    status(text("work.reading")(chosen.name));
    try {
      const begun = performance.now();
      await take(chosen.name, new Uint8Array(await chosen.arrayBuffer()), { begun });
    } catch (error) {
      await select(refusedFile(chosen.name, `${chosen.name}: ${error instanceof Error ? error.message : error}`), false);
    }
  }
}

/** @param {string} name @param {string} message */
function refusedFile(name, message) {
  const file = { ...loaded(name, new Uint8Array()), error: { message, hints: [] } };
  files.push(file);
  return file;
}

/** @param {Loaded} file @param {boolean} analyse */
async function select(file, analyse) {
  current = file;
  listFiles();
  if (analyse) await work(file);
  else draw(file);
}

/** @param {Loaded} file @param {number} begun */
async function work(file, begun = performance.now()) {
  const mine = ++run;
  const went = () => mine !== run;
  cancel();
  status("");
  part("working").hidden = false;
  part("problem").replaceChildren();
  document.body.setAttribute("aria-busy", "true");
  const chosen = JSON.stringify(file.options);
  try {
    part("working-text").textContent = text("work.reading")(file.name);
    file.error = null;
    const { told: seen } = await askOf(file, "preview", chosen);
    file.seen = /** @type {Preview} */ (seen);
    if (went()) return;
    part("working-text").textContent = text("work.analysing")(file.name);
    const asked = JSON.stringify({ analysis: seen.analysis, ...file.options });
    const { told: answer, trace } = await askOf(file, "analyse", asked);
    if (went()) return;
    file.asked = asked;
    file.answer = /** @type {Answered} */ (answer);
    file.json = JSON.parse(answer.json);
    answer.trace = trace ? traced(trace, file.json) : null;
  } catch (error) {
    if (went()) return;
    file.answer = null;
    file.json = null;
    if (error instanceof Refused) file.error = { message: error.message, hints: error.hints };
    else if (error instanceof Cancelled) file.error = { message: text("work.cancelled"), hints: [] };
    else if (error instanceof Broken) file.error = { message: text("work.broken")(file.name, error.message), hints: [] };
    else throw error;
  } finally {
    if (!went()) {
      part("working").hidden = true;
      document.body.removeAttribute("aria-busy");
    }
  }
  if (current === file) draw(file);
  file.took = performance.now() - begun;
  status(text(file.answer ? "work.done" : "work.failed")(file.name));
}

/**
 * Instants, signal and fit, which come one after another.
 * @param {Float64Array} samples
 * @param {any} json
 * @returns {Trace}
 */
function traced(samples, json) {
  const [time_s, signal, fitted] = [0, 1, 2].map((k) => samples.subarray((k * samples.length) / 3, ((k + 1) * samples.length) / 3));
  const known = Array.from(fitted, (value) => (Number.isNaN(value) ? null : value));
  return { time_s, signal, fitted: known, unit: json.signal_unit, used_s: json.input.time_range_used_s };
}

/** @type {Apply} */
function apply(option, value, quietly = false) {
  if (!current) return;
  if (value === null) delete current.options[option];
  else current.options[option] = value;
  if (!quietly) work(current);
}

/** @param {File | null} chosen */
async function setReference(chosen) {
  const file = current;
  if (!file) return;
  if (!chosen) {
    file.reference = null;
    return work(file);
  }
  file.reference = { name: chosen.name, bytes: new Uint8Array(await chosen.arrayBuffer()) };
  return work(file);
}

/** @param {Loaded} file */
function draw(file) {
  const focused = document.activeElement?.id;
  // Before anything changes: measured in between, everything would be laid out twice.
  const width = part("analyse").clientWidth;
  const typing = document.activeElement instanceof HTMLInputElement && document.activeElement.type === "text" ? document.activeElement.value : null;
  kept.forEach((plot) => plot.remove());
  kept = [];
  part("problem").replaceChildren();
  const result = part("result");
  result.hidden = false;
  const reset = () => {
    file.options = {};
    work(file);
  };
  const form = () => optionsForm(file, apply, reset, setReference);
  if (file.error) {
    const controls = file.seen && form();
    result.replaceChildren(controls ? el("section", {}, el("h2", {}, text("options.title")), controls) : "");
    const helps = file.error.hints.length ? [el("p", {}, text("refusal.helps")), hints(file.error.hints, apply, controls)] : [];
    part("problem").replaceChildren(el("p", { class: "error" }, file.error.message), ...helps);
  } else if (file.answer) {
    const how = { form: form(), apply, link: link(file.options), output: (/** @type {string} */ what) => output(file, what), status, kept, width };
    result.replaceChildren(el("div", {}, ...answered(file, file.answer, how)));
    part("take-link").addEventListener("click", () => setTimeout(() => status(text("take.linkNote"))));
  }
  const again = focused && part(focused);
  if (!again) return;
  again.focus();
  // What was being typed when the answer came is not lost.
  if (typing !== null && again instanceof HTMLInputElement && again.value !== typing) {
    again.value = typing;
    const finish = () => again.value === typing && again.dispatchEvent(new Event("change"));
    again.addEventListener("blur", finish, { once: true });
    again.addEventListener("keydown", (event) => void (event.key === "Enter" && finish()), { once: true });
  }
}

function listFiles() {
  const list = part("file-list");
  list.hidden = files.length < 2;
  const remove = (/** @type {Loaded} */ file) => {
    files.splice(files.indexOf(file), 1);
    if (current === file) {
      current = files.at(-1) ?? null;
      if (current) draw(current);
    }
    listFiles();
  };
  list.replaceChildren(
    el("span", {}, text("files.label")),
    ...files.map((file) =>
      el(
        "span",
        { class: "file" },
        el("button", { type: "button", "aria-pressed": String(file === current), onclick: () => select(file, !file.answer && !file.error) }, file.name),
        el("button", { type: "button", class: "quiet", "aria-label": text("files.remove")(file.name), onclick: () => remove(file) }, "×"),
      ),
    ),
  );
}

function setUpDrop() {
  const input = /** @type {HTMLInputElement} */ (part("files"));
  input.addEventListener("change", async () => {
    const chosen = [...(input.files ?? [])];
    input.value = "";
    await takeFiles(chosen);
  });
  addEventListener("dragover", (event) => {
    event.preventDefault();
    part("drop").classList.add("over");
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) part("drop").classList.remove("over");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    part("drop").classList.remove("over");
    takeFiles([...(event.dataTransfer?.files ?? [])]);
  });
}

function setUpExamples() {
  const fetched = async (/** @type {string} */ name) => new Uint8Array(await (await fetch(`examples/${name}`)).arrayBuffer());
  const open = async (/** @type {string} */ name, /** @type {string | undefined} */ free) => {
    const reference = free ? { name: free, bytes: await fetched(free) } : null;
    await take(name, await fetched(name), { options: {}, reference });
  };
  part("examples").replaceChildren(
    ...EXAMPLES.map(([key, name, free]) =>
      el("li", {}, el("button", { type: "button", id: `example-${key}`, onclick: () => open(name, free) }, text(`examples.list.${key}`))),
    ),
  );
}

/** The files named on the command line of `slipfit app`. */
async function takeHanded() {
  const handed = await (await fetch("handed.json")).json();
  for (const [i, { name }] of handed.entries()) {
    status(text("work.reading")(name));
    try {
      const response = await fetch(`handed/${i}`);
      if (!response.ok) throw new Error(await response.text());
      const size = Number(response.headers.get("content-length"));
      if (size > MOST_BYTES) {
        await response.body?.cancel();
        await select(refusedFile(name, tooLarge(name, size)), false);
        continue;
      }
      await take(name, new Uint8Array(await response.arrayBuffer()));
    } catch (error) {
      const why = error instanceof Error ? error.message : String(error);
      await select(refusedFile(name, `${text("work.gone")(name)} (${why.trim()})`), false);
    }
  }
}

const TABS = ["analyse", "measure", "simulate"];
const opened = new Set();

/** @param {string} name */
function show(name) {
  for (const tab of TABS) {
    part(tab).hidden = tab !== name;
    const button = part(`tab-${tab}`);
    button.setAttribute("aria-selected", String(tab === name));
    button.tabIndex = tab === name ? 0 : -1;
  }
  if (opened.has(name)) return;
  opened.add(name);
  const analyse = (/** @type {string} */ file, /** @type {Uint8Array<ArrayBuffer>} */ bytes) => {
    show("analyse");
    return take(file, bytes, { options: {} });
  };
  if (name === "measure") setUpMeasure(part("measure"), analyse);
  if (name === "simulate") setUpSimulate(part("simulate"), analyse);
}

function setUpTabs() {
  part("tabs").addEventListener("keydown", (event) => {
    const at = TABS.findIndex((tab) => part(`tab-${tab}`) === document.activeElement);
    /** @type {Record<string, number>} */
    const keys = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: TABS.length - 1 };
    const to = keys[event.key];
    if (at < 0 || to === undefined) return;
    event.preventDefault();
    const tab = TABS[(to + TABS.length) % TABS.length];
    show(tab);
    part(`tab-${tab}`).focus();
  });
  for (const tab of TABS) part(`tab-${tab}`).addEventListener("click", () => show(tab));
}

async function begin() {
  fillTexts();
  setUpTabs();
  setUpDrop();
  setUpExamples();
  part("cancel").addEventListener("click", cancel);
  part("enlarged-close").addEventListener("click", () => /** @type {HTMLDialogElement} */ (part("enlarged")).close());
  // A page from the command is there as long as the command runs, at another address every time.
  const handed = document.documentElement.dataset.app !== undefined;
  if (!handed && "serviceWorker" in navigator && window.isSecureContext) {
    navigator.serviceWorker.register("sw.js").catch(() => {});
    navigator.serviceWorker.ready.then(() => void (document.documentElement.dataset.offline = "ready"));
  }
  const rules = new CSSStyleSheet();
  rules.replaceSync(await raw("darkRules"));
  document.adoptedStyleSheets.push(rules);
  part("version").textContent = await raw("version");
  document.documentElement.dataset.ready = "yes";
  if (handed) await takeHanded();
}

// For the tests in web/tests, and for a person with a console.
window.slipfit = {
  get current() { return current; },
  take,
  output: (what) => (current ? output(current, what) : Promise.reject(new Error("no file"))),
};
begin();
